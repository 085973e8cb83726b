"""Events on the wire: what happens, one after the other."""

from __future__ import annotations

from datetime import datetime
from typing import Any, Literal

from pydantic import Field

from skiros_py.api.wire import Answer

EventKind = Literal["world", "module", "task", "job", "alarm", "document", "system"]


class EventInfo(Answer):
    """One thing that happened."""

    id: str = Field(examples=["1f2e3d4c-128"])
    """Names it; say it as `Last-Event-ID`, or `after`, to go on from there."""
    number: int = Field(examples=[128])
    """Counts events from 1 for each start of the server."""
    at: datetime = Field(examples=["2026-11-20T09:30:00.125Z"])
    """When."""
    time: float = Field(examples=[45.8])
    """When, in run time [s]."""
    kind: EventKind = Field(examples=["job"])
    """What it is about."""
    type: str = Field(examples=["Running"])
    """What happened: `scene` or `learned` of the world; the status of a module, and `paused` or `resumed` of one that
    was started by itself; what happened in a task; the state of a job, as jobs name it (`Running`); `raised`,
    `changed`, `acknowledged`, `answered`, `cleared` of an alarm; `written`, `removed` of a document; `opened`,
    `closed`, `halted`, `reset` of the station.
    """
    subject: str = Field(examples=["kit-17"])
    """What it happened to: id of a job or alarm, name of a task, module or document."""
    job: str = Field(examples=["kit-17"])
    """Id of the job that it belongs to; empty where there is none."""
    data: dict[str, Any] = Field(examples=[{"id": "kit-17", "version": 4, "state": "Running"}])
    """All there is to say."""


class ResetInfo(Answer):
    """Events were missed that are no longer kept: read everything again, then go on from here."""

    id: str = Field(examples=["1f2e3d4c-4711"])
    """Where the events go on."""
    kind: Literal["reset"] = "reset"
    """Tells it from what happened."""
    code: Literal["restarted", "unknown", "future", "gone"] = Field(examples=["gone"])
    """Why: the server was restarted; that id is none of this API; there is no such event yet; it is too long ago."""
    why: str = Field(examples=["the events 3 to 9000 are not kept any more"])
    """Why, in words."""
    read: tuple[str, ...] = Field(examples=[["/api/v1/jobs"]])
    """Where everything can be read as it is now."""


class EventPage(Answer):
    """Some events, oldest first."""

    items: tuple[EventInfo, ...]
    """The events."""
    next: str = Field(examples=["1f2e3d4c-128"])
    """Where to go on: `after` of the next request, which may come at any time."""
    reset: ResetInfo | None = None
    """That some are missing which are not kept any more; null where all are there."""
