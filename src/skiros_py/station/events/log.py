"""The recent events, in order: written by any thread, and read by streams, each of which is a position in the log."""

from __future__ import annotations

import secrets
import threading
import time
from collections import deque
from collections.abc import Callable, Iterable, Mapping
from typing import Any

from skiros_py.listeners import Listeners
from skiros_py.station.events.event import Event, Kind, written

_MOST_ELEMENTS = 1000
"""Maximum number of elements listed in an event; one with more is treated as concerning any element."""


class EventLog:
    """A bounded log. A slow reader loses the oldest events and does not delay others.

    Args:
        kept: Number of events kept.
        clock: Returns the run time [s]; may be replaced.
        room: Maximum total size of the kept events [bytes].

    Attributes:
        epoch: Identifies this start of the server: event numbers of other starts are not valid here.
        clock: Returns the run time [s].
    """

    def __init__(self, kept: int, clock: Callable[[], float] = lambda: 0.0, *, room: int = 32_000_000) -> None:
        self.epoch = secrets.token_hex(4)
        self.clock = clock
        self._events: deque[Event] = deque()
        self._kept = kept
        self._room = room
        self._size = 0
        self._guard = threading.Lock()
        self._last = 0
        self._listeners = Listeners[[]]("events")

    @property
    def last(self) -> int:
        """Number of the last event; 0 before the first."""
        return self._last

    @property
    def first(self) -> int:
        """Number of the oldest event that is kept; one more than :attr:`last` if none is."""
        with self._guard:
            return self._last - len(self._events) + 1

    def append(
        self,
        kind: Kind,
        type_: str,
        subject: str = "",
        *,
        job: str = "",
        elements: Iterable[str] = (),
        data: Mapping[str, Any] | None = None,
    ) -> Event:
        """Appends an event and calls the listeners; does not block; callable from any thread."""
        touched = frozenset(elements)
        with self._guard:
            number, moment = self._last + 1, (time.time(), self.clock())
            listed = touched if len(touched) <= _MOST_ELEMENTS else None
            event = written(self.epoch, number, moment, kind, type_, subject, job, listed, data or {})
            self._keep(event)
        self._listeners.notify()
        return event

    def since(self, number: int, most: int = 500) -> list[Event]:
        """Returns the events after a number, oldest first, up to a limit; events no longer kept are skipped."""
        with self._guard:
            first = self._last - len(self._events) + 1
            skip = max(0, number + 1 - first)
            end = min(len(self._events), skip + most)
            return [self._events[index] for index in range(skip, end)]

    def on_event(self, listener: Callable[[], None]) -> Callable[[], None]:
        """Calls the listener after each event, in the thread of the event; returns a function that removes it."""
        return self._listeners.add(listener)

    def _keep(self, event: Event) -> None:
        self._events.append(event)
        self._last = event.number
        self._size += len(event.frame)
        while len(self._events) > self._kept or self._size > self._room:
            self._size -= len(self._events.popleft().frame)
