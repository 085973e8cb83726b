"""Events: what happens, as a stream or in pages, and the robots' state at this moment."""

from __future__ import annotations

import json
from collections.abc import AsyncIterator
from typing import Annotated, Any

from fastapi import Depends, Header, Path, Query

from skiros_py.api.events import EventInfo, EventPage, ResetInfo
from skiros_py.api.view import StationState
from skiros_py.server.access.roles import Caller, Role, Viewer, ViewerOrMes
from skiros_py.server.problems import Problem, topic_router
from skiros_py.server.services import Services
from skiros_py.server.streams import EVERYTHING, Choice, EventStream, find_position, missed, position_text
from skiros_py.station.events.log import Event, Kind

router = topic_router("events")

_OF_MES = frozenset({Kind.JOB, Kind.ALARM, Kind.SYSTEM})
"""What a factory system hears of; of its jobs it hears everything."""
_LOOKED_THROUGH = 20_000
"""So many events are looked through for one page: where few fit, the next page goes on from there."""

Kinds = Annotated[list[Kind] | None, Query(max_length=20, description="Only these kinds; may be repeated.")]
Types = Annotated[
    list[Annotated[str, Query(max_length=50)]] | None,
    Query(alias="type", max_length=50, description="Only these types; may be repeated.", examples=["Ended"]),
]
JobId = Annotated[str, Query(max_length=200, description="Only events of this job.")]
ElementId = Annotated[str, Query(max_length=200, description="Only events that affect this element.")]
After = Annotated[
    str | None,
    Query(
        max_length=100,
        description="Id of the last event seen; `Last-Event-ID` takes precedence.",
        examples=["1f2e3d4c-9"],
    ),
]
LastSeen = Annotated[
    str | None, Header(alias="Last-Event-ID", max_length=100, description="Id of the last event seen.")
]


async def _choice(
    act: ViewerOrMes, kind: Kinds = None, type_: Types = None, job: JobId = "", element: ElementId = ""
) -> Choice:
    """Returns which events somebody wants.

    Raises:
        Problem: They may not hear of them.
    """
    may = _OF_MES if act.caller.role is Role.MES and not job else EVERYTHING.kinds
    wanted = frozenset(kind or may)
    if not wanted <= may:
        allowed = ", ".join(sorted(may))
        raise Problem(
            403, "RoleTooLow", f"{act.caller.name} is {act.caller.role}, and hears of {allowed}; or name a job"
        )
    return Choice(wanted, frozenset(type_ or ()), job, element)


ChoiceDep = Annotated[Choice, Depends(_choice)]

_STREAM: dict[int | str, dict[str, Any]] = {
    200: {
        "description": "Server-sent events: `event` is the kind, `id` its place, `data` an event as JSON (or, where"
        " `event` is `reset`, what to read again because events are missing).",
        "content": {"text/event-stream": {"schema": {"type": "string"}}},
    }
}
_ENDLESS = {"x-endless": True}
"""Marks answers that do not end by themselves, for programs that try all routes."""


@router.get(
    "/events",
    response_class=EventStream,
    responses=_STREAM,
    openapi_extra=_ENDLESS,
)
async def stream_events(
    act: ViewerOrMes,
    choice: ChoiceDep,
    after: After = None,
    last_event_id: LastSeen = None,
) -> EventStream:
    """Stream events.

    Streams events as they happen, beginning after the last one seen.

    If events are missing, the stream begins with a `reset`, which says why and what to read again.
    """
    return _stream(act.services, act.caller, choice, _first_given(last_event_id, after))


@router.get("/events/recent")
def list_events(
    act: ViewerOrMes,
    choice: ChoiceDep,
    after: After = None,
    limit: Annotated[int, Query(ge=1, le=1000)] = 100,
) -> EventPage:
    """List events.

    Lists events after a position, oldest first, for clients that cannot keep a stream open; by default, all kept.
    """
    log = act.services.station.events
    place = log.first - 1 if not after else find_position(log, after)
    if isinstance(place, ResetInfo):
        return EventPage(items=(), next=place.id, reset=place)
    events, end = _page(act.services, place, choice, limit)
    gap = missed(log, place) if after and not events else None
    return EventPage(
        items=tuple(EventInfo.model_validate(json.loads(event.text)) for event in events),
        next=position_text(log, end),
        reset=gap,
    )


@router.get(
    "/jobs/{job}/events",
    response_class=EventStream,
    responses=_STREAM,
    openapi_extra=_ENDLESS,
)
def stream_job_events(
    act: ViewerOrMes,
    job: Annotated[str, Path(max_length=200)],
    after: After = None,
    last_event_id: LastSeen = None,
) -> EventStream:
    """Stream the events of a job.

    Streams the events of one job: first all recorded ones, or those after the last one seen.

    Parameters:
        job: Id of the job.
    """
    act.services.station.jobs.get(job)
    return _stream(act.services, act.caller, Choice(job=job), _first_given(last_event_id, after) or "")


@router.get(
    "/robots/state/stream",
    response_class=EventStream,
    responses={
        200: {"description": "Server-sent events: each `data` is a state.", "content": {"text/event-stream": {}}}
    },
    openapi_extra=_ENDLESS,
)
async def stream_state(
    act: Viewer,
    rate: Annotated[float, Query(ge=0.1, le=20.0, examples=[10])] = 10.0,
) -> EventStream:
    """Stream the state of the robots.

    Streams the current state of all robots. A slow client receives only the latest state.

    Parameters:
        rate: Maximum rate [Hz].
    """
    frames = act.services.streams.follow_state(act.services.station.live, rate, act.caller)
    return EventStream(frames, act.services.streams.listening(act.caller))


@router.get("/state")
def get_state(act: Viewer) -> StationState:
    """Get the state of the robots.

    Returns the current state of all robots.
    """
    return StationState.model_validate(act.services.station.live.state(act.services.station.session))


def _first_given(*places: str | None) -> str | None:
    return next((place for place in places if place), None)


def _stream(services: Services, caller: Caller, choice: Choice, after: str | None) -> EventStream:
    frames: AsyncIterator[bytes] = services.streams.follow(choice, caller, after)
    return EventStream(frames, services.streams.listening(caller))


def _page(services: Services, place: int, choice: Choice, limit: int) -> tuple[list[Event], int]:
    """Returns the first events after a place that fit, and the place behind what was looked through."""
    fitting: list[Event] = []
    for event in services.station.events.since(place, _LOOKED_THROUGH):
        place = event.number
        if choice.takes(event):
            fitting.append(event)
        if len(fitting) == limit:
            break
    return fitting, place
