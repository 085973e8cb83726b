"""Routes: alarms, and stopping everything."""

from __future__ import annotations

import asyncio
import json
from typing import Annotated, Any

from fastapi import APIRouter, Path, Request, Response
from starlette.exceptions import HTTPException
from starlette.requests import ClientDisconnect

from skiros_py.api.alarms import AlarmAnswer, AlarmInfo, AlarmPage, StopInfo, StopRequest
from skiros_py.api.wire import moment
from skiros_py.server.access.audit import note
from skiros_py.server.access.roles import CallerDep, Role, needs
from skiros_py.server.problems import Problem
from skiros_py.server.routes.world import Cursor, Limit, number_cursor
from skiros_py.server.services import StationDep
from skiros_py.station.stops import Stopped

router = APIRouter(prefix="/alarms", tags=["alarms"])

AlarmId = Annotated[str, Path(max_length=200, description="Id of the alarm.", examples=["1f2e3d4c-7"])]


@router.get("", dependencies=[needs(Role.VIEWER, mes=True)])
def list_alarms(
    station: StationDep,
    active: bool | None = None,
    limit: Limit = 100,
    cursor: Cursor = None,
) -> AlarmPage:
    """List alarms.

    Lists alarms, oldest first: all active ones, and the last thousand inactive ones.

    Parameters:
        active: Only active alarms, or only inactive ones.
    """
    return station.alarms.all(active=active, limit=limit, after=number_cursor(cursor))


@router.get("/{alarm}", dependencies=[needs(Role.VIEWER, mes=True)])
def get_alarm(alarm: AlarmId, station: StationDep) -> AlarmInfo:
    """Get an alarm.

    Returns an alarm.
    """
    return station.alarms.get(alarm)


@router.post("/{alarm}/acknowledge", dependencies=[needs(Role.OPERATOR)])
def acknowledge_alarm(alarm: AlarmId, station: StationDep, caller: CallerDep) -> AlarmInfo:
    """Acknowledge an alarm.

    Records that a person has seen the alarm; it stays active until its cause is gone.
    """
    return station.alarms.acknowledge(alarm, caller.author)


@router.post("/{alarm}/answer", dependencies=[needs(Role.OPERATOR, mes=True)])
def answer_alarm(
    alarm: AlarmId, answer: AlarmAnswer, request: Request, station: StationDep, caller: CallerDep
) -> AlarmInfo:
    """Answer an alarm.

    Passes an answer to the waiting job or robot; the alarm ends when the answer was accepted.

    The answer applies to the question that this alarm asks now. If the request names a `question` and another one is
    asked by now, it is refused (409).
    """
    known = station.alarms.get(alarm)
    note(request, job=known.job, comment=answer.answer)
    if caller.role is Role.MES and not known.job:
        raise Problem(403, "RoleTooLow", f"{caller.name} is mes, and answers for jobs; this is for an operator")
    return station.alarms.answer(alarm, answer, caller.author)


stop_router = APIRouter(tags=["stop"])

_LONGEST = 1000
_FOR_THE_BODY = 0.1
"""How long the reason is waited for; the stop does not need one [s]."""

_BODY: dict[str, Any] = {
    "requestBody": {
        "required": False,
        "content": {"application/json": {"schema": StopRequest.model_json_schema()}},
    }
}


@stop_router.post(
    "/stop",
    dependencies=[needs(Role.OPERATOR, mes=True)],
    openapi_extra=_BODY,
    responses={202: {"model": StopInfo, "description": "The control thread does not run: do not rely on it."}},
)
async def stop(request: Request, response: Response, station: StationDep, caller: CallerDep) -> StopInfo:
    """Stop everything.

    Halts all robots in the next control cycle, bypassing all queues.

    Running jobs are held, and nothing moves until a person resets the station and answers. The request is obeyed even
    if its body is invalid.
    """
    reason = await _reason(request) or "a stop was asked for"
    stopped = await station.stops.stop(reason, caller.name)
    if not stopped.obeyed:
        response.status_code = 202
    return _info(stopped)


@stop_router.get("/stop", dependencies=[needs(Role.VIEWER, mes=True)])
async def get_stop(station: StationDep) -> StopInfo:
    """Get the halt state.

    Returns whether everything is halted, why, since when and by whom, and whether all devices stand still.
    """
    return _info(station.stops.now())


@stop_router.post("/reset", dependencies=[needs(Role.OPERATOR)])
def reset(station: StationDep, caller: CallerDep) -> StopInfo:
    """Reset a halt.

    Allows motion again after a halt. First check why it was halted, and that no person is near.

    Held jobs continue when they are answered. If nothing is halted, this has no effect.
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
