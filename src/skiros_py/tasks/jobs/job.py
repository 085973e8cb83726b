"""One job: its state and results. Plain data, stored as JSON."""

from __future__ import annotations

import enum
from typing import Any

from pydantic import BaseModel, ConfigDict

from skiros_py.tasks.jobs.order import JobOrder
from skiros_py.tasks.jobs.states import JobState


class Outcome(enum.StrEnum):
    """The outcome of a finished job."""

    SUCCEEDED = "succeeded"
    PARTIALLY_SUCCEEDED = "partially succeeded"
    ALREADY_SATISFIED = "goal already satisfied"
    STOPPED = "stopped"
    ABORTED = "aborted"
    FAILED = "failed"
    NO_PLAN = "no plan"
    EXPIRED = "expired"


class Actual(BaseModel):
    """The result for one condition of the goal.

    Attributes:
        condition: As ordered.
        reached: Whether it holds.
        reason: Why not; empty if it does.
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
        label: Its display name.
        origin: Id of the element where it was when the job began.
        place: Id of the element where the job left it; empty if it no longer exists.
    """

    model_config = ConfigDict(frozen=True)

    element: str
    class_: str
    label: str
    origin: str
    place: str


class Intent(BaseModel):
    """The record that a step is about to move something, written before its first command.

    Attributes:
        number: Counts the steps of the job.
        skill: Name of the skill.
        arguments: Its arguments.
        ended: How it ended; None while unknown.
    """

    model_config = ConfigDict(frozen=True)

    number: int
    skill: str
    arguments: dict[str, str]
    ended: str | None = None


class Transition(BaseModel):
    """One state change, with its trigger and reason.

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
        number: Order number, in order of arrival.
        state: Its state.
        detail: Its current activity or what it waits for in this state, in words ("queued", "planning", "held: …").
        choices: The possible answers to its open question; empty if there is none.
        question: Id of that question; None if the job itself asks because it was cut off.
        outcome: Its outcome; None until it is over.
        actuals: The result for each condition.
        materials: The parts it has moved, by id; while it runs, those reported so far.
        reasons: Why there is no plan, or why it was given up.
        plan: The last plan, one line per step.
        attempts: How often it was started: once more after each restart of the program.
        seen: Version of the world up to which ``materials`` are known; None while it does not run.
        version: Incremented with every change, also across successive jobs with the same id.
        ordered, started, ended, changed: Times of these events, the last of any change [s since 1970].
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
        """True if it ended after its deadline; for open jobs the caller compares with the clock."""
        return self.order.deadline is not None and (self.ended or 0.0) > self.order.deadline.timestamp()

    @property
    def lateness(self) -> float | None:
        """How long after its deadline it ended [s], 0 for in time; None if it has no deadline or is not over."""
        if self.order.deadline is None or self.ended is None:
            return None
        return max(0.0, self.ended - self.order.deadline.timestamp())

    def but(self, **changes: Any) -> Job:
        """Returns the next version of the job with some fields changed."""
        return self.model_copy(update={"version": self.version + 1, **changes})
