"""Events on the wire: what happens, one after the other."""

from __future__ import annotations

from datetime import datetime
from typing import Any, Literal

from pydantic import Field

from skiros_py.api.wire import Answer

EventKind = Literal["world", "module", "task", "job", "alarm", "document", "system"]


class EventInfo(Answer):
    """One thing that happened."""

    id: str = Field(
        description="Names it; say it as `Last-Event-ID`, or `after`, to go on from there.", examples=["1f2e3d4c-128"]
    )
    number: int = Field(description="Counts events from 1 for each start of the server.", examples=[128])
    at: datetime = Field(description="When.", examples=["2026-11-20T09:30:00.125Z"])
    time: float = Field(description="When, in run time [s].", examples=[45.8])
    kind: EventKind = Field(description="What it is about.", examples=["job"])
    type: str = Field(
        description="What happened: `scene` or `learned` of the world; the status of a module, and `paused` or"
        " `resumed` of one that was started by itself; what happened in a task;"
        " the state of a job, as jobs name it (`Running`); `raised`, `changed`, `acknowledged`, `answered`, `cleared`"
        " of an alarm; `written`, `removed` of a document; `opened`, `closed`, `halted`, `reset` of the station.",
        examples=["Running"],
    )
    subject: str = Field(
        description="What it happened to: id of a job or alarm, name of a task, module or document.",
        examples=["kit-17"],
    )
    job: str = Field(description="Id of the job that it belongs to; empty where there is none.", examples=["kit-17"])
    data: dict[str, Any] = Field(
        description="All there is to say.", examples=[{"id": "kit-17", "version": 4, "state": "Running"}]
    )


class ResetInfo(Answer):
    """Events were missed that are no longer kept: read everything again, then go on from here."""

    id: str = Field(description="Where the events go on.", examples=["1f2e3d4c-4711"])
    kind: Literal["reset"] = Field(default="reset", description="Tells it from what happened.")
    code: Literal["restarted", "unknown", "future", "gone"] = Field(
        description="Why: the server was restarted; that id is none of this API; there is no such event yet; it is"
        " too long ago.",
        examples=["gone"],
    )
    why: str = Field(description="Why, in words.", examples=["the events 3 to 9000 are not kept any more"])
    read: tuple[str, ...] = Field(description="Where everything can be read as it is now.", examples=[["/api/v1/jobs"]])


class EventPage(Answer):
    """Some events, oldest first."""

    items: tuple[EventInfo, ...] = Field(description="The events.")
    next: str = Field(
        description="Where to go on: `after` of the next request, which may come at any time.",
        examples=["1f2e3d4c-128"],
    )
    reset: ResetInfo | None = Field(
        default=None, description="That some are missing which are not kept any more; null where all are there."
    )
