"""Stop: everything halts in the next control cycle, and starts again only after a reset."""

from __future__ import annotations

import asyncio
import json
from typing import Any

from fastapi import APIRouter, Request, Response
from starlette.exceptions import HTTPException
from starlette.requests import ClientDisconnect

from skiros_py.api.stop import StopInfo, StopRequest
from skiros_py.api.wire import moment
from skiros_py.server.access.roles import CallerDep, Role, needs
from skiros_py.server.services import StationDep
from skiros_py.station.stops import Stopped

router = APIRouter(tags=["stop"])

_LONGEST = 1000
_FOR_THE_BODY = 0.1
"""How long the reason is waited for; the stop does not need one [s]."""

_BODY: dict[str, Any] = {
    "requestBody": {
        "required": False,
        "content": {"application/json": {"schema": StopRequest.model_json_schema()}},
    }
}


@router.post(
    "/stop",
    summary="Stop everything",
    dependencies=[needs(Role.OPERATOR, mes=True)],
    openapi_extra=_BODY,
    responses={202: {"model": StopInfo, "description": "The control thread does not run: do not rely on it."}},
)
async def stop(request: Request, response: Response, station: StationDep, caller: CallerDep) -> StopInfo:
    """Halts all robots in the next control cycle, past all queues.

    Running jobs are held, and nothing moves until somebody resets the station and answers. Whatever is wrong with the
    body of this request, it is obeyed.
    """
    reason = await _reason(request) or "a stop was asked for"
    stopped = await station.stops.stop(reason, caller.name)
    if not stopped.obeyed:
        response.status_code = 202
    return _info(stopped)


@router.get("/stop", summary="See whether everything is halted", dependencies=[needs(Role.VIEWER, mes=True)])
async def get_stop(station: StationDep) -> StopInfo:
    """Returns whether everything is halted, why, since when and by whom, and whether all stands."""
    return _info(station.stops.now())


@router.post("/reset", summary="Let things start again", dependencies=[needs(Role.OPERATOR)])
def reset(station: StationDep, caller: CallerDep) -> StopInfo:
    """Lets things start again after a halt; look first why that was, and that no person is near.

    Held jobs go on when they are answered. Where nothing is halted, this changes nothing.
    """
    return _info(station.stops.reset(caller.name))


def _info(stopped: Stopped) -> StopInfo:
    return StopInfo.view_of(stopped, halted=bool(stopped.why), since=moment(stopped.since))


async def _reason(request: Request) -> str:
    """Returns the reason in a request's body; empty where there is none that can be read in time."""
    try:
        body = await asyncio.wait_for(request.body(), _FOR_THE_BODY)
        given = json.loads(body)["reason"]
    except (TimeoutError, ClientDisconnect, HTTPException, ValueError, LookupError, TypeError, RecursionError):
        return ""
    # What cannot be written as UTF-8 must not come back in an answer or go into a file.
    return given[:_LONGEST].encode("utf-8", "replace").decode("utf-8") if isinstance(given, str) else ""
