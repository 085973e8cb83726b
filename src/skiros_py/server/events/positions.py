"""Which events a listener wants, and its position in the log: what it has missed."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any

from skiros_py.station.events.event import Event, Kind, as_text
from skiros_py.station.events.log import EventLog

_PLACE = re.compile(r"([0-9a-f]{8})-(\d{1,18})", re.ASCII)

_READ = ("/api/v1/jobs", "/api/v1/world", "/api/v1/tasks", "/api/v1/alarms", "/api/v1/stop")
"""Where what events tell of can be read as it is now."""


@dataclass(frozen=True, slots=True)
class Reset:
    """A gap that cannot be filled: read everything again, then go on from here.

    Attributes:
        code: Why, for programs: "restarted", "unknown", "future" or "gone".
        why: Why, in words.
        place: Where the events go on.
    """

    code: str
    why: str
    place: str

    def as_json(self) -> dict[str, Any]:
        """Returns plain data."""
        return {"id": self.place, "kind": "reset", "code": self.code, "why": self.why, "read": list(_READ)}

    @property
    def text(self) -> str:
        """It as JSON, in one line."""
        return as_text(self.as_json())


def position_text(log: EventLog, number: int) -> str:
    """Returns the id of an event: what a client says to go on from there."""
    return f"{log.epoch}-{number}"


def find_position(log: EventLog, given: str) -> int | Reset:
    """Finds out where a client stands that says which event was its last.

    Args:
        log: The events.
        given: Id of the last event that it has seen.

    Returns:
        The number of that event, when all that came later is still kept; else what it has to be told.
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
    """Returns what a client has to be told that has seen events up to a number; None where the next one is kept."""
    first = log.first
    if number + 1 >= first:
        return None
    return _reset(log, "gone", f"the events {number + 1} to {first - 1} are not kept any more")


def _reset(log: EventLog, code: str, why: str) -> Reset:
    return Reset(code, why, position_text(log, log.last))


@dataclass(frozen=True, slots=True)
class Choice:
    """Which events somebody wants: those that fit all of this.

    Attributes:
        kinds: Kinds of events.
        types: What happened, in one word; empty for anything.
        job: Id of the job that they belong to; empty for any.
        element: Id of the element of the world that they touch; empty for any.
    """

    kinds: frozenset[Kind] = frozenset(Kind)
    types: frozenset[str] = frozenset()
    job: str = ""
    element: str = ""

    def takes(self, event: Event) -> bool:
        """Returns whether an event is among them."""
        return (
            event.kind in self.kinds
            and (not self.types or event.type in self.types)
            and (not self.job or event.job == self.job)
            and (not self.element or event.touches(self.element))
        )


EVERYTHING = Choice()
