"""Who listens to events: woken together, each at its own place in the log, none of them waited for."""

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
"""For so long after an event others are gathered before the streams are woken: a burst wakes them once [s]."""
_QUIET = 10.0
"""After so long without an event a stream says that it is still there, and where it stands [s]."""
_LOOK = 1.0
"""How often a stream looks whether it may go on [s]."""
_MOST = 200
"""How many events a stream sends at once; the next ones are fetched when those have left."""
_LARGEST = 256_000
"""Bytes that a stream sends at once, or one event that is longer: who reads slowly holds no more than that."""
_AGAIN = 1000
"""When a client whose connection broke shall come again [ms]."""


class Streams:
    """The streams of one server.

    Args:
        log: The events.
        most: How many streams may be open at the same time; half of them may be one caller's.
        allowed: Returns whether a caller may go on listening; asked now and then, and may be replaced.

    Attributes:
        log: The events.
        allowed: Returns whether a caller may go on listening.
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
        """How many streams are open."""
        return self._open.total()

    def end(self) -> None:
        """Ends all streams, and lets none begin: the server shuts down. For any thread."""
        self.ending = True
        self._call()

    # ------------------------------------------------------------------ places for streams

    @contextmanager
    def listening(self, caller: Caller) -> Iterator[None]:
        """Takes one of the places while the block runs.

        Raises:
            Busy: All are taken, or too many of them by this caller.
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
                self._open += Counter()  # forgets who has none any more

    # ------------------------------------------------------------------ one stream

    async def follow(self, choice: Choice, caller: Caller, after: str | None) -> AsyncIterator[bytes]:
        """Yields events as server-sent events, until the caller may listen no longer or the server ends.

        Args:
            choice: Which events.
            caller: Who listens.
            after: Id of the last event that they have seen; None for what comes from now on, "" for all that is kept.
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
                    await asyncio.sleep(0)  # who has much to catch up with lets the others have their turn

    async def follow_state(self, live: LiveState, rate: float, caller: Caller) -> AsyncIterator[bytes]:
        """Yields the present state of the robots as server-sent events; what a client is too slow for is left out.

        Args:
            live: The state.
            rate: How often at most [Hz].
            caller: Who listens.
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
        """Returns what comes after a place: the place behind it, and its text, which may be empty.

        Streams that stand at one place and want the same get the same bytes, made once.
        """
        last = self.log.last
        if last != self._made_at:
            self._made_at, self._made = last, {}
        made = self._made.get((number, choice)) or self._batch(number, choice)
        if made[0] == last:  # of those who catch up each stands elsewhere
            self._made[number, choice] = made
        return made

    def _batch(self, number: int, choice: Choice) -> tuple[int, bytes]:
        events = self.log.since(number, _MOST)
        if events and events[0].number != number + 1:  # read too slowly
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
        """Returns where a stream begins, and what it says first: so that the client knows where it stands."""
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
        """Has a stream woken while the block runs; in the event loop."""
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
        """Wakes all streams now and then though nothing happens: one timer for all of them."""
        self._look = asyncio.get_running_loop().call_later(_LOOK, self._look_around)
        self._ring()

    def _call(self) -> None:
        """Has all streams woken soon; for any thread, and once for a burst of events."""
        loop = self._loop
        if self._called or not self._sleepers or loop is None:
            return
        self._called = True
        try:
            loop.call_soon_threadsafe(loop.call_later, _GATHER, self._wake)
        except RuntimeError:  # the event loop has ended
            self._called = False

    def _wake(self) -> None:
        self._called = False  # first: whatever comes from now on calls again
        self._ring()

    def _ring(self) -> None:
        for awake in self._sleepers:
            awake.set()


def _reset(gap: Reset) -> bytes:
    return format_sse_event(data_str=gap.text, event="reset", id=gap.place, retry=_AGAIN)


def _still_here(place: str) -> bytes:
    """A line that browsers skip, and the place: after a long quiet it is still known where the stream stood."""
    return format_sse_event(comment="still here", id=place)
