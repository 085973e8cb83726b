"""One job: how far it is, and what came of it. Plain data, kept as JSON."""

from __future__ import annotations

import enum
from typing import Any

from pydantic import BaseModel, ConfigDict

from skiros_py.tasks.jobs.order import JobOrder
from skiros_py.tasks.jobs.states import JobState


class Outcome(enum.StrEnum):
    """What came of a job that is over."""

    SUCCEEDED = "succeeded"
    PARTIALLY_SUCCEEDED = "partially succeeded"
    ALREADY_SATISFIED = "goal already satisfied"
    STOPPED = "stopped"
    ABORTED = "aborted"
    FAILED = "failed"
    NO_PLAN = "no plan"
    EXPIRED = "expired"


class Actual(BaseModel):
    """What became of one condition of the goal.

    Attributes:
        condition: As ordered.
        reached: Whether it holds.
        reason: Why not; empty where it does.
    """

    model_config = ConfigDict(frozen=True)

    condition: str
    reached: bool
    reason: str = ""


class MaterialActual(BaseModel):
    """A part that a job has moved (ISA-95: material actual).

    Attributes:
        element: Id of the part.
        class_: Its class.
        label: What people call it.
        origin: Id of the element where it was when the job began.
        place: Id of the element where the job left it; empty where it is no more.
    """

    model_config = ConfigDict(frozen=True)

    element: str
    class_: str
    label: str
    origin: str
    place: str


class Intent(BaseModel):
    """That a step is about to move something: written down before its first command.

    Attributes:
        number: Counts the steps of the job.
        skill: What is done.
        arguments: With what.
        ended: How it ended; None while nobody knows.
    """

    model_config = ConfigDict(frozen=True)

    number: int
    skill: str
    arguments: dict[str, str]
    ended: str | None = None


class Transition(BaseModel):
    """One change of state, with who wanted it and why.

    Attributes:
        wall: When [s since 1970].
        trigger: What led to it.
        state: The state it led to.
        comment: Why.
    """

    model_config = ConfigDict(frozen=True)

    wall: float
    trigger: str
    state: JobState
    comment: str = ""


class Job(BaseModel):
    """A job as it is now.

    Attributes:
        order: What was ordered.
        number: Counts orders in the sequence in which they came.
        state: Its state.
        detail: What it does or waits for in this state, in words ("queued", "planning", "held: …").
        choices: The answers that it waits for from a person; empty while it waits for none.
        question: Id of the question that they answer; None where the job itself asks: it was cut off.
        outcome: What came of it; None until it is over.
        actuals: What became of each condition.
        materials: Which parts it has moved, by their ids; while it runs, as far as it has said so.
        reasons: Why there is no plan, or why it was given up.
        plan: The last plan, a line a step.
        attempts: How often it was begun: once more after each restart of the program.
        seen: Version of the world up to which ``materials`` are known; None while it does not run.
        version: Grows with every change of it, and over jobs that have its id one after the other.
        ordered, started, ended, changed: When, the last for any change of it [s since 1970].
    """

    model_config = ConfigDict(frozen=True)

    order: JobOrder
    number: int
    state: JobState
    detail: str = ""
    choices: tuple[str, ...] = ()
    question: int | None = None
    outcome: Outcome | None = None
    actuals: tuple[Actual, ...] = ()
    materials: tuple[MaterialActual, ...] = ()
    reasons: tuple[str, ...] = ()
    plan: tuple[str, ...] = ()
    attempts: int = 0
    seen: int | None = None
    version: int = 1
    ordered: float = 0.0
    started: float | None = None
    ended: float | None = None
    changed: float = 0.0

    @property
    def id(self) -> str:
        """The id of its order."""
        return self.order.id

    @property
    def late(self) -> bool:
        """True when it ended, or is still open, after its deadline; what is open is judged by whoever has a clock."""
        return self.order.deadline is not None and (self.ended or 0.0) > self.order.deadline.timestamp()

    @property
    def lateness(self) -> float | None:
        """How long after its deadline it ended [s], 0 for in time; None where it has no deadline or is not over."""
        if self.order.deadline is None or self.ended is None:
            return None
        return max(0.0, self.ended - self.order.deadline.timestamp())

    def but(self, **changes: Any) -> Job:
        """Returns the job with something changed, as its next version."""
        return self.model_copy(update={"version": self.version + 1, **changes})
