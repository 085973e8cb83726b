"""What executing a goal and executing a sequence of steps have in common."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from contextlib import suppress
from typing import TypeVar

from skiros_py.errors import SkirosError
from skiros_py.execution.module_faults import words
from skiros_py.messages import Message, joined
from skiros_py.skills.primitive import Execution
from skiros_py.skills.skill import SkillDescription
from skiros_py.tasks.context import StopWanted, TaskContext
from skiros_py.tasks.dispatcher import Dispatcher, Progress
from skiros_py.tasks.handle import TaskHandle
from skiros_py.tasks.record import TaskRecord
from skiros_py.tasks.report import GoalReport
from skiros_py.tasks.trace import TraceEventKind

T = TypeVar("T")


class TaskExecutor(ABC):
    """Executes one task to its end. The parts it uses return values; only the executor decides.

    Args:
        task: The task.
        context: The task's environment: world, managers, planning.

    Attributes:
        record: Every executed step, and what became of the goal.
    """

    def __init__(self, task: TaskHandle, context: TaskContext) -> None:
        self.record = TaskRecord(context, task.goal, task.policy.attempts)
        if task.ruled_out:
            self.record.avoid(task.ruled_out)
        self._task = task
        self._context = context
        self._trace = task.trace
        self._dispatcher = Dispatcher(task, context, self.record.tried)
        self._skills: Mapping[str, SkillDescription] = {}
        self._progress = Progress()

    def execute(self) -> Execution[GoalReport]:
        """Executes the task to its end; it always gets a report.

        Raises:
            PlanningError: The planner failed before any step was run.
        """
        task, record = self._task, self.record
        self._trace.write(TraceEventKind.BEGUN, joined(": ", (task.name, self._title())))
        try:
            yield from self._until_stopped()
            task.report = record.report()
        except Exception as error:
            record.fault = (
                str(error) if isinstance(error, SkirosError) else Message("it broke: {error}", error=words(error))
            )
            with suppress(Exception):  # ignore further errors: the first one counts
                yield from self._halt(record.fault)
            task.report = record.report()
            raise
        finally:
            self._leave()
            if task.report is None:  # the system was halted, or user code blocked the control cycle
                task.report = record.report_cut_off()
            self._trace.write(TraceEventKind.FINISHED, joined(": ", (task.name, task.report.outcome.value)))
        return task.report

    @abstractmethod
    def _title(self) -> str:
        """Returns what is to be done, for the trace."""

    @abstractmethod
    def _work(self) -> Execution[None]:
        """Does the work.

        Raises:
            StopWanted: The task was asked to stop.
        """

    def _leave(self) -> None:
        """Releases everything at once."""
        self._dispatcher.leave()

    def _until_stopped(self) -> Execution[None]:
        try:
            yield from self._work()
        except StopWanted as wish:
            self.record.stopped = True
            why = str(wish)
            text = Message("is stopped: {why}", why=why) if why else Message("is stopped")
            self._trace.write(TraceEventKind.STOPPED, text)
            yield from self._halt(why or Message("stopped"))

    def _halt(self, reason: str) -> Execution[None]:
        """Stops all running steps and waits until they have come to rest."""
        self._dispatcher.stop(reason)
        while self._noted(self._dispatcher.collect()).running:
            yield

    # ------------------------------------------------------------------ each cycle

    def _attend(self) -> Progress:
        """Applies control requests and collects the steps that have ended."""
        return self._noted(self._dispatcher.attend())

    def _noted(self, progress: Progress) -> Progress:
        """Records the steps that have ended and the conditions that hold by now."""
        self.record.update(progress.ended)
        self._progress = progress
        return progress

    def _look_after(self) -> None:
        """Handles a stop request.

        Raises:
            StopWanted: The task was asked to stop.
        """
        if (wish := self._task.control.stop) is not None:
            raise StopWanted(wish)

    def _meanwhile(self, work: Execution[T]) -> Execution[T]:
        """Runs a longer operation while attending to the running steps."""
        try:
            while True:
                self._look_after()
                try:
                    next(work)
                except StopIteration as end:
                    result: T = end.value
                    return result
                self._attend()
                yield
        finally:
            work.close()
