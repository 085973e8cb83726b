"""Routes: alarms; stopping everything, and the reset after a stop."""

from __future__ import annotations

import asyncio
import json
from typing import Annotated, Any

from fastapi import Path, Request
from starlette.exceptions import HTTPException
from starlette.requests import ClientDisconnect

from skiros_py.api.alarms import AlarmAnswer, AlarmInfo, AlarmPage, StopInfo, StopRequest
from skiros_py.server.access.audit import note
from skiros_py.server.access.roles import Operator, OperatorOrMes, Role, ViewerOrMes
from skiros_py.server.problems import Problem, topic_router
from skiros_py.server.routes.world import Cursor, Limit, number_cursor

router = topic_router("alarms", "/alarms")

AlarmId = Annotated[str, Path(max_length=200, description="Id of the alarm.", examples=["1f2e3d4c-7"])]


@router.get("")
def list_alarms(
    act: ViewerOrMes,
    active: bool | None = None,
    limit: Limit = 100,
    cursor: Cursor = None,
) -> AlarmPage:
    """List alarms.

    Lists alarms, oldest first: all active ones, and the last thousand inactive ones.

    Parameters:
        active: Only active alarms, or only inactive ones.
    """
    return act.station.alarms.all(active=active, limit=limit, after=number_cursor(cursor))


@router.get("/{alarm}")
def get_alarm(act: ViewerOrMes, alarm: AlarmId) -> AlarmInfo:
    """Get an alarm.

    Returns an alarm.
    """
    return act.station.alarms.get(alarm)


@router.post("/{alarm}/acknowledge")
def acknowledge_alarm(act: Operator, alarm: AlarmId) -> AlarmInfo:
    """Acknowledge an alarm.

    Records that a person has seen the alarm; it stays active until its cause is gone.
    """
    return act.station.alarms.acknowledge(alarm, act.author)


@router.post("/{alarm}/answer")
def answer_alarm(act: OperatorOrMes, alarm: AlarmId, answer: AlarmAnswer) -> AlarmInfo:
    """Answer an alarm.

    Passes an answer to the waiting job or robot; the alarm ends when the answer was accepted.

    The answer applies to the question that this alarm asks now. If the request names a `question` and another one is
    asked by now, it is refused (409).
    """
    known = act.station.alarms.get(alarm)
    note(act.request, job=known.job, comment=answer.answer)
    if act.caller.role is Role.MES and not known.job:
        raise Problem(403, "RoleTooLow", f"{act.caller.name} is mes, and answers for jobs; this is for an operator")
    return act.station.alarms.answer(alarm, answer, act.author)


stop_router = topic_router("stop")

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
    openapi_extra=_BODY,
    responses={202: {"model": StopInfo, "description": "The control thread does not run: do not rely on it."}},
)
async def stop(act: OperatorOrMes) -> StopInfo:
    """Stop everything.

    Halts all robots in the next control cycle, bypassing all queues.

    Running jobs are held, and nothing moves until a person resets the station and answers. The request is obeyed even
    if its body is invalid.
    """
    reason = await _reason(act.request) or "a stop was asked for"
    stopped = await act.station.stops.stop(reason, act.caller.name)
    if not stopped.obeyed:
        act.response.status_code = 202
    return stopped


@stop_router.get("/stop")
async def get_stop(act: ViewerOrMes) -> StopInfo:
    """Get the halt state.

    Returns whether everything is halted, why, since when and by whom, and whether all devices stand still.
    """
    return act.station.stops.now()


@stop_router.post("/reset")
def reset(act: Operator) -> StopInfo:
    """Reset a halt.

    Allows motion again after a halt. First check why it was halted, and that no person is near.

    Held jobs continue when they are answered. If nothing is halted, this has no effect.
    """
    return act.station.stops.reset(act.caller.name)


async def _reason(request: Request) -> str:
    """Returns the reason in a request's body; empty where there is none that can be read in time."""
    try:
        body = await asyncio.wait_for(request.body(), _FOR_THE_BODY)
        given = json.loads(body)["reason"]
    except (TimeoutError, ClientDisconnect, HTTPException, ValueError, LookupError, TypeError, RecursionError):
        return ""
    # What cannot be written as UTF-8 must not come back in an answer or go into a file.
    return given[:_LONGEST].encode("utf-8", "replace").decode("utf-8") if isinstance(given, str) else ""
