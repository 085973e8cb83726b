"""The report on a goal."""

from __future__ import annotations

import enum
from dataclasses import dataclass, replace


class Outcome(enum.StrEnum):
    """How a task ended."""

    REACHED = "reached"
    """Every condition holds, and something was done for it."""
    HELD_ALREADY = "held already"
    """Every condition held before anything was done."""
    PARTLY_REACHED = "partly reached"
    """Some conditions were achieved; each missing one has its reason."""
    NOT_REACHED = "not reached"
    """No condition was achieved, or the task ended early."""
    NO_PLAN = "no plan"
    """There was no plan from the start: nothing was done."""
    STOPPED = "stopped"
    """It was stopped by a command."""


@dataclass(frozen=True, slots=True)
class StepReport:
    """One executed skill.

    Attributes:
        skill: Its name.
        arguments: Element id by parameter key.
        start, end: Run time [s].
        reason: Why it failed; empty on success.
        agent: Id of the subsystem that ran it.
    """

    skill: str
    arguments: dict[str, str]
    start: float
    end: float
    reason: str = ""
    agent: str = ""


@dataclass(frozen=True, slots=True)
class ConditionReport:
    """One condition of the goal.

    Attributes:
        condition: As written.
        believed: Whether it holds in the world model.
        true: Whether it holds in the simulator's ground truth; None if there is none.
        tries: How many attempts were made before it held or was given up; 0 if it held already.
        reason: Why it is missing; empty when it holds.
        simulated: Run time from which it held in the world model until the end [s]; None while it does not.
        wall: Wall time at that moment [s].
    """

    condition: str
    believed: bool
    true: bool | None
    tries: int
    reason: str = ""
    simulated: float | None = None
    wall: float | None = None


@dataclass(frozen=True, slots=True)
class GoalReport:
    """The final report of a task.

    Attributes:
        conditions: One report each.
        steps: Every executed skill, in order; if there are very many, only the last ones.
        simulated: Run time used [s].
        wall: Wall time used [s].
        no_plan: Why there was no initial plan; empty if there was one.
        stopped: True if it was stopped by a command.
        digest: Hash over joint states and world changes; equal runs have equal digests.
        fault: Why it ended early without being stopped, such as a planner failure or an infeasible sequence.
        forgotten: How many earlier steps were dropped.
    """

    conditions: tuple[ConditionReport, ...]
    steps: tuple[StepReport, ...]
    simulated: float
    wall: float
    no_plan: tuple[str, ...] = ()
    stopped: bool = False
    digest: str = ""
    fault: str = ""
    forgotten: int = 0

    @property
    def reached(self) -> bool:
        """True if every condition holds: in the ground truth if available, otherwise in the world model."""
        return not (self.stopped or self.fault) and all(map(_holds, self.conditions))

    @property
    def outcome(self) -> Outcome:
        """The overall outcome."""
        if self.stopped:
            return Outcome.STOPPED
        if self.reached:
            return Outcome.REACHED if self.steps else Outcome.HELD_ALREADY
        if self.no_plan:
            return Outcome.NO_PLAN
        brought = any(_holds(c) and c.tries for c in self.conditions)
        return Outcome.PARTLY_REACHED if brought and not self.fault else Outcome.NOT_REACHED

    def with_truth(self, truths: tuple[bool | None, ...]) -> GoalReport:
        """Returns the report with the simulator's ground truth, if any, added to each condition."""
        pairs = zip(self.conditions, truths, strict=True)
        return replace(self, conditions=tuple(replace(c, true=t) for c, t in pairs))

    def __str__(self) -> str:
        lines = [_line(c) for c in self.conditions]
        verdict = "reached" if self.reached else "stopped" if self.stopped else "not reached"
        lines += [f"no plan: {reason}" for reason in self.no_plan]
        lines += [self.fault] if self.fault else []
        return "\n".join([*lines, f"goal {verdict} in {self.simulated:.1f} s simulated, {self.wall:.1f} s wall"])


def _holds(c: ConditionReport) -> bool:
    return c.believed if c.true is None else c.true


def _line(c: ConditionReport) -> str:
    truth = "" if c.true is None else f", truth {'yes' if c.true else 'no'}"
    tail = f" ({c.reason})" if c.reason else ""
    return f"{c.condition}: believed {'yes' if c.believed else 'no'}{truth}, tries {c.tries}{tail}"
