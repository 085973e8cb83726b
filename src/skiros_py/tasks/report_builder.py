"""Builds the report on a goal: the result of each condition, and when it was reached."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence

from skiros_py.execution.cycle import ControlCycle
from skiros_py.planning.problem.stock import believed
from skiros_py.skills.conditions import Condition
from skiros_py.tasks.context import TaskContext
from skiros_py.tasks.handle import TaskHandle
from skiros_py.tasks.history import History
from skiros_py.tasks.report import ConditionReport, GoalReport
from skiros_py.tasks.trace import TraceEntry, TraceEventKind
from skiros_py.world.world import World


class ReportBuilder:
    """Collects the data for the report on one goal.

    Args:
        task: The task.
        context: The task's environment.
        history: Every executed step.

    Attributes:
        given_up: Conditions that were given up, with the reason.
        no_plan: Why there was no initial plan.
        stopped: True if it was stopped by a command.
    """

    def __init__(self, task: TaskHandle, context: TaskContext, history: History) -> None:
        self.given_up: dict[Condition, str] = {}
        self.no_plan: tuple[str, ...] = ()
        self.stopped = False
        self._goal = task.goal
        self._context = context
        self._history = history
        self._moments = Moments(context.world, task.goal, context.cycle)
        self._held = {c for c in task.goal if believed(c, context.world)}

    @property
    def kept(self) -> tuple[Condition, ...]:
        """The conditions that were not given up."""
        return tuple(c for c in self._goal if c not in self.given_up)

    def note(self) -> None:
        """Records conditions that hold by now."""
        self._moments.note()

    def report(self, fault: str = "") -> GoalReport:
        """Returns the report at the end.

        Args:
            fault: Why it ended early.
        """
        steps = tuple(self._history.steps)
        no_plan = () if steps else self.no_plan
        why = "; ".join(no_plan) or fault or ("stopped before it was reached" if self.stopped else "")
        given_up = (dict.fromkeys(self._goal, why) if why else {}) | self.given_up
        conditions = tuple(self._condition(c, given_up) for c in self._goal)
        stopped = self.stopped and not all(c.believed for c in conditions)
        forgotten = self._history.forgotten
        return GoalReport(
            conditions, steps, *self._moments.used, no_plan, stopped=stopped, fault=fault, forgotten=forgotten
        )

    def report_cut_off(self) -> GoalReport:
        """Returns the report without further queries: the state when the world was last evaluated."""
        why = self._context.cycle.halted
        conditions = tuple(self._as_last_seen(c, why or "stopped") for c in self._goal)
        return GoalReport(conditions, tuple(self._history.steps), *self._moments.used, stopped=not why, fault=why)

    def _condition(self, c: Condition, given_up: Mapping[Condition, str]) -> ConditionReport:
        holds = bool(believed(c, self._context.world))
        tries = 0 if c in self._held else self._history.tries(c, holds=holds)
        reason = "" if holds else self._history.why_missing(c, given_up)
        return ConditionReport(str(c), holds, None, tries, reason, *self._moments.since(c))

    def _as_last_seen(self, c: Condition, why: str) -> ConditionReport:
        holds = self._moments.held(c)
        tries = 0 if c in self._held else self._history.tries(c, holds=holds)
        return ConditionReport(str(c), holds, None, tries, "" if holds else why)


def end_before_beginning(task: TaskHandle, context: TaskContext) -> None:
    """Sets the report of a task that ended before its first cycle because the system was halted."""
    why, now = context.cycle.halted, context.now
    held = {c: bool(believed(c, context.world)) for c in task.goal}
    conditions = tuple(
        ConditionReport(str(c), holds, None, 0, "" if holds else why or "stopped") for c, holds in held.items()
    )
    task.report = GoalReport(conditions, (), 0.0, 0.0, stopped=not why, fault=why)
    task.trace.add(TraceEntry(now, TraceEventKind.BEGUN, task.name))
    task.trace.add(TraceEntry(now, TraceEventKind.FINISHED, f"{task.name}: {task.report.outcome}"))


class Moments:
    """Records when each condition of a goal came to hold permanently in the world model.

    Args:
        world: The live world model.
        goal: The conditions.
        cycle: Gives the time.
    """

    def __init__(self, world: World, goal: Sequence[Condition], cycle: ControlCycle) -> None:
        self._world = world
        self._goal = goal
        self._cycle = cycle
        self._start = cycle.board.snapshot.time, time.perf_counter()
        self._since: dict[Condition, tuple[float, float]] = {}
        self._version = -1
        self.note()

    @property
    def used(self) -> tuple[float, float]:
        """Simulated and wall time since the start [s]."""
        return self._cycle.board.snapshot.time - self._start[0], time.perf_counter() - self._start[1]

    def held(self, condition: Condition) -> bool:
        """Returns whether a condition held when the world was last evaluated."""
        return condition in self._since

    def since(self, condition: Condition) -> tuple[float | None, float | None]:
        """Returns simulated and wall time since which a condition has held [s]."""
        self.note()
        return self._since.get(condition, (None, None))

    def note(self) -> None:
        """Evaluates the conditions if the world has changed."""
        if self._version == self._world.version:
            return
        self._version = self._world.version
        for condition in self._goal:
            if not believed(condition, self._world):
                self._since.pop(condition, None)
            elif condition not in self._since:
                self._since[condition] = self.used
