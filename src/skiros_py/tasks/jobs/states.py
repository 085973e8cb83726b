"""The states of a job and the transitions between them, after ISA-95 job control (OPC 10031-4 v2.00, §6)."""

from __future__ import annotations

import enum
from collections.abc import Mapping
from types import MappingProxyType

from skiros_py.errors import WrongState


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

_TABLE: Mapping[JobState, Mapping[Trigger, JobState]] = MappingProxyType(
    {
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
        _S.RUNNING: {
            _T.PAUSE: _S.INTERRUPTED,
            _T.HOLD: _S.INTERRUPTED,
            _T.STOP: _S.ENDED,
            _T.ABORT: _S.ABORTED,
            _T.FINISH: _S.ENDED,
            _T.FAIL: _S.ABORTED,
        },
        _S.INTERRUPTED: {
            _T.RESUME: _S.RUNNING,
            _T.HOLD: _S.INTERRUPTED,
            _T.STOP: _S.ENDED,
            _T.ABORT: _S.ABORTED,
            _T.FINISH: _S.ENDED,
            _T.FAIL: _S.ABORTED,
        },
        _S.ENDED: {},
        _S.ABORTED: {},
    }
)
"""The standard's table; HOLD in, and the end of, an interrupted job are internal to the cell."""


def allowed(state: JobState) -> tuple[Trigger, ...]:
    """Returns the triggers allowed in a state."""
    return tuple(_TABLE[state])


def next_state(state: JobState, trigger: Trigger) -> JobState:
    """Returns the state that follows.

    Raises:
        WrongState: The trigger is not allowed in this state; the message lists those that are.
    """
    if trigger not in _TABLE[state]:
        able = ", ".join(t.value for t in allowed(state)) or "nothing: it is over"
        raise WrongState(
            f"a job that is {state.name.lower().replace('_', ' ')} takes no {trigger.value}; it takes {able}"
        )
    return _TABLE[state][trigger]
