"""A plan: an ordered list of skills with the parameters it depends on; or the reasons why there is none, as data."""

from __future__ import annotations

import enum
from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from types import MappingProxyType
from typing import Any

from skiros_py.messages import Message, all_of
from skiros_py.planning.domain.model import Grounding
from skiros_py.planning.edits import SceneEdit
from skiros_py.skills.conditions import Condition
from skiros_py.world.change import Writer
from skiros_py.world.world import World


class _PlainData:
    """A dataclass that is shown as data: conditions and edits as text."""

    __slots__ = ()

    def as_json(self) -> dict[str, Any]:
        """Returns it as plain data."""
        return {one.name: _plain(getattr(self, one.name)) for one in fields(self)}  # type: ignore[arg-type]


def _plain(value: object) -> object:
    match value:
        case tuple():
            return [_plain(one) for one in value]
        case _PlainData():
            return value.as_json()
        case None:
            return None
        case _:
            return str(value)


class CauseKind(enum.StrEnum):
    """The kind of cause."""

    NO_SKILL = "no skill"
    """No available robot has a skill that achieves it."""
    MISSING_FACT = "missing fact"
    """A fact that no skill can change does not hold."""
    MISSING_ELEMENT = "missing element"
    """There is no thing of the required class."""
    TOO_FEW = "too few"
    """There are such things, but fewer than required."""
    FULL = "full"
    """The place is occupied, and no skill can clear it."""
    DOES_NOT_FIT = "does not fit"
    """The thing does not fit into any existing place."""
    CONTRADICTION = "contradiction"
    """Conditions of the goal exclude each other."""
    CONFLICT = "conflict"
    """Each condition is reachable alone, but not all of them together."""


@dataclass(frozen=True, slots=True)
class Cause(_PlainData):
    """One reason.

    Attributes:
        kind: What kind of reason.
        text: The full reason in the operator's words.
        conditions: The goal conditions it makes unreachable.
        skill: The skill that would achieve them; None if there is none.
        precondition: The unreachable precondition of that skill, in words; empty if that is not the cause.
        elements: The elements and classes involved, ids or CURIEs.
        why: The core reason, without the conditions and the chain leading to it; empty if they say it all.
    """

    kind: CauseKind
    text: str
    conditions: tuple[Condition, ...] = ()
    skill: str | None = None
    precondition: str = ""
    elements: tuple[str, ...] = ()
    why: str = ""


@dataclass(frozen=True, slots=True)
class Exchange(_PlainData):
    """A goal condition to be replaced.

    Attributes:
        condition: The original condition.
        by: Its replacement.
    """

    condition: Condition
    by: Condition

    def __str__(self) -> str:
        return Message("want {by} instead of {condition}", by=self.by, condition=self.condition)


@dataclass(frozen=True, slots=True)
class Repair(_PlainData):
    """A minimal change that makes a plan possible.

    Repairs with edits or goal changes were verified by planning. Others cannot be made in the scene: they name
    something the user has to arrange, such as a missing skill of a robot.

    Attributes:
        text: What to do, in the operator's words.
        edits: The changes to the world.
        without: Conditions to remove from the goal.
        instead: Conditions to replace.
    """

    text: str
    edits: tuple[SceneEdit, ...] = ()
    without: tuple[Condition, ...] = ()
    instead: tuple[Exchange, ...] = ()

    @property
    def done(self) -> str:
        """What applying it does, in the operator's words: the changes to the world, not to the goal."""
        return all_of(list(dict.fromkeys(map(str, self.edits))))

    def apply(self, world: World, author: str = "repair", writer: Writer = Writer.PERSON, holder: str = "") -> None:
        """Applies the changes to the world in one transaction; changing the goal is up to the caller.

        Args:
            world: The world.
            author: Who decided it.
            writer: What kind of author that is.
            holder: The lock holder, if different from the author.

        Raises:
            WorldError: The world has changed so that it cannot be applied; nothing is changed then.
            Locked: Another user has locked one of the elements.
        """
        if not self.edits:
            return
        with world.transaction(
            author, Message("so that there is a plan: {text}", text=self.text), writer=writer, holder=holder
        ) as tx:
            for edit in self.edits:
                edit.write(tx)

    def as_json(self) -> dict[str, Any]:
        """Returns it as plain data."""
        elements = dict.fromkeys(name for edit in self.edits for name in edit.elements)
        return {**_PlainData.as_json(self), "elements": list(elements)}


@dataclass(frozen=True, slots=True)
class Step:
    """One skill to run.

    Attributes:
        skill: Its name.
        arguments: Element id by parameter key; omitted ones are inferred when it starts.
    """

    skill: str
    arguments: Mapping[str, str]

    def renamed(self, names: Mapping[str, str]) -> Step:
        """Returns the step with its elements renamed."""
        if names.keys().isdisjoint(self.arguments.values()):
            return self
        return replace(self, arguments=MappingProxyType({k: names.get(v, v) for k, v in self.arguments.items()}))

    def __str__(self) -> str:
        return f"{self.skill}({', '.join(f'{key}={value}' for key, value in self.arguments.items())})"


@dataclass(frozen=True, slots=True)
class Plan:
    """Steps that lead to the goal, validated by replay.

    Attributes:
        steps: The skills to run.
        groundings: The plan as actions of the task, with the goal's bookkeeping at its end; empty if the task is
            stricter than the conditions, which decide, and has no such plan.
        after: For each step the indices of the steps that must have ended before it starts; empty if they run
            strictly one after the other.
        starts: Planned start time of each step, from the start of the plan [s]; empty if unknown.
        seconds: Expected time until all have succeeded [s]; None if unknown.
        chance: The probability that all succeed at the first attempt; None if nothing was learned.
    """

    steps: tuple[Step, ...]
    groundings: tuple[Grounding, ...] = field(default=(), compare=False, repr=False)
    after: tuple[frozenset[int], ...] = ()
    starts: tuple[float, ...] = field(default=(), compare=False)
    seconds: float | None = field(default=None, compare=False)
    chance: float | None = field(default=None, compare=False)

    @property
    def order(self) -> tuple[frozenset[int], ...]:
        """For each step the indices of the steps that must have ended before it starts."""
        return self.after or tuple(frozenset({i - 1} if i else ()) for i in range(len(self.steps)))

    def renamed(self, names: Mapping[str, str]) -> Plan:
        """Returns the plan with its elements renamed."""
        return replace(self, steps=tuple(step.renamed(names) for step in self.steps))

    def as_json(self) -> dict[str, Any]:
        """Returns it as plain data, without the actions."""
        return {
            "steps": [str(step) for step in self.steps],
            "calls": [{"skill": step.skill, "arguments": dict(step.arguments)} for step in self.steps],
            "after": [sorted(indices) for indices in self.order],
            "starts": list(self.starts),
            "seconds": self.seconds,
            "chance": self.chance,
        }

    def __str__(self) -> str:
        return "\n".join(f"{i:2}. {step}" for i, step in enumerate(self.steps, start=1))


@dataclass(frozen=True, slots=True)
class NoPlan(_PlainData):
    """There is no plan.

    Attributes:
        reasons: Why, in the operator's words: one for each condition that cannot be reached.
        causes: The same as data.
        repairs: The smallest changes that make a plan possible, verified by planning.
    """

    reasons: tuple[str, ...]
    causes: tuple[Cause, ...] = field(default=(), compare=False)
    repairs: tuple[Repair, ...] = field(default=(), compare=False)
