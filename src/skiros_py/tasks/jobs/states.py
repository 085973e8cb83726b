"""The states of a job and what leads from one to another, after ISA-95 job control (OPC 10031-4 v2.00, §6)."""

from __future__ import annotations

import enum
from collections.abc import Mapping
from types import MappingProxyType

from skiros_py.errors import WrongState


class JobState(enum.Enum):
    """Where a job is; the numbers are those of the standard."""

    NOT_ALLOWED_TO_START = 1
    """It is known, and waits for somebody's leave."""
    ALLOWED_TO_START = 2
    """It starts by itself when its turn comes."""
    RUNNING = 3
    """It is being planned or done."""
    INTERRUPTED = 4
    """It was under way and stands: somebody paused it, or it cannot go on without a person."""
    ENDED = 5
    """It came to an end by itself, or was stopped in good order."""
    ABORTED = 6
    """It was given up: by a person, or because there is no way to do anything of it."""

    @property
    def is_open(self) -> bool:
        """True while something may still be done for it."""
        return self not in (JobState.ENDED, JobState.ABORTED)

    @property
    def has_begun(self) -> bool:
        """True while it is under way, and also when it stands meanwhile."""
        return self in (JobState.RUNNING, JobState.INTERRUPTED)


class Trigger(enum.Enum):
    """What leads from one state to another."""

    STORE = "store"
    """Somebody orders it, without leave to start."""
    START = "start"
    """Somebody gives leave to start."""
    REVOKE_START = "revoke start"
    """Somebody takes that back."""
    UPDATE = "update"
    """Somebody orders something else instead."""
    DISPATCH = "dispatch"
    """Its turn has come."""
    PAUSE = "pause"
    """Somebody lets it stand for a while."""
    HOLD = "hold"
    """It cannot go on without a person."""
    RESUME = "resume"
    """It goes on."""
    STOP = "stop"
    """Somebody ends it in good order."""
    ABORT = "abort"
    """Somebody gives it up."""
    FINISH = "finish"
    """It is through."""
    FAIL = "fail"
    """Nothing of it can be done."""


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
"""The standard's table; HOLD of what stands already, and the end of what stands, are the inner life of the cell."""


def allowed(state: JobState) -> tuple[Trigger, ...]:
    """Returns what may happen to a job in a state."""
    return tuple(_TABLE[state])


def next_state(state: JobState, trigger: Trigger) -> JobState:
    """Returns the state that follows.

    Raises:
        WrongState: That cannot happen in this state; the message says what can.
    """
    if trigger not in _TABLE[state]:
        able = ", ".join(t.value for t in allowed(state)) or "nothing: it is over"
        raise WrongState(
            f"a job that is {state.name.lower().replace('_', ' ')} takes no {trigger.value}; it takes {able}"
        )
    return _TABLE[state][trigger]
