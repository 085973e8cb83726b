"""A plan: an ordered list of skills with the parameters it depends on."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Any

from skiros_py.errors import PlanningError
from skiros_py.planning.domain.pddl import PddlTexts
from skiros_py.planning.reasons import Cause, Repair


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
        pddl: The plan of the PDDL task, one action per line, in the format of planners and validators.
        after: For each step the indices of the steps that must have ended before it starts; empty if they run
            strictly one after the other.
        starts: Planned start time of each step, from the start of the plan [s]; empty if unknown.
    """

    steps: tuple[Step, ...]
    pddl: tuple[str, ...] = field(default=(), compare=False)
    after: tuple[frozenset[int], ...] = ()
    starts: tuple[float, ...] = field(default=(), compare=False)

    @property
    def order(self) -> tuple[frozenset[int], ...]:
        """For each step the indices of the steps that must have ended before it starts."""
        return self.after or tuple(frozenset({i - 1} if i else ()) for i in range(len(self.steps)))

    def renamed(self, names: Mapping[str, str]) -> Plan:
        """Returns the plan with its elements renamed."""
        return replace(self, steps=tuple(step.renamed(names) for step in self.steps))

    def as_json(self) -> dict[str, Any]:
        """Returns it as plain data, without the PDDL."""
        return {
            "steps": [str(step) for step in self.steps],
            "calls": [{"skill": step.skill, "arguments": dict(step.arguments)} for step in self.steps],
            "after": [sorted(indices) for indices in self.order],
            "starts": list(self.starts),
        }

    def __str__(self) -> str:
        return "\n".join(f"{i:2}. {step}" for i, step in enumerate(self.steps, start=1))


@dataclass(frozen=True, slots=True)
class NoPlan:
    """There is no plan.

    Attributes:
        reasons: Why, in the operator's words: one for each condition that cannot be reached.
        causes: The same as data.
        repairs: The smallest changes that make a plan possible, verified by planning.
    """

    reasons: tuple[str, ...]
    causes: tuple[Cause, ...] = field(default=(), compare=False)
    repairs: tuple[Repair, ...] = field(default=(), compare=False)

    def as_json(self) -> dict[str, Any]:
        """Returns it as plain data."""
        return {
            "reasons": list(self.reasons),
            "causes": [cause.as_json() for cause in self.causes],
            "repairs": [repair.as_json() for repair in self.repairs],
        }


def read_plan(
    lines: tuple[tuple[str, ...], ...], texts: PddlTexts, keys: Mapping[str, tuple[str, ...]]
) -> tuple[Step, ...]:
    """Turns a planner's answer back into skills; omits auxiliary actions and parameters that are not passed on.

    Args:
        lines: Action name and objects of each step, in PDDL names.
        texts: The task as written.
        keys: Keys of the parameters to pass, by skill.

    Raises:
        PlanningError: The answer names an action or object that the task does not have.
    """
    steps: list[Step] = []
    for name, *objects in lines:
        try:
            action = texts.actions[name.lower()]
            ids = [texts.objects.back(o) for o in objects]
        except KeyError as error:
            raise PlanningError(f"the planner answered with {error}, which is not in the task") from error
        if action.skill is not None:
            own = {variable.name.lstrip("?"): id_ for variable, id_ in zip(action.parameters, ids, strict=True)}
            steps.append(Step(action.skill, MappingProxyType({key: own[key] for key in keys[action.skill]})))
    return tuple(steps)
