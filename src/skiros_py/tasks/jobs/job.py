"""One job: its order, its state (ISA-95 job control, OPC 10031-4) and its results. Plain data, stored as JSON."""

from __future__ import annotations

import enum
from collections.abc import Mapping
from typing import Annotated, Any

from pydantic import (
    AwareDatetime,
    BaseModel,
    ConfigDict,
    Field,
    PlainSerializer,
    ValidatorFunctionWrapHandler,
    WrapValidator,
    field_validator,
)

from skiros_py.errors import WrongState
from skiros_py.messages import Message, message_data, read_message
from skiros_py.tasks.policy import Policy


class JobState(enum.Enum):
    """Where a job is; the numbers are those of the standard."""

    NOT_ALLOWED_TO_START = 1
    """It is stored and waits for permission to start."""
    ALLOWED_TO_START = 2
    """It starts by itself when its turn comes."""
    RUNNING = 3
    """It is being planned or executed."""
    INTERRUPTED = 4
    """It was running and is paused: by a command, or because it needs the user."""
    ENDED = 5
    """It ended by itself or was stopped normally."""
    ABORTED = 6
    """It was given up: by a command, or because no part of it can be done."""

    @property
    def is_open(self) -> bool:
        """True while the job is not over."""
        return self not in (JobState.ENDED, JobState.ABORTED)

    @property
    def has_begun(self) -> bool:
        """True while it is running or interrupted."""
        return self in (JobState.RUNNING, JobState.INTERRUPTED)


class Trigger(enum.Enum):
    """What triggers a state change."""

    STORE = "store"
    """It is ordered, without permission to start."""
    START = "start"
    """Permission to start is given."""
    REVOKE_START = "revoke start"
    """The permission is revoked."""
    UPDATE = "update"
    """The order is replaced."""
    DISPATCH = "dispatch"
    """Its turn has come."""
    PAUSE = "pause"
    """It is paused."""
    HOLD = "hold"
    """It needs the user."""
    RESUME = "resume"
    """It goes on."""
    STOP = "stop"
    """It is stopped normally."""
    ABORT = "abort"
    """It is aborted."""
    FINISH = "finish"
    """It is finished."""
    FAIL = "fail"
    """No part of it can be done."""


_S, _T = JobState, Trigger

_ENDS = {_T.STOP: _S.ENDED, _T.ABORT: _S.ABORTED, _T.FINISH: _S.ENDED, _T.FAIL: _S.ABORTED}
_TABLE: Mapping[JobState, Mapping[Trigger, JobState]] = {
    _S.NOT_ALLOWED_TO_START: {
        _T.START: _S.ALLOWED_TO_START,
        _T.UPDATE: _S.NOT_ALLOWED_TO_START,
        _T.ABORT: _S.ABORTED,
    },
    _S.ALLOWED_TO_START: {
        _T.REVOKE_START: _S.NOT_ALLOWED_TO_START,
        _T.UPDATE: _S.ALLOWED_TO_START,
        _T.DISPATCH: _S.RUNNING,
        _T.ABORT: _S.ABORTED,
        _T.FAIL: _S.ABORTED,
    },
    _S.RUNNING: {_T.PAUSE: _S.INTERRUPTED, _T.HOLD: _S.INTERRUPTED, **_ENDS},
    _S.INTERRUPTED: {_T.RESUME: _S.RUNNING, _T.HOLD: _S.INTERRUPTED, **_ENDS},
    _S.ENDED: {},
    _S.ABORTED: {},
}
"""The standard's table; HOLD in, and the end of, an interrupted job are internal to the cell."""
_OF_CELL = (_T.DISPATCH, _T.HOLD, _T.FINISH, _T.FAIL)
"""Triggers that are no commands."""


def allowed(state: JobState) -> tuple[Trigger, ...]:
    """Returns the triggers allowed in a state."""
    return tuple(_TABLE[state])


def next_state(state: JobState, trigger: Trigger) -> JobState:
    """Returns the state that follows.

    Raises:
        WrongState: The trigger is not allowed in this state; the message lists those that are.
    """
    if trigger not in _TABLE[state]:
        removal = "clear: it is over" if not state.is_open else "" if state.has_begun else "cancel"
        able = ", ".join(filter(None, (*(t.value for t in allowed(state) if t not in _OF_CELL), removal)))
        raise WrongState(
            "a job that is {state} takes no {trigger}; it takes {able}",
            state=state.name.lower().replace("_", " "),
            trigger=trigger.value,
            able=able,
        )
    return _TABLE[state][trigger]


_LONGEST_ID = 200
_PRIORITIES = 2**15


class Material(BaseModel):
    """Parts that an order is about (ISA-95: material requirement), as stated by the client.

    Attributes:
        class_: Their class; "class" in JSON.
        definition: The client's material number, if any.
        lot: The required lot.
        quantity: How many pieces; or an amount, a decimal number as text.
        units: Unit of the amount; empty for pieces.
        id: Id of a specific piece, if required.
        location: Where it is to be used.
        use: Its intended use.
        properties: Further properties given by the client.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", validate_by_name=True, validate_by_alias=True)

    class_: str = Field(alias="class")
    definition: str = ""
    lot: str = ""
    quantity: Annotated[int, Field(ge=1)] | str = 1
    units: str = ""
    id: str = ""
    location: str = ""
    use: str = ""
    properties: dict[str, str] = {}


class JobOrder(BaseModel):
    """A job order (ISA-95).

    Attributes:
        id: Chosen by the client; the same order again is the same job.
        goal: Goal texts; all must hold together.
        description: For people.
        priority: Higher values come first.
        not_before: The start gate: it does not start earlier. None for no gate.
        deadline: When it should be done; of equal priority the earlier comes first. A late job is still done and
            marked as late, unless ``expires``.
        expires: True if it must not be started after its deadline.
        policy: What to do when part of the goal is unreachable.
        work_master: Name of the goal template the goal was made from; empty if it was stated directly.
        parameters: The template's arguments by parameter name.
        materials: Which parts were ordered with it.
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
    work_master: str = ""
    parameters: dict[str, str] = {}
    materials: tuple[Material, ...] = ()

    @field_validator("goal", mode="before")
    @classmethod
    def _one_or_several(cls, value: object) -> object:
        return (value,) if isinstance(value, str) else value


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


def _read_text(value: Any, check: ValidatorFunctionWrapHandler) -> str:
    if isinstance(value, Mapping):
        return read_message(value)
    return value if isinstance(value, Message) else str(check(value))


Text = Annotated[str, WrapValidator(_read_text), PlainSerializer(message_data, when_used="json")]
"""A text for people; a message is stored with what it is made of."""


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
    reason: Text = ""


class MaterialActual(BaseModel):
    """A part that a job has moved (ISA-95: material actual).

    Attributes:
        element: Id of the part.
        class_: Its class.
        label: Its display name.
        lot: Its lot; empty if unknown.
        origin: Id of the element where it was when the job began.
        place: Id of the element where the job left it; empty if it no longer exists.
    """

    model_config = ConfigDict(frozen=True)

    element: str
    class_: str
    label: str
    lot: str = ""
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
    ended: Text | None = None


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
    comment: Text = ""


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
    detail: Text = ""
    choices: tuple[str, ...] = ()
    question: int | None = None
    outcome: Outcome | None = None
    actuals: tuple[Actual, ...] = ()
    materials: tuple[MaterialActual, ...] = ()
    reasons: tuple[Text, ...] = ()
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
