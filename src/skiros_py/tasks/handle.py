"""The handle of a started task, as returned to its caller."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Future
from typing import Literal

from skiros_py.planning.plan import Plan
from skiros_py.planning.requests import RuledOut
from skiros_py.skills.conditions import Condition
from skiros_py.skills.context import Question
from skiros_py.skills.outcome import Outcome
from skiros_py.tasks.context import Control, Mode
from skiros_py.tasks.policy import Policy
from skiros_py.tasks.rehearsal import Rehearsal
from skiros_py.tasks.report import GoalReport
from skiros_py.tasks.trace import StepRun, Trace

TaskStatus = Literal["planning", "running", "paused", "waiting", "ended"]


BeforeStep = Callable[[StepRun], Future[None] | None]
AfterStep = Callable[[StepRun, Outcome], None]


class TaskHandle:
    """A running or finished task. Its methods may be called in any thread; they take effect in the next cycle.

    Args:
        name: Display name.
        goal: The conditions to reach; empty for a sequence of steps.
        policy: What to do when part of the goal is unreachable.
        trace: The events so far; filled while it runs.
        ruled_out: Attempts that are not planned.

    Attributes:
        trace: The events so far.
        control: Its pending control requests.
        plan: The current plan; None before there is one.
        report: Its report; None until it is done.
        error: The exception that ended it; None if there was none.
        rehearsal: Its rehearsal, if it wanted one and that has ended.
        phase: Its current phase, regardless of pauses.
        question: The open question to the user; None if there is none.
    """

    def __init__(
        self,
        name: str,
        goal: Sequence[Condition],
        policy: Policy,
        trace: Trace,
        ruled_out: Sequence[RuledOut] = (),
    ) -> None:
        self.name = name
        self.ruled_out = tuple(ruled_out)
        self.goal = tuple(goal)
        self.policy = policy
        self.trace = trace
        self.control = Control()
        self.plan: Plan | None = None
        self.report: GoalReport | None = None
        self.error: Exception | None = None
        self.rehearsal: Rehearsal | None = None
        self.phase: Literal["planning", "running", "waiting"] = "planning"
        self.question: Question | None = None
        self._before: list[BeforeStep] = []
        self._after: list[AfterStep] = []

    @property
    def status(self) -> TaskStatus:
        """The current status; "waiting" means waiting for the user's answer."""
        if self.report is not None:
            return "ended"
        return "paused" if self.control.mode is Mode.PAUSE else self.phase

    @property
    def done(self) -> bool:
        """True if it is over and everything it moved is at rest."""
        return self.report is not None

    @property
    def result(self) -> GoalReport:
        """The report of a task that is done.

        Raises:
            Exception: The error that ended the task.
        """
        if self.error is not None:
            raise self.error
        assert self.report is not None, "the task is not done"
        return self.report

    # ------------------------------------------------------------------ control

    def pause(self) -> None:
        """Brings all running steps to a standstill and starts no more."""
        self.control.wish(Mode.PAUSE)

    def resume(self) -> None:
        """Resumes after a pause."""
        self.control.wish(Mode.RUN)

    def step(self) -> None:
        """Resumes until the running steps have ended, then pauses; if none runs, starts the next ready steps first."""
        self.control.wish(Mode.SINGLE)

    def stop(self, reason: str = "") -> None:
        """Stops the task: its running steps are stopped, and it is done once all is at rest. No effect once done."""
        self.control.end(reason)

    # ------------------------------------------------------------------ steps as they come and go

    def before_step(self, listener: BeforeStep) -> Callable[[], None]:
        """Calls the listener in the control thread before a step's first command; returns an unsubscribe function.

        If the listener returns a future, the step waits for it. If the listener or the future raises, the step is not
        started: no step runs whose intent could not be stored. After a DiskFault it is tried again; any
        other exception ends the task.
        """
        self._before.append(listener)
        return lambda: self._before.remove(listener)

    def after_step(self, listener: AfterStep) -> Callable[[], None]:
        """Calls the listener in the control thread when a step has ended; returns an unsubscribe function."""
        self._after.append(listener)
        return lambda: self._after.remove(listener)

    def starts(self, run: StepRun) -> tuple[Future[None], ...]:
        """Announces that a step is about to start and returns the futures to wait for; used by the dispatcher."""
        waits = [listener(run) for listener in tuple(self._before)]
        return tuple(future for future in waits if future is not None)

    def ended(self, run: StepRun, outcome: Outcome) -> None:
        """Announces how a step ended; used by the dispatcher."""
        for listener in tuple(self._after):
            listener(run, outcome)
