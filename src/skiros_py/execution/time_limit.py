"""How long one run of a module may take, and whether it makes progress."""

from __future__ import annotations

from collections.abc import Callable
from math import inf

from skiros_py.messages import Message
from skiros_py.skills.context import RunContext

_FACTOR = 20.0
"""How many times its usual duration a module may take."""
_LEAST = 300.0
"""How long every module with a usual duration may take [s]."""
_STALLED = 60.0
"""Time without progress after which that is reported [s]."""
_LONGEST_STALL = 600.0
"""Time without progress after which a module without usual duration and limit is ended [s]."""


class TimeLimit:
    """The time of one run, without pauses and without the time in which it asks a person.

    Args:
        context: That of the run.
        duration: How long such a run takes as a rule [s]; None if it is not known.
        limit: How long it may take at most [s]; None for a default that follows from the duration.

    Attributes:
        stalled: True when it has made no progress for long, until it does; never where it is to have no limit.
    """

    def __init__(self, context: RunContext, duration: float | None, limit: float | None) -> None:
        self.stalled = False
        self._context = context
        self._duration = duration
        self._limit = limit or (inf if duration is None else max(_LEAST, _FACTOR * duration))
        self._may_stall = limit == inf
        self._longest_stall = _LONGEST_STALL if duration is limit is None else inf
        self._now = context.now
        self._taken = self._idle = 0.0

    def progress(self) -> None:
        """Notes that the run has got on."""
        self._idle = 0.0
        self.stalled = False

    def why_over(self, gets_on: Callable[[], bool] = lambda: False) -> str:
        """Counts the time since the last call; returns why the run must be ended, empty while it may go on.

        Args:
            gets_on: Asked when no progress was noted for long: whether there is some.
        """
        passed, self._now = self._context.now - self._now, self._context.now
        if not self._context.questions.open:
            self._taken += passed
            self._idle += passed
        if self._idle > _STALLED and gets_on():
            self.progress()
        self.stalled = self._idle > _STALLED and not self._may_stall
        if self._taken > self._limit:
            if self._duration is None:
                return Message("took longer than {seconds:g} s", seconds=self._limit)
            both = {"seconds": self._limit, "usual": self._duration}
            return Message("took longer than {seconds:g} s, {usual:g} s are usual", **both)
        if self._idle > self._longest_stall:
            return Message("made no progress for {seconds:g} s", seconds=self._longest_stall)
        return ""
