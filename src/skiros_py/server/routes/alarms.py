"""Routes: alarms."""

from __future__ import annotations

from typing import Annotated

from fastapi import Path

from skiros_py.api.alarms import AlarmAnswer, AlarmInfo, AlarmPage
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
