"""Events, in pages or as a stream, and the current state of the robots."""

from __future__ import annotations

from collections.abc import Sequence

from httpx2 import ServerSentEvent

from skiros_py.api.events import EventInfo, EventKind, EventPage, ResetInfo
from skiros_py.api.view import StationState
from skiros_py.client.request import Call, path_of
from skiros_py.client.streams import Stream


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


def list_events(
    *,
    kinds: Sequence[EventKind] = (),
    types: Sequence[str] = (),
    job: str = "",
    element: str = "",
    after: str | None = None,
    limit: int = 100,
) -> Call[EventPage]:
    """Lists the events after a given one, oldest first; the page gives the cursor for the next."""
    query = {
        "kind": list(kinds) or None,
        "type": list(types) or None,
        "job": job or None,
        "element": element or None,
        "after": after,
        "limit": limit,
    }
    return Call("GET", "/events/recent", EventPage, query)


def get_state() -> Call[StationState]:
    """Returns the current state of all robots."""
    return Call("GET", "/state", StationState)


def _event(event: ServerSentEvent) -> EventInfo | ResetInfo:
    if event.event == "reset":
        return ResetInfo.model_validate_json(event.data)
    return EventInfo.model_validate_json(event.data)
