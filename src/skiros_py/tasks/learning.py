"""Learns skill durations during operation."""

from __future__ import annotations

from skiros_py.execution.runtime import Runtime
from skiros_py.planning.durations import observe
from skiros_py.skills.outcome import Failure, Outcome
from skiros_py.tasks.handle import StepRun, TaskHandle
from skiros_py.tasks.report import StepReport
from skiros_py.tasks.task_manager import TaskManager


def learn_durations(tasks: TaskManager, runtime: Runtime) -> None:
    """Learns skill durations from every successful step; for real and simulated cells, not for fake devices."""

    def learn(run: StepRun, outcome: Outcome) -> None:
        if not isinstance(outcome, Failure):
            now = runtime.context.board.now
            observe(runtime.world, StepReport(run.step.skill, {}, run.start, now, agent=run.agent))

    def follow(task: TaskHandle) -> None:
        task.after_step(learn)

    tasks.on_begin(follow)
