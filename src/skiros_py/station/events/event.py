"""One thing that happened, as everybody outside hears of it."""

from __future__ import annotations

import enum
import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Any

_ID = b"\nid: "
"""What stands behind the text in a server-sent event; text in one line has no such thing in it."""
_LONGEST = 64_000
"""Characters of one event's data; what is longer is left out, and the event says so."""


class Kind(enum.StrEnum):
    """What an event is about."""

    WORLD = "world"
    """A change of what is believed."""
    MODULE = "module"
    """A skill or primitive started, got on, was paused, or ended."""
    TASK = "task"
    """Something happened in a task: a plan, a step, a question."""
    JOB = "job"
    """A job has a new version."""
    ALARM = "alarm"
    """An alarm came, was answered, acknowledged, or went."""
    DOCUMENT = "document"
    """A goal template or a sequence was written, or removed."""
    SYSTEM = "system"
    """The station itself: reopened, halted, reset."""


@dataclass(frozen=True, slots=True)
class Event:
    """One thing that happened. It is written down at once, ready to be sent: the same bytes for all who listen.

    Attributes:
        number: Counts events without gaps, from 1 for each start of the server.
        wall: When [s since 1970].
        time: When, in run time [s].
        kind: What it is about.
        type: What happened, in one word of its kind ("changed", "started", "aborted").
        subject: What it happened to: id of a job, name of a task or module, empty for a change of the world.
        job: Id of the job that it belongs to; empty where there is none.
        elements: Ids of the elements of the world that it touches; None where they are too many to be listed.
        frame: All of it as a server-sent event.
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
        """All of it as JSON, in one line."""
        return self.frame[len(_head(self.kind)) : self.frame.rindex(_ID)].decode()

    @property
    def data(self) -> Mapping[str, Any]:
        """All there is to say, as plain data."""
        data: Mapping[str, Any] = json.loads(self.text)["data"]
        return data

    def touches(self, element: str) -> bool:
        """Returns whether it is, or may be, about an element of the world."""
        return self.elements is None or element in self.elements


def written(
    epoch: str,
    number: int,
    moment: tuple[float, float],
    kind: Kind,
    type_: str,
    subject: str,
    job: str,
    elements: frozenset[str] | None,
    data: Mapping[str, Any],
) -> Event:
    """Writes an event down.

    Args:
        epoch: Names the start of the server.
        number: Its number.
        moment: When [s since 1970], and when in run time [s].
        kind: What it is about.
        type_: What happened.
        subject: What it happened to.
        job: Id of the job that it belongs to.
        elements: Ids of the elements that it touches; None for too many.
        data: All there is to say, as plain data.
    """
    wall, time = moment
    head: dict[str, Any] = {
        "id": f"{epoch}-{number}",
        "number": number,
        "at": datetime.fromtimestamp(wall, UTC).isoformat(timespec="milliseconds").replace("+00:00", "Z"),
        "time": time,
        "kind": kind.value,
        "type": type_,
        "subject": subject,
        "job": job,
    }
    said = as_text(data)
    if len(said) > _LONGEST:
        said = as_text({"left_out": f"{len(said)} characters are too many for an event: read it where it is kept"})
    text = f'{as_text(head)[:-1]},"data":{said}}}'
    frame = f"event: {kind.value}\ndata: {text}\nid: {head['id']}\n\n".encode()
    return Event(number, wall, time, kind, type_, subject, job, elements, frame)


def _head(kind: Kind) -> bytes:
    """What stands before the text in a server-sent event."""
    return f"event: {kind.value}\ndata: ".encode()


def as_text(data: object) -> str:
    """Writes plain data as JSON in one line, whatever is in it: what JSON has no words for becomes text or null."""
    try:
        return json.dumps(data, separators=(",", ":"), allow_nan=False, default=str)
    except (ValueError, TypeError, RecursionError):  # NaN, or a key that is no text
        return json.dumps(_plain(data, 20), separators=(",", ":"), default=str)


def _plain(value: object, depth: int) -> object:
    """Returns the value with what JSON has no words for as text or None, at most so many levels deep."""
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if depth == 0:
        return str(value)[:100]
    if isinstance(value, Mapping):
        return {str(key): _plain(one, depth - 1) for key, one in value.items()}
    if isinstance(value, list | tuple | set | frozenset):
        return [_plain(one, depth - 1) for one in value]
    return value
