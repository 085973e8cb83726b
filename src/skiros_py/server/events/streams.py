"""The event streams: woken together, each at its own position in the log; none can delay the others."""

from __future__ import annotations

import asyncio
import threading
import time
from collections import Counter
from collections.abc import AsyncIterator, Callable, Iterator
from contextlib import contextmanager

from fastapi.sse import format_sse_event

from skiros_py.errors import Busy
from skiros_py.server.access.roles import Caller
from skiros_py.server.events.positions import Choice, Reset, find_position, missed, position_text
from skiros_py.station.events.live import LiveState
from skiros_py.station.events.log import EventLog

_GATHER = 0.01
"""Delay between an event and waking the streams, so that a burst of events wakes them once [s]."""
_QUIET = 10.0
"""Time without an event after which a stream sends a keep-alive with its position [s]."""
_LOOK = 1.0
"""Period at which a stream checks whether its caller still has permission [s]."""
_MOST = 200
"""Number of events that a stream sends at once; the next ones are fetched when these have been sent."""
_LARGEST = 256_000
"""Bytes that a stream sends at once, or one event if that is longer: the limit of a slow reader's memory."""
_AGAIN = 1000
"""Time after which a client reconnects when its connection is lost [ms]."""


class Streams:
    """The streams of one server.

    Args:
        log: The events.
        most: Maximum number of open streams; one caller may have half of them.
        allowed: Returns whether a caller may continue to listen; called periodically, and may be replaced.

    Attributes:
        log: The events.
        allowed: Returns whether a caller may continue to listen.
        ending: True when all streams are to end.
    """

    def __init__(self, log: EventLog, most: int, allowed: Callable[[Caller], bool] = lambda _caller: True) -> None:
        self.log = log
        self.allowed = allowed
        self.ending = False
        self._most = most
        self._open: Counter[str] = Counter()
        self._guard = threading.Lock()
        self._sleepers: set[asyncio.Event] = set()
        self._loop: asyncio.AbstractEventLoop | None = None
        self._look: asyncio.TimerHandle | None = None
        self._called = False
        self._made: dict[tuple[int, Choice], tuple[int, bytes]] = {}
        self._made_at = 0
        log.on_event(self._call)

    @property
    def open(self) -> int:
        """Number of open streams."""
        return self._open.total()

    def end(self) -> None:
        """Ends all streams and refuses new ones: the server shuts down. Callable from any thread."""
        self.ending = True
        self._call()

    # ------------------------------------------------------------------ slots for streams

    @contextmanager
    def listening(self, caller: Caller) -> Iterator[None]:
        """Takes a slot for the duration of the block.

        Raises:
            Busy: All slots are taken, or too many of them by this caller.
        """
        name = caller.key or caller.name
        with self._guard:
            if self.ending or self.open >= self._most:
                raise Busy(f"{self.open} event streams are open, and no more are served", retry_after=5.0)
            if self._open[name] >= max(1, self._most // 2):
                raise Busy(f"{caller.name} has {self._open[name]} event streams open: close some", retry_after=5.0)
            self._open[name] += 1
        try:
            yield
        finally:
            with self._guard:
                self._open[name] -= 1
                self._open += Counter()  # removes callers without streams

    # ------------------------------------------------------------------ one stream

    async def follow(self, choice: Choice, caller: Caller, after: str | None) -> AsyncIterator[bytes]:
        """Yields events as server-sent events until the caller loses permission or the server ends.

        Args:
            choice: Selects the events.
            caller: The caller who listens.
            after: Id of the last event that the caller has seen; None for new events only, "" for all that are kept.
        """
        number, first = self._begin(after)
        yield first
        sent = time.monotonic()
        with self._awake() as awake:
            while not self.ending and self.allowed(caller):
                number, text = self._next(number, choice)
                now = time.monotonic()
                if not text and now - sent >= _QUIET:
                    text = _still_here(position_text(self.log, number))
                if text:
                    sent = now
                    yield text
                if number == self.log.last:
                    await awake.wait()
                    awake.clear()
                else:
                    await asyncio.sleep(0)  # a stream with much to catch up on yields to the others

    async def follow_state(self, live: LiveState, rate: float, caller: Caller) -> AsyncIterator[bytes]:
        """Yields the present state of the robots as server-sent events; skips states for which the client is too slow.

        Args:
            live: The state.
            rate: Maximum rate [Hz].
            caller: The caller who listens.
        """
        due = sent = time.monotonic()
        while not self.ending and self.allowed(caller):
            now = time.monotonic()
            text = live.text(now)
            if text:
                yield format_sse_event(data_str=text, event="state")
                sent = now
            elif now - sent > _QUIET:  # no session is open
                yield format_sse_event(comment="still here")
                sent = now
            due = max(due + 1.0 / rate, time.monotonic())
            await asyncio.sleep(due - time.monotonic())

    def _next(self, number: int, choice: Choice) -> tuple[int, bytes]:
        """Returns the position after the next events, and their text, which may be empty.

        Streams with the same position and choice share the same bytes, which are made once.
        """
        last = self.log.last
        if last != self._made_at:
            self._made_at, self._made = last, {}
        made = self._made.get((number, choice)) or self._batch(number, choice)
        if made[0] == last:  # streams that are catching up all have different positions
            self._made[number, choice] = made
        return made

    def _batch(self, number: int, choice: Choice) -> tuple[int, bytes]:
        events = self.log.since(number, _MOST)
        if events and events[0].number != number + 1:  # the client reads too slowly
            gap = missed(self.log, number)
            return self.log.last, _reset(gap) if gap is not None else b""
        chosen, size = list[bytes](), 0
        for event in events:
            if choice.takes(event):
                size += len(event.frame)
                if chosen and size > _LARGEST:
                    break
                chosen.append(event.frame)
            number = event.number
        return number, b"".join(chosen)

    def _begin(self, after: str | None) -> tuple[int, bytes]:
        """Returns the start position of a stream, and its first text, from which the client learns the position."""
        place = (
            self.log.last if after is None else self.log.first - 1 if after == "" else find_position(self.log, after)
        )
        if isinstance(place, Reset):
            number = self.log.last
            return number, _reset(place)
        return place, format_sse_event(comment="events follow", id=position_text(self.log, place), retry=_AGAIN)

    # ------------------------------------------------------------------ waking

    @contextmanager
    def _awake(self) -> Iterator[asyncio.Event]:
        """Registers a stream for waking for the duration of the block; in the event loop."""
        awake = asyncio.Event()
        self._loop = asyncio.get_running_loop()
        self._sleepers.add(awake)
        if self._look is None:
            self._look = self._loop.call_later(_LOOK, self._look_around)
        try:
            yield awake
        finally:
            self._sleepers.discard(awake)
            if not self._sleepers and self._look is not None:
                self._look.cancel()
                self._look = None

    def _look_around(self) -> None:
        """Wakes all streams periodically even without events: one timer for all of them."""
        self._look = asyncio.get_running_loop().call_later(_LOOK, self._look_around)
        self._ring()

    def _call(self) -> None:
        """Schedules waking all streams, once for a burst of events; callable from any thread."""
        loop = self._loop
        if self._called or not self._sleepers or loop is None:
            return
        self._called = True
        try:
            loop.call_soon_threadsafe(loop.call_later, _GATHER, self._wake)
        except RuntimeError:  # the event loop has ended
            self._called = False

    def _wake(self) -> None:
        self._called = False  # first, so that events from now on schedule another call
        self._ring()

    def _ring(self) -> None:
        for awake in self._sleepers:
            awake.set()


def _reset(gap: Reset) -> bytes:
    return format_sse_event(data_str=gap.text, event="reset", id=gap.place, retry=_AGAIN)


def _still_here(place: str) -> bytes:
    """Returns a line that browsers skip, with the position, so that the client knows it even after a long pause."""
    return format_sse_event(comment="still here", id=place)
