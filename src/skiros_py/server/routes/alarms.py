"""Alarms: what stopped a robot, or waits for a person; acknowledging and answering them."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Path, Query, Request

from skiros_py.api.alarms import AlarmAnswer, AlarmInfo, AlarmPage
from skiros_py.server.access.audit import note
from skiros_py.server.access.roles import CallerDep, Role, needs
from skiros_py.server.problems import Problem
from skiros_py.server.services import StationDep

router = APIRouter(prefix="/alarms", tags=["alarms"])

AlarmId = Annotated[str, Path(max_length=200, description="Id of the alarm.", examples=["1f2e3d4c-7"])]


@router.get("", summary="What stopped a robot, or waits for a person", dependencies=[needs(Role.VIEWER, mes=True)])
def list_alarms(
    station: StationDep,
    active: Annotated[bool | None, Query(description="Only those that are active, or only others.")] = None,
    limit: Annotated[int, Query(ge=1, le=1000, description="At most so many.")] = 100,
    cursor: Annotated[str, Query(max_length=200, description="From the page before.")] = "",
) -> AlarmPage:
    """Lists alarms, oldest first: all that are active, and the last thousand that are over."""
    return station.alarms.all(active=active, limit=limit, after=_number(cursor))


@router.get("/{alarm}", summary="One alarm", dependencies=[needs(Role.VIEWER, mes=True)])
def get_alarm(alarm: AlarmId, station: StationDep) -> AlarmInfo:
    """Describes one alarm."""
    return station.alarms.get(alarm)


@router.post("/{alarm}/acknowledge", summary="Acknowledge an alarm", dependencies=[needs(Role.OPERATOR)])
def acknowledge_alarm(alarm: AlarmId, station: StationDep, caller: CallerDep) -> AlarmInfo:
    """Notes that somebody has seen it; it goes when its reason does, and not because of this."""
    return station.alarms.acknowledge(alarm, caller.author)


@router.post("/{alarm}/answer", summary="Answer an alarm", dependencies=[needs(Role.OPERATOR, mes=True)])
def answer_alarm(
    alarm: AlarmId, answer: AlarmAnswer, request: Request, station: StationDep, caller: CallerDep
) -> AlarmInfo:
    """Passes an answer on to the job or the robot that waits for it; the alarm goes when they have taken it.

    It is an answer to what this alarm asks and to nothing later: who names the `question` that they have seen is told
    (409) where another is asked by now.
    """
    known = station.alarms.get(alarm)
    note(request, job=known.job, comment=answer.answer)
    if caller.role is Role.MES and not known.job:
        raise Problem(403, "RoleTooLow", f"{caller.name} is mes, and answers for jobs; this is for an operator")
    return station.alarms.answer(alarm, answer, caller.author)


def _number(cursor: str) -> int:
    """Reads where a page begins.

    Raises:
        Problem: It is no cursor of ours.
    """
    if cursor and not (cursor.isascii() and cursor.isdecimal() and len(cursor) < 19):
        raise Problem(422, "InvalidRequest", "cursor: give what the page before said in 'next'")
    return int(cursor or 0)
