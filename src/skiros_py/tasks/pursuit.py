"""Pursuing a goal from the outside: cycles are run until it is reached or given up, or everything stops."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence

from skiros_py.execution.runtime import Runtime
from skiros_py.planning.problem.stock import believed
from skiros_py.skills.conditions import Condition
from skiros_py.tasks.report import ConditionReport, GoalReport
from skiros_py.tasks.task_manager import TaskManager


def pursue(
    runtime: Runtime, tasks: TaskManager, goal: Sequence[Condition], leave: Callable[[], bool] = lambda: False
) -> GoalReport:
    """Pursues a goal to its end.

    Args:
        runtime: Runs everything.
        tasks: The task manager.
        goal: Conditions that shall hold together.
        leave: Asked in each cycle whether somebody wants it to stop; then everything is still as it was in that cycle.

    Raises:
        UsageError: Everything was halted before, and not reset.
        PlanningError: The planner broke before anything was done.
    """
    runtime.require_ready()
    started = time.perf_counter(), runtime.context.board.now
    task = runtime.cycle.start(tasks.pursue(goal), "the task manager")
    if runtime.finish(task, leave):
        return task.result
    why = runtime.cycle.halted
    held = {c: bool(believed(c, runtime.world)) for c in goal}
    conditions = tuple(
        ConditionReport(str(c), holds, None, tasks.tries(c, holds=holds), "" if holds else why or "stopped")
        for c, holds in held.items()
    )
    used = runtime.context.board.now - started[1], time.perf_counter() - started[0]
    return GoalReport(conditions, tuple(tasks.steps), *used, stopped=not why)
