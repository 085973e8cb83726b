"""The events that a listener has selected, and its position in the log, which shows what it has missed."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any

from skiros_py.station.events.event import Event, Kind, as_text
from skiros_py.station.events.log import EventLog

_PLACE = re.compile(r"([0-9a-f]{8})-(\d{1,18})", re.ASCII)

_READ = ("/api/v1/jobs", "/api/v1/world", "/api/v1/tasks", "/api/v1/alarms", "/api/v1/stop")
"""The routes at which the present state of the subjects of events can be read."""


@dataclass(frozen=True, slots=True)
class Reset:
    """A gap that cannot be filled: the client must read everything again and continue from here.

    Attributes:
        code: The reason, for programs: "restarted", "unknown", "future" or "gone".
        why: The reason, in words.
        place: Position from which the events continue.
    """

    code: str
    why: str
    place: str

    def as_json(self) -> dict[str, Any]:
        """Returns plain data."""
        return {"id": self.place, "kind": "reset", "code": self.code, "why": self.why, "read": list(_READ)}

    @property
    def text(self) -> str:
        """The gap as JSON, in one line."""
        return as_text(self.as_json())


def position_text(log: EventLog, number: int) -> str:
    """Returns the id of an event, which a client sends to continue after it."""
    return f"{log.epoch}-{number}"


def find_position(log: EventLog, given: str) -> int | Reset:
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


def missed(log: EventLog, number: int) -> Reset | None:
    """Returns the gap after the last event that a client has seen; None if the next event is still kept."""
    first = log.first
    if number + 1 >= first:
        return None
    return _reset(log, "gone", f"the events {number + 1} to {first - 1} are not kept any more")


def _reset(log: EventLog, code: str, why: str) -> Reset:
    return Reset(code, why, position_text(log, log.last))


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
