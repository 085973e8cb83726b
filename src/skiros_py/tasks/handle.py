"""A task that was begun: what whoever began it holds in their hands."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Future
from dataclasses import dataclass
from typing import Literal

from skiros_py.planning.plan import Plan, Step
from skiros_py.skills.conditions import Condition
from skiros_py.skills.outcome import Outcome
from skiros_py.skills.questions import Question
from skiros_py.tasks.control import Control, Mode
from skiros_py.tasks.policy import Policy
from skiros_py.tasks.report import GoalReport
from skiros_py.tasks.trace import Trace

TaskStatus = Literal["planning", "running", "paused", "waiting", "ended"]


_PLAIN = Policy()


@dataclass(frozen=True, slots=True)
class StepRun:
    """One step that is started.

    Attributes:
        number: Its number among all steps that the task started, from 1; a step that is done once more has a new one.
        step: The skill with its arguments.
        agent: Id of the subsystem that does it.
        start: Run time [s].
    """

    number: int
    step: Step
    agent: str
    start: float


BeforeStep = Callable[[StepRun], Future[None] | None]
AfterStep = Callable[[StepRun, Outcome], None]


class TaskHandle:
    """A task under way, or over. Its methods may be called in any thread; they are obeyed in the coming cycle.

    Args:
        name: What people call it.
        goal: What is wanted; empty for a sequence of steps.
        policy: What it does when something is out of reach.

    Attributes:
        trace: What happened so far.
        control: What people want of it.
        plan: The present plan; None before there is one.
        report: What came of it; None until it is done.
        error: What broke it; None where nothing did.
        phase: What it does now, apart from pauses.
        question: What it waits for a person to answer; None while it does not.
    """

    def __init__(self, name: str, goal: Sequence[Condition] = (), policy: Policy = _PLAIN) -> None:
        self.name = name
        self.goal = tuple(goal)
        self.policy = policy
        self.trace = Trace()
        self.control = Control()
        self.plan: Plan | None = None
        self.report: GoalReport | None = None
        self.error: Exception | None = None
        self.phase: Literal["planning", "running", "waiting"] = "planning"
        self.question: Question | None = None
        self._before: list[BeforeStep] = []
        self._after: list[AfterStep] = []

    @property
    def status(self) -> TaskStatus:
        """What it does now; "waiting" is for a person, whose answer is needed."""
        if self.report is not None:
            return "ended"
        return "paused" if self.control.mode is Mode.PAUSE else self.phase

    @property
    def done(self) -> bool:
        """True when it is over and all it moved stands."""
        return self.report is not None

    @property
    def result(self) -> GoalReport:
        """The report of a task that is done.

        Raises:
            Exception: Whatever broke it.
        """
        if self.error is not None:
            raise self.error
        assert self.report is not None, "the task is not done"
        return self.report

    # ------------------------------------------------------------------ control

    def pause(self) -> None:
        """Lets all its running steps come to a standstill, and starts no more."""
        self.control.wish(Mode.PAUSE)

    def resume(self) -> None:
        """Goes on after a pause."""
        self.control.wish(Mode.RUN)

    def step(self) -> None:
        """Goes on until what runs has ended, then pauses; where nothing runs, the next possible steps start first."""
        self.control.wish(Mode.SINGLE)

    def stop(self, reason: str = "") -> None:
        """Ends it: what runs is stopped, and when all stands it is done. What is over already stays as it is."""
        self.control.end(reason)

    # ------------------------------------------------------------------ steps as they come and go

    def before_step(self, listener: BeforeStep) -> Callable[[], None]:
        """Calls the listener in the control thread before a step's first command; returns how to end that.

        Where it returns a future, the step waits for that. When it raises, or the future does, the step is not started
        and the task ends: nothing is done whose intent could not be kept.
        """
        self._before.append(listener)
        return lambda: self._before.remove(listener)

    def after_step(self, listener: AfterStep) -> Callable[[], None]:
        """Calls the listener in the control thread when a step has ended; returns how to end that."""
        self._after.append(listener)
        return lambda: self._after.remove(listener)

    def starts(self, run: StepRun) -> tuple[Future[None], ...]:
        """Tells that a step is about to start, and returns what it has to wait for; for the dispatcher."""
        waits = [listener(run) for listener in tuple(self._before)]
        return tuple(future for future in waits if future is not None)

    def ended(self, run: StepRun, outcome: Outcome) -> None:
        """Tells how a step ended; for the dispatcher."""
        for listener in tuple(self._after):
            listener(run, outcome)
