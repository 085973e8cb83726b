"""What a cell learns while it works: how long its skills take."""

from __future__ import annotations

from skiros_py.execution.station import Station
from skiros_py.planning.durations import observe
from skiros_py.skills.outcome import Failure, Outcome
from skiros_py.tasks.handle import StepRun, TaskHandle
from skiros_py.tasks.report import StepReport
from skiros_py.tasks.task_manager import TaskManager

__all__ = ["learn_durations"]


def learn_durations(tasks: TaskManager, station: Station) -> None:
    """Lets every step that ends well teach how long its skill takes; for real and simulated cells: fakes pretend."""

    def learn(run: StepRun, outcome: Outcome) -> None:
        if not isinstance(outcome, Failure):
            now = station.context.board.now
            observe(station.world, StepReport(run.step.skill, {}, run.start, now, agent=run.agent))

    def follow(task: TaskHandle) -> None:
        task.after_step(learn)

    tasks.on_begin(follow)
