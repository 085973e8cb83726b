"""One running job: the task that pursues its goal, and its records."""

from __future__ import annotations

import time
from collections.abc import Sequence
from concurrent.futures import Future

from skiros_py.errors import UnknownName, WrongState
from skiros_py.execution.runtime import Runtime
from skiros_py.planning.plan import Step
from skiros_py.skills.outcome import Failure
from skiros_py.skills.outcome import Outcome as StepOutcome
from skiros_py.tasks.handle import StepRun, TaskHandle
from skiros_py.tasks.jobs.book import JobBook
from skiros_py.tasks.jobs.cut_off import WAITS, hold_what_was_halted
from skiros_py.tasks.jobs.job import Actual, Job, Outcome
from skiros_py.tasks.jobs.moves import moved
from skiros_py.tasks.jobs.states import Trigger
from skiros_py.tasks.jobs.store import JobStore
from skiros_py.tasks.report import GoalReport
from skiros_py.tasks.trace import TraceEntry

_BETWEEN_WRITES = 1.0
"""Wall time between two writes of the trace, since each waits for the disk [s]."""


class JobRun:
    """The run of a job; used in the control thread.

    Args:
        task: Pursues the goal.
        runtime: Where the task runs.
        book: Records the job's progress.
        store: Stores intents and trace.

    Attributes:
        ending: How the job ends once it is at rest, if it was ended by a command; None otherwise.
        paused: True while it is paused by a command.
        aside: True while it is set aside without a slot: nothing of it moves.
    """

    def __init__(self, task: TaskHandle, runtime: Runtime, book: JobBook, store: JobStore) -> None:
        self.ending: Outcome | None = None
        self.paused = False
        self.aside = False
        self._task = task
        self._runtime = runtime
        self._book = book
        self._store = store
        self._trigger, self._comment = Trigger.STOP, ""
        self._numbers: dict[int, int] = {}
        self._entries: list[TraceEntry] = []
        self._written = time.monotonic()
        self._seen: tuple[object, ...] = ()
        task.trace.subscribe(self._entries.append)
        task.before_step(self._intend)
        task.after_step(self._settle)

    # ------------------------------------------------------------------ commands

    def pause(self) -> None:
        """Pauses the job; if it waits for an answer, it pauses once the answer has arrived."""
        self.paused = True
        self._task.pause()

    def resume(self) -> None:
        """Resumes the job."""
        self.paused = False
        if not self.aside:
            self._task.resume()

    def set_aside(self) -> None:
        """Sets the job aside: when its question is answered, it waits for a slot."""
        self.aside = True
        self._task.pause()

    def take_place(self) -> None:
        """Gives the job a slot and resumes it, unless it is paused."""
        self.aside = False
        if not self.paused:
            self._task.resume()

    def stop(self) -> None:
        """Stops the job."""
        self._task.stop(self._comment or f"the job is {self.ending}")

    def end_as(self, trigger: Trigger, outcome: Outcome, comment: str) -> None:
        """Sets how the job ends once it is at rest; the last call counts."""
        self.ending, self._trigger, self._comment = outcome, trigger, comment

    @property
    def asks(self) -> bool:
        """True while it waits for an answer."""
        return self._task.question is not None

    def answer(self, choice: str, *, by: str, asked: int | None) -> None:
        """Answers its open question; may be called in any thread.

        Args:
            choice: One of the answers that it offers.
            by: Who answers.
            asked: Id of the question that this answers.

        Raises:
            WrongState: There is no open question, or it is a different one by now.
        """
        question = self._task.question
        if question is None or question.id != asked:
            now = "waits for no answer any more" if question is None else f"asks something else by now: {question.text}"
            raise WrongState(f"job '{self._task.name}' {now}")
        try:
            self._runtime.questions.answer(question.id, choice, by=by)
        except UnknownName:  # already answered, but the task has not processed it yet
            raise WrongState(f"job '{self._task.name}' has its answer already") from None

    # ------------------------------------------------------------------ what is written down

    def _intend(self, run: StepRun) -> Future[None]:
        self._numbers[run.number] = self._store.intend(self._task.name, run.step.skill, run.step.arguments)
        return self._store.sync()

    def _settle(self, run: StepRun, outcome: StepOutcome) -> None:
        ended = f"failed: {outcome.reason}" if isinstance(outcome, Failure) else "done"
        self._settle_as(run.number, ended)

    def _settle_as(self, number: int, ended: str) -> None:
        self._store.settle(self._task.name, self._numbers.pop(number), ended)

    @property
    def has_news(self) -> bool:
        """True if something has changed that :meth:`follow` stores."""
        return self._task.done or self._look() != self._seen

    def follow(self, job: Job) -> bool:
        """Stores what has changed.

        Args:
            job: The job as it is now.

        Returns:
            True if it is over or cut off.
        """
        task, seen = self._task, self._look()
        if task.done:
            for number in tuple(self._numbers):  # stopped in the middle of these steps, and at rest
                self._settle_as(number, "stopped")
            self.write_trace()  # before the end is announced: readers then see the whole trace
            self._finish(self._with_moves(job))
            return True
        if seen != self._seen:
            self._seen = seen
            self._note(self._with_moves(job), tuple(map(str, self._steps)))
        return False

    def _look(self) -> tuple[object, ...]:
        return self._status, self._task.question, self._steps, self.paused

    @property
    def _status(self) -> str:
        """Its current activity, in words."""
        if self.paused or not self.aside:
            return self._task.status
        return self._task.phase if self.asks else WAITS

    @property
    def _steps(self) -> tuple[Step, ...]:
        plan = self._task.plan
        return tuple(plan.steps) if plan is not None else ()

    def _with_moves(self, job: Job) -> Job:
        """Returns the job with the parts it has moved so far; same version, since it was not published yet."""
        version = self._runtime.world.version
        materials = moved(self._runtime.world, job, self._store.intents(job.id))
        return job.model_copy(update={"materials": materials, "seen": version})

    def _note(self, job: Job, plan: Sequence[str]) -> None:
        """Publishes its current activity; waiting for the user is a state of the job."""
        question = self._task.question
        if question is not None:
            asks = {"detail": f"held: {question.text}", "choices": question.options, "question": question.id}
            self._book.move(job, Trigger.HOLD, question.text, plan=plan, **asks)
        elif job.choices and not self.paused:
            self._book.move(job, Trigger.RESUME, "answered", detail=self._status, choices=(), question=None, plan=plan)
        else:
            detail = "paused" if self.paused else self._status
            self._book.change(job.but(detail=detail, choices=(), question=None, plan=plan))

    def write_trace(self) -> None:
        """Stores the trace periodically, and when the job is over."""
        if self._entries and (self._task.done or time.monotonic() - self._written > _BETWEEN_WRITES):
            entries, self._entries[:] = tuple(self._entries), ()
            self._store.tell(self._task.name, [entry.as_json() for entry in entries])
            self._written = time.monotonic()

    # ------------------------------------------------------------------ the end

    def _finish(self, job: Job) -> None:
        halted = self._runtime.cycle.halted
        report = self._task.report
        if self.ending is not None:
            self._close(job, self._trigger, self.ending, report)
        elif halted:
            hold_what_was_halted(self._book, job, halted)
        elif report is None or report.stopped:
            self._close(job, Trigger.STOP, Outcome.STOPPED, report)
        else:
            outcome = _outcome(report)
            gone = outcome in (Outcome.FAILED, Outcome.NO_PLAN)
            self._close(job, Trigger.FAIL if gone else Trigger.FINISH, outcome, report)

    def _close(self, job: Job, trigger: Trigger, outcome: Outcome, report: GoalReport | None) -> None:
        conditions = report.conditions if report is not None else ()
        actuals = tuple(Actual(condition=c.condition, reached=c.believed, reason=c.reason) for c in conditions)
        fault = (report.fault,) if report is not None and report.fault else ()
        why = (*(report.no_plan if report is not None else ()), *fault)
        reasons = why or tuple(dict.fromkeys(c.reason for c in conditions if c.reason))
        over = {"outcome": outcome, "detail": "", "choices": (), "question": None}
        self._book.move(job, trigger, self._comment, actuals=actuals, reasons=reasons, **over)


def _outcome(report: GoalReport) -> Outcome:
    reached = sum(c.believed for c in report.conditions)
    if reached == len(report.conditions):
        return Outcome.SUCCEEDED if report.steps else Outcome.ALREADY_SATISFIED
    if report.no_plan and not report.steps:
        return Outcome.NO_PLAN
    return Outcome.PARTIALLY_SUCCEEDED if reached else Outcome.FAILED
