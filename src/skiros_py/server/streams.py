"""The event streams: woken together, each at its own position in the log; none can delay the others."""

from __future__ import annotations

import asyncio
import logging
import re
import time
from collections.abc import AsyncIterator, Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass
from typing import Literal

from fastapi.responses import StreamingResponse
from fastapi.sse import format_sse_event
from starlette.types import Receive, Scope, Send

from skiros_py.api.events import ResetInfo
from skiros_py.server.access.limiters import Slots
from skiros_py.server.access.roles import Caller
from skiros_py.server.problems import Problem
from skiros_py.station.events.live import LiveState
from skiros_py.station.events.log import Event, EventLog, Kind

_PLACE = re.compile(r"([0-9a-f]{8})-(\d{1,18})", re.ASCII)

_READ = ("/api/v1/jobs", "/api/v1/world", "/api/v1/tasks", "/api/v1/alarms", "/api/v1/stop")
"""The routes at which the current state of the subjects of events can be read."""


def position_text(log: EventLog, number: int) -> str:
    """Returns the id of an event, which a client sends to continue after it."""
    return f"{log.epoch}-{number}"


def find_position(log: EventLog, given: str) -> int | ResetInfo:
    """Returns the position of a client from the id of its last event.

    Args:
        log: The events.
        given: Id of the last event that the client has seen.

    Returns:
        The number of that event if all later events are still kept; otherwise the gap to report to the client.
    """
    match = _PLACE.fullmatch(given.strip())
    if match is None:
        return _reset(log, "unknown", f"'{given[:60]}' is no id of an event")
    if match[1] != log.epoch:
        return _reset(log, "restarted", "the server was restarted since, and what happened before is not kept")
    number = int(match[2])
    if number > log.last:
        return _reset(log, "future", f"there is no event {number} yet: the last one is {log.last}")
    return missed(log, number) or number


def missed(log: EventLog, number: int) -> ResetInfo | None:
    """Returns the gap after the last event that a client has seen; None if the next event is still kept."""
    first = log.first
    if number + 1 >= first:
        return None
    return _reset(log, "gone", f"the events {number + 1} to {first - 1} are not kept any more")


def _reset(log: EventLog, code: Literal["restarted", "unknown", "future", "gone"], why: str) -> ResetInfo:
    return ResetInfo(id=position_text(log, log.last), code=code, why=why, read=_READ)


@dataclass(frozen=True, slots=True)
class Choice:
    """Selects events: those that match all attributes.

    Attributes:
        kinds: Kinds of events.
        types: Types of events, one word each; empty for any.
        job: Id of the job to which they belong; empty for any.
        element: Id of the world element that they concern; empty for any.
    """

    kinds: frozenset[Kind] = frozenset(Kind)
    types: frozenset[str] = frozenset()
    job: str = ""
    element: str = ""

    def takes(self, event: Event) -> bool:
        """Returns whether an event is selected."""
        return (
            event.kind in self.kinds
            and (not self.types or event.type in self.types)
            and (not self.job or event.job == self.job)
            and (not self.element or event.touches(self.element))
        )


EVERYTHING = Choice()


_log = logging.getLogger(__name__)

_STALLED = 60.0
"""A client that has received nothing for this time is disconnected, to make room for others [s]."""
_HEADERS = {"Cache-Control": "no-store", "X-Accel-Buffering": "no"}
"""Proxies must not buffer events."""


class EventStream(StreamingResponse):
    """Sends the events of a generator at the pace of the client: pending events are neither made nor buffered.

    Args:
        frames: The events, as server-sent events.
        place: Context manager entered while the stream lasts; counts the streams, and may refuse this one.
    """

    media_type = "text/event-stream"

    def __init__(
        self,
        frames: AsyncIterator[bytes],
        place: AbstractContextManager[None],
        *,
        status_code: int = 200,  # required by the OpenAPI description
    ) -> None:
        super().__init__(frames, status_code, headers=_HEADERS)
        self._place = place

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answers the request."""
        with self._place:
            try:
                await super().__call__(scope, receive, send)
            except TimeoutError:
                _log.warning("a client of %s takes no events for %g s: its stream ends", scope["path"], _STALLED)
                raise

    async def stream_response(self, send: Send) -> None:
        """Sends everything, but limits the time spent waiting for the client."""

        async def patiently(message: dict[str, object]) -> None:
            async with asyncio.timeout(_STALLED):
                await send(message)

        await super().stream_response(patiently)  # type: ignore[arg-type]


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
        self._slots = Slots("event streams", most, max(1, most // 2), retry_after=5.0)
        self._news = asyncio.Event()
        self._loop: asyncio.AbstractEventLoop | None = None
        self._called = False
        self._made: dict[tuple[int, Choice], tuple[int, bytes]] = {}
        self._made_at = 0
        log.on_event(self._call)

    @property
    def open(self) -> int:
        """Number of open streams."""
        return self._slots.taken

    def end(self) -> None:
        """Ends all streams and refuses new ones: the server shuts down. Callable from any thread."""
        self.ending = True
        self._call()

    # ------------------------------------------------------------------ slots for streams

    @contextmanager
    def listening(self, caller: Caller) -> Iterator[None]:
        """Takes a slot for the duration of the block.

        Raises:
            Problem: The server shuts down, all slots are taken, or too many of them by this caller (503).
        """
        if self.ending:
            raise Problem(503, "Busy", "the server shuts down", headers={"Retry-After": "5"})
        with self._slots.take(caller.key or caller.name):
            yield

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
        self._listen()
        while not self.ending and self.allowed(caller):
            news = self._news  # before the log is read, so that no event is missed
            number, text = self._next(number, choice)
            now = time.monotonic()
            if not text and now - sent >= _QUIET:  # browsers skip comments, but keep the position
                text = format_sse_event(comment="still here", id=position_text(self.log, number))
            if text:
                sent = now
                yield text
            if number == self.log.last:
                await news.wait()
            else:
                await asyncio.sleep(0)  # a stream with much to catch up on yields to the others

    async def follow_state(self, live: LiveState, rate: float, caller: Caller) -> AsyncIterator[bytes]:
        """Yields the current state of the robots as server-sent events; skips states for which the client is too slow.

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
            return self.log.last, _streams_reset(gap) if gap is not None else b""
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
        if isinstance(place, ResetInfo):
            number = self.log.last
            return number, _streams_reset(place)
        return place, format_sse_event(comment="events follow", id=position_text(self.log, place), retry=_AGAIN)

    # ------------------------------------------------------------------ waking

    def _listen(self) -> None:
        """Begins to wake the streams of this event loop, unless another stream did so."""
        loop = asyncio.get_running_loop()
        if loop is not self._loop:
            self._loop, self._news = loop, asyncio.Event()
            self._wake_periodically(loop)

    def _wake_periodically(self, loop: asyncio.AbstractEventLoop) -> None:
        """Wakes all streams even without events: one timer for all of them."""
        loop.call_later(_LOOK, self._wake_periodically, loop)
        self._wake()

    def _call(self) -> None:
        """Schedules waking all streams, once for a burst of events; callable from any thread."""
        loop = self._loop
        if self._called or loop is None:
            return
        self._called = True
        try:
            loop.call_soon_threadsafe(loop.call_later, _GATHER, self._wake)
        except RuntimeError:  # the event loop has ended
            self._called = False

    def _wake(self) -> None:
        self._called = False  # first, so that events from now on schedule another call
        self._news.set()
        self._news = asyncio.Event()


def _streams_reset(gap: ResetInfo) -> bytes:
    return format_sse_event(data_str=gap.model_dump_json(), event="reset", id=gap.id, retry=_AGAIN)
