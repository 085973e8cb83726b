"""What came of a goal."""

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
    """Something was brought about; each missing condition has its reason."""
    NOT_REACHED = "not reached"
    """Nothing of it was brought about, or it ended before its time."""
    NO_PLAN = "no plan"
    """There was no plan from the start: nothing was done."""
    STOPPED = "stopped"
    """Somebody stopped it."""


@dataclass(frozen=True, slots=True)
class StepReport:
    """One skill that was run.

    Attributes:
        skill: Its name.
        arguments: Element id by parameter key.
        start, end: Run time [s].
        reason: Why it failed; empty when it worked.
        agent: Id of the subsystem that did it.
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
        true: Whether it holds in the simulator's truth; None if nothing physical was there to ask.
        tries: How often a skill was tried for it before it held or was given up; 0 when it held already.
        reason: Why it is missing; empty when it holds.
        simulated: Run time after which it was believed for good [s]; None while it is not.
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
    """The end of a task.

    Attributes:
        conditions: One report each.
        steps: Every skill that was run, in order; of very many the last.
        simulated: Run time used [s].
        wall: Wall time used [s].
        no_plan: Reasons why there was no plan at all at the start; empty when there was one.
        stopped: True when somebody stopped it.
        digest: Hash over joint states and world changes; equal runs have equal digests.
        fault: Why it ended before its time, where nobody stopped it: a planner that broke, a sequence that cannot work.
        forgotten: How many skills were run before the steps that are kept.
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
        """True when every condition holds: by the truth where there is one, else by belief."""
        return not (self.stopped or self.fault) and all(map(_holds, self.conditions))

    @property
    def outcome(self) -> Outcome:
        """The whole of it in two words."""
        if self.stopped:
            return Outcome.STOPPED
        if self.reached:
            return Outcome.REACHED if self.steps else Outcome.HELD_ALREADY
        if self.no_plan:
            return Outcome.NO_PLAN
        brought = any(_holds(c) and c.tries for c in self.conditions)
        return Outcome.PARTLY_REACHED if brought and not self.fault else Outcome.NOT_REACHED

    def with_truth(self, truths: tuple[bool | None, ...]) -> GoalReport:
        """Returns the report with the simulator's truth, where it has one, beside each belief."""
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
