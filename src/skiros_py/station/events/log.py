"""The recent events, in order: written by any thread, and read by streams at their own speed."""

from __future__ import annotations

import enum
import json
import math
import secrets
import threading
import time
from collections import deque
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Any

from skiros_py.listeners import Listeners
from skiros_py.messages import messages_in

_ID = b"\nid: "
"""Terminator of the text in a server-sent event; text in one line cannot contain it."""
_LONGEST = 64_000
"""Maximum number of characters of one event's data; longer data is omitted, and the event says so."""


class Kind(enum.StrEnum):
    """The subject of an event."""

    WORLD = "world"
    """A change of the believed world."""
    MODULE = "module"
    """A skill or primitive started, made progress, was paused, or ended."""
    TASK = "task"
    """Something happened in a task: a plan, a step, a question."""
    JOB = "job"
    """A job has a new version."""
    ALARM = "alarm"
    """An alarm was raised, answered, acknowledged, or cleared."""
    DOCUMENT = "document"
    """A goal template or a sequence was written, or removed."""
    SYSTEM = "system"
    """The station itself: reopened, halted, reset."""


@dataclass(frozen=True, slots=True)
class Event:
    """One event. It is serialised immediately, so that all listeners receive the same bytes.

    Attributes:
        number: Its number, without gaps, from 1 for each start of the server.
        wall: Its time [s since 1970].
        time: Its time, in run time [s].
        kind: Its kind.
        type: Its type, one word of its kind ("changed", "started", "aborted").
        subject: The subject: id of a job, name of a task or module; empty for a change of the world.
        job: Id of the job to which it belongs; empty if there is none.
        elements: Ids of the world elements that it concerns; None if they are too many to list.
        frame: The event as a server-sent event.
    """

    number: int
    wall: float
    time: float
    kind: Kind
    type: str
    subject: str
    job: str
    elements: frozenset[str] | None
    frame: bytes

    @property
    def text(self) -> str:
        """The event as JSON, in one line."""
        return self.frame[len(_head(self.kind)) : self.frame.rindex(_ID)].decode()

    @property
    def data(self) -> Mapping[str, Any]:
        """The details, as plain data."""
        data: Mapping[str, Any] = json.loads(self.text)["data"]
        return data

    def touches(self, element: str) -> bool:
        """Returns whether it concerns, or may concern, a world element."""
        return self.elements is None or element in self.elements


def _head(kind: Kind) -> bytes:
    """Returns the prefix of the text in a server-sent event."""
    return f"event: {kind.value}\ndata: ".encode()


def as_text(data: object) -> str:
    """Returns data as JSON in one line; values that JSON cannot represent become text or null."""
    try:
        return json.dumps(data, separators=(",", ":"), allow_nan=False, default=str)
    except (ValueError, TypeError, RecursionError):  # NaN, or a key that is not a string
        return json.dumps(_plain(data, 20), separators=(",", ":"), default=str)


def _plain(value: object, depth: int) -> object:
    """Returns the value with parts that JSON cannot represent as text or None, down to a maximum depth."""
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if depth == 0:
        return str(value)[:100]
    if isinstance(value, Mapping):
        return {str(key): _plain(one, depth - 1) for key, one in value.items()}
    if isinstance(value, list | tuple | set | frozenset):
        return [_plain(one, depth - 1) for one in value]
    return value


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
        last: Number of the last event; 0 before the first.
    """

    def __init__(self, kept: int, clock: Callable[[], float] = lambda: 0.0, *, room: int = 32_000_000) -> None:
        self.epoch = secrets.token_hex(4)
        self.clock = clock
        self.last = 0
        self._events: deque[Event] = deque()
        self._kept = kept
        self._room = room
        self._size = 0
        self._guard = threading.Lock()
        self._listeners = Listeners[[]]("events")

    @property
    def first(self) -> int:
        """Number of the oldest event that is kept; one more than :attr:`last` if none is."""
        with self._guard:
            return self.last - len(self._events) + 1

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
        """Appends an event and calls the listeners; does not block; callable from any thread.

        The data gets what its sentences are made of, as ``texts``.
        """
        touched, data = frozenset(elements), data or {}
        if "texts" not in data and (texts := messages_in(data)):
            data = {**data, "texts": texts}
        listed = touched if len(touched) <= _MOST_ELEMENTS else None
        with self._guard:
            number, wall, now = self.last + 1, time.time(), self.clock()
            head: dict[str, Any] = {
                "id": f"{self.epoch}-{number}",
                "number": number,
                "at": datetime.fromtimestamp(wall, UTC).isoformat(timespec="milliseconds").replace("+00:00", "Z"),
                "time": now,
                "kind": kind.value,
                "type": type_,
                "subject": subject,
                "job": job,
            }
            text = as_text(data)
            if len(text) > _LONGEST:
                left_out = f"{len(text)} characters are too many for an event: read it where it is kept"
                text = as_text({"left_out": left_out})
            frame = f'event: {kind.value}\ndata: {as_text(head)[:-1]},"data":{text}}}\nid: {head["id"]}\n\n'.encode()
            event = Event(number, wall, now, kind, type_, subject, job, listed, frame)
            self._events.append(event)
            self.last = number
            self._size += len(frame)
            while len(self._events) > self._kept or self._size > self._room:
                self._size -= len(self._events.popleft().frame)
        self._listeners.notify()
        return event

    def since(self, number: int, most: int = 500) -> list[Event]:
        """Returns the events after a number, oldest first, up to a limit; events no longer kept are skipped."""
        with self._guard:
            first = self.last - len(self._events) + 1
            skip = max(0, number + 1 - first)
            end = min(len(self._events), skip + most)
            return [self._events[index] for index in range(skip, end)]

    def on_event(self, listener: Callable[[], None]) -> Callable[[], None]:
        """Calls the listener after each event, in the thread of the event; returns a function that removes it."""
        return self._listeners.add(listener)
