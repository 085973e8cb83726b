"""Routes: stopping everything, and the reset after a stop."""

from __future__ import annotations

import asyncio
import json
from typing import Any

from fastapi import Request
from starlette.exceptions import HTTPException
from starlette.requests import ClientDisconnect

from skiros_py.api.alarms import StopInfo, StopRequest
from skiros_py.server.access.roles import Operator, OperatorOrMes, ViewerOrMes
from skiros_py.server.problems import topic_router

router = topic_router("stop")

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


@router.get("/stop")
async def get_stop(act: ViewerOrMes) -> StopInfo:
    """Get the halt state.

    Returns whether everything is halted, why, since when and by whom, and whether all devices stand still.
    """
    return act.station.stops.now()


@router.post("/reset")
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
