"""Event streams that survive broken connections and server restarts."""

from __future__ import annotations

import asyncio
import random
import time
from collections.abc import AsyncIterator, Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Generic, TypeVar

import httpx2
from httpx2 import ServerSentEvent

from skiros_py.api.events import EventInfo, EventKind, ResetInfo
from skiros_py.api.view import StationState
from skiros_py.client.request import Unreachable, path_of, problem_of

T = TypeVar("T")

_FIRST, _LONGEST = 0.2, 5.0
"""First and longest wait between two connection attempts [s]."""
_QUIET = 30.0
"""How long the server may be silent before it counts as gone; it sends a heartbeat every ten seconds [s]."""
_LATER = (429, 502, 503, 504)
"""Status codes that mean: retry later."""


@dataclass(frozen=True, slots=True)
class Stream(Generic[T]):
    """An event stream as a value, to be followed.

    Attributes:
        path: Path below ``/api/v1``, already quoted.
        read: Parses an item from a server-sent event.
        query: Query parameters; None leaves one out.
    """

    path: str
    read: Callable[[ServerSentEvent], T]
    query: Mapping[str, Any] = field(default_factory=dict)


def stream_events(
    *, kinds: Sequence[EventKind] = (), types: Sequence[str] = (), job: str = "", element: str = ""
) -> Stream[EventInfo | ResetInfo]:
    """Streams events.

    Args:
        kinds: Only events of these kinds; empty for all.
        types: Only events of these types; empty for all.
        job: Only events of this job.
        element: Only events that affect this element of the world.
    """
    return Stream("/events", _event, {"kind": list(kinds), "type": list(types), "job": job, "element": element})


def stream_job_events(job: str) -> Stream[EventInfo | ResetInfo]:
    """Streams the events of a job, starting with those already recorded."""
    return Stream(path_of("jobs", job, "events"), _event)


def stream_state(rate: float = 10.0) -> Stream[StationState]:
    """Streams the robots' state.

    Args:
        rate: How often at most [Hz]; up to 20.
    """
    return Stream("/robots/state/stream", lambda event: StationState.model_validate_json(event.data), {"rate": rate})


def _event(event: ServerSentEvent) -> EventInfo | ResetInfo:
    if event.event == "reset":
        return ResetInfo.model_validate_json(event.data)
    return EventInfo.model_validate_json(event.data)


def follow(http: httpx2.Client, stream: Stream[T], *, after: str | None = None, patience: float = 60.0) -> Iterator[T]:
    """Yields events indefinitely; close the iterator, or leave the loop, to stop.

    A broken connection is re-established without missing or repeating events; if the server cannot fill a gap, there
    is a :class:`~skiros_py.api.events.ResetInfo` among the items.

    Args:
        http: The HTTP client; its base URL is that of the API.
        stream: The stream to follow.
        after: Id of the last event seen; None for events from now on (for a job: all that are kept).
        patience: How long the server may stay silent before this gives up [s].

    Raises:
        ProblemError: The server refuses.
        Unreachable: The server does not answer.
    """
    place = _Place(stream, after, patience, str(http.base_url))
    while True:
        try:
            with http.sse(**place.request()) as source:
                if source.response.status_code == httpx2.codes.OK:
                    for event in source:
                        if place.takes(event):
                            yield stream.read(event)
                else:
                    source.response.read()
                    place.refused(source.response)
        except httpx2.RequestError as error:
            place.fault = error
        time.sleep(place.wait())


async def follow_later(
    http: httpx2.AsyncClient, stream: Stream[T], *, after: str | None = None, patience: float = 60.0
) -> AsyncIterator[T]:
    """Yields events like :func:`follow`, for ``async for``."""
    place = _Place(stream, after, patience, str(http.base_url))
    while True:
        try:
            async with http.sse(**place.request()) as source:
                if source.response.status_code == httpx2.codes.OK:
                    async for event in source:
                        if place.takes(event):
                            yield stream.read(event)
                else:
                    await source.response.aread()
                    place.refused(source.response)
        except httpx2.RequestError as error:
            place.fault = error
        await asyncio.sleep(place.wait())


@dataclass(slots=True)
class _Place:
    """A client's position in a stream, and its patience."""

    stream: Stream[Any]
    after: str | None
    patience: float
    url: str
    heard: float = field(default_factory=time.monotonic)
    tries: int = 0
    fault: Exception | None = None
    asked: float = 0.0

    def request(self) -> dict[str, Any]:
        """Returns the request arguments for the stream."""
        query = {name: value for name, value in self.stream.query.items() if value not in (None, "", (), [])}
        headers = {"Last-Event-ID": self.after} if self.after else {}
        return {"url": self.stream.path, "params": query, "headers": headers, "timeout": httpx2.Timeout(_QUIET)}

    def refused(self, response: httpx2.Response) -> None:
        """Records that the server serves no stream now.

        Raises:
            ProblemError: It will not do so later either.
        """
        self.fault = problem = problem_of(response)
        if response.status_code not in _LATER:
            raise problem
        self.asked = min(problem.retry_after or 0.0, _LONGEST)

    def takes(self, event: ServerSentEvent) -> bool:
        """Records the position in the stream; returns False for events that only carry the position."""
        self.heard, self.tries, self.fault, self.asked = time.monotonic(), 0, None, 0.0
        self.after = event.id or self.after
        return bool(event.data)

    def wait(self) -> float:
        """Returns how long to wait before the next try [s].

        Raises:
            Unreachable: The server has not answered for too long.
        """
        if time.monotonic() - self.heard > self.patience:
            raise Unreachable(self.url, str(self.fault or "it ends every connection at once"))
        longest = min(_LONGEST, _FIRST * 2.0**self.tries)
        self.tries = min(self.tries + 1, 10)
        return max(self.asked, random.uniform(0.5, 1.0) * longest)  # noqa: S311 - keeps clients apart
