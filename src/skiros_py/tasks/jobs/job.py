"""One job: what was ordered, how far it is, and what came of it. Plain data, kept as JSON."""

from __future__ import annotations

import enum
from typing import Any

from pydantic import AwareDatetime, BaseModel, ConfigDict, Field, field_validator

from skiros_py.tasks.jobs.states import JobState
from skiros_py.tasks.policy import Policy

__all__ = ["Actual", "Intent", "Job", "JobOrder", "Outcome", "Transition"]

_LONGEST_ID = 200
_PRIORITIES = 2**15


class JobOrder(BaseModel):
    """What is ordered (ISA-95: job order).

    Attributes:
        id: Chosen by whoever orders; the same order again is the same job.
        goal: Goal texts; all must hold together.
        description: For people.
        priority: The higher comes first.
        not_before: The start gate: it does not start earlier. None for at once.
        deadline: When it should be done; of equal priority the earlier comes first. A job that is late is still done,
            and says so, unless ``expires``.
        expires: True where it must not be begun after its deadline.
        policy: What happens when something of the goal cannot be reached.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    id: str = Field(min_length=1, max_length=_LONGEST_ID, pattern=r"^[^\s/\x00-\x1f]+$")
    goal: tuple[str, ...] = Field(min_length=1)
    description: str = ""
    priority: int = Field(default=0, ge=-_PRIORITIES, lt=_PRIORITIES)
    not_before: AwareDatetime | None = None
    deadline: AwareDatetime | None = None
    expires: bool = False
    policy: Policy = Policy()

    @field_validator("goal", mode="before")
    @classmethod
    def _one_or_several(cls, value: object) -> object:
        return (value,) if isinstance(value, str) else value


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
    """What became of one condition of the goal (ISA-95: material actual).

    Attributes:
        condition: As ordered.
        reached: Whether it holds.
        reason: Why not; empty where it does.
    """

    model_config = ConfigDict(frozen=True)

    condition: str
    reached: bool
    reason: str = ""


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
        reasons: Why there is no plan, or why it was given up.
        plan: The last plan, a line a step.
        attempts: How often it was begun: once more after each restart of the program.
        version: Grows with every change of it.
        ordered, started, ended: When [s since 1970].
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
    reasons: tuple[str, ...] = ()
    plan: tuple[str, ...] = ()
    attempts: int = 0
    version: int = 1
    ordered: float = 0.0
    started: float | None = None
    ended: float | None = None

    @property
    def id(self) -> str:
        """The id of its order."""
        return self.order.id

    @property
    def late(self) -> bool:
        """True when it ended, or is still open, after its deadline; what is open is judged by whoever has a clock."""
        return self.order.deadline is not None and (self.ended or 0.0) > self.order.deadline.timestamp()

    def but(self, **changes: Any) -> Job:
        """Returns the job with something changed, as its next version."""
        return self.model_copy(update={"version": self.version + 1, **changes})
