"""Why there is no plan, as data: causes, and the smallest changes that would make one."""

from __future__ import annotations

import enum
from dataclasses import dataclass
from typing import Any, Protocol

from skiros_py.skills.conditions import Condition
from skiros_py.world.change import Writer
from skiros_py.world.transaction import Transaction
from skiros_py.world.world import World


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
class Cause:
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

    def as_json(self) -> dict[str, Any]:
        """Returns it as plain data."""
        return {
            "kind": str(self.kind),
            "text": self.text,
            "why": self.why,
            "conditions": [str(condition) for condition in self.conditions],
            "skill": self.skill,
            "precondition": self.precondition,
            "elements": list(self.elements),
        }


class Edit(Protocol):
    """One change to the scene."""

    def __str__(self) -> str:
        """Returns it as an instruction: "put starter_2 in pallet_a"."""
        ...

    @property
    def elements(self) -> tuple[str, ...]:
        """Ids of the elements involved."""
        ...

    def write(self, tx: Transaction) -> None:
        """Writes it into a transaction."""
        ...


@dataclass(frozen=True, slots=True)
class Exchange:
    """A goal condition to be replaced.

    Attributes:
        condition: The original condition.
        by: Its replacement.
    """

    condition: Condition
    by: Condition

    def __str__(self) -> str:
        return f"want {self.by} instead of {self.condition}"

    def as_json(self) -> dict[str, str]:
        """Returns it as plain data."""
        return {"condition": str(self.condition), "by": str(self.by)}


@dataclass(frozen=True, slots=True)
class Repair:
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
    edits: tuple[Edit, ...] = ()
    without: tuple[Condition, ...] = ()
    instead: tuple[Exchange, ...] = ()

    @property
    def done(self) -> str:
        """What applying it does, in the operator's words: the changes to the world, not to the goal."""
        return " and ".join(dict.fromkeys(map(str, self.edits)))

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
        with world.transaction(author, f"so that there is a plan: {self.text}", writer=writer, holder=holder) as tx:
            for edit in self.edits:
                edit.write(tx)

    def as_json(self) -> dict[str, Any]:
        """Returns it as plain data."""
        return {
            "text": self.text,
            "edits": [str(edit) for edit in self.edits],
            "without": [str(condition) for condition in self.without],
            "instead": [exchange.as_json() for exchange in self.instead],
            "elements": list(dict.fromkeys(name for edit in self.edits for name in edit.elements)),
        }
