"""Events on the wire: what happens, one after the other."""

from __future__ import annotations

from datetime import datetime
from typing import Any, Literal

from pydantic import Field

from skiros_py.api.wire import Answer, Page

EventKind = Literal["world", "module", "task", "job", "alarm", "document", "system"]


class EventInfo(Answer):
    """An event."""

    id: str = Field(examples=["1f2e3d4c-128"])
    """Its id; as `Last-Event-ID` or `after`, continues after it."""
    number: int = Field(examples=[128])
    """Number of the event, from 1 at each start of the server."""
    at: datetime = Field(examples=["2026-11-20T09:30:00.125Z"])
    """When it happened (UTC)."""
    time: float = Field(examples=[45.8])
    """When it happened [s, run time]."""
    kind: EventKind = Field(examples=["job"])
    """Its kind."""
    type: str = Field(examples=["Running"])
    """What happened: `scene` or `learned` of the world; the status of a module, and `paused` or `resumed` of one that
    was started by itself; what happened in a task; the state of a job, as jobs name it (`Running`); `raised`,
    `changed`, `acknowledged`, `answered`, `cleared` of an alarm; `written`, `removed` of a document; `opened`,
    `closed`, `halted`, `reset` of the station.
    """
    subject: str = Field(examples=["kit-17"])
    """Its subject: id of a job or alarm, name of a task, module or document."""
    job: str = Field(examples=["kit-17"])
    """Id of its job; empty if there is none."""
    data: dict[str, Any] = Field(examples=[{"id": "kit-17", "version": 4, "state": "Running"}])
    """Data of the event."""


class ResetInfo(Answer):
    """Some missed events are no longer stored: read everything again, then continue from here."""

    id: str = Field(examples=["1f2e3d4c-4711"])
    """Position at which the events continue."""
    kind: Literal["reset"] = "reset"
    """Distinguishes it from events."""
    code: Literal["restarted", "unknown", "future", "gone"] = Field(examples=["gone"])
    """Why: the server was restarted; the id is invalid; there is no such event yet; it is too old."""
    why: str = Field(examples=["the events 3 to 9000 are not kept any more"])
    """Reason, as text."""
    read: tuple[str, ...] = Field(examples=[["/api/v1/jobs"]])
    """Address of the current state."""


class EventPage(Page[EventInfo]):
    """Some events, oldest first."""

    next: str = Field(examples=["1f2e3d4c-128"])
    """`after` of the next request, which may be sent at any time."""
    reset: ResetInfo | None = None
    """Set if some events are no longer stored; null if all are included."""
