"""Alarms: what stopped a robot, or waits for a person; acknowledging and answering them."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Path, Query, Request

from skiros_py.api.alarms import AlarmAnswer, AlarmInfo, AlarmPage
from skiros_py.errors import StaleVersion, UnknownName, WrongState
from skiros_py.server.access.audit import note
from skiros_py.server.access.roles import CallerDep, Role, needs
from skiros_py.server.problems import Problem, found
from skiros_py.server.services import Services, ServicesDep
from skiros_py.station.alarms.alarms import Alarm, alarm_info

__all__ = ["router"]

router = APIRouter(prefix="/alarms", tags=["alarms"])

AlarmId = Annotated[str, Path(max_length=200, description="Id of the alarm.", examples=["1f2e3d4c-7"])]

_UNKNOWN = "UnknownAlarm"


@router.get("", summary="What stopped a robot, or waits for a person", dependencies=[needs(Role.VIEWER, mes=True)])
def list_alarms(
    services: ServicesDep,
    active: Annotated[bool | None, Query(description="Only those that are active, or only others.")] = None,
    limit: Annotated[int, Query(ge=1, le=1000, description="At most so many.")] = 100,
    cursor: Annotated[str, Query(max_length=200, description="From the page before.")] = "",
) -> AlarmPage:
    """Lists alarms, oldest first: all that are active, and the last thousand that are over."""
    alarms = [alarm for alarm in services.alarms.all if active is None or alarm.active is active]
    rest = [alarm for alarm in alarms if alarm.number > _number(cursor)]
    page = rest[:limit]
    further = str(page[-1].number) if len(rest) > limit else None
    return AlarmPage(items=tuple(map(alarm_info, page)), next=further)


@router.get("/{alarm}", summary="One alarm", dependencies=[needs(Role.VIEWER, mes=True)])
def get_alarm(alarm: AlarmId, services: ServicesDep) -> AlarmInfo:
    """Tells about one alarm."""
    with found(_UNKNOWN):
        return alarm_info(services.alarms.alarm(alarm))


@router.post("/{alarm}/acknowledge", summary="Acknowledge an alarm", dependencies=[needs(Role.OPERATOR)])
def acknowledge_alarm(alarm: AlarmId, services: ServicesDep, caller: CallerDep) -> AlarmInfo:
    """Notes that somebody has seen it; it goes when its reason does, and not because of this."""
    with found(_UNKNOWN):
        return alarm_info(services.alarms.acknowledge(alarm, caller.name))


@router.post("/{alarm}/answer", summary="Answer an alarm", dependencies=[needs(Role.OPERATOR, mes=True)])
def answer_alarm(
    alarm: AlarmId, answer: AlarmAnswer, request: Request, services: ServicesDep, caller: CallerDep
) -> AlarmInfo:
    """Passes an answer on to the job or the robot that waits for it; the alarm goes when they have taken it.

    It is an answer to what this alarm asks and to nothing later: who names the `question` that they have seen is told
    (409) where another is asked by now.
    """
    with found(_UNKNOWN):
        known = services.alarms.alarm(alarm)
    note(request, job=known.job, comment=answer.answer)
    if caller.role is Role.MES and not known.job:
        raise Problem(403, "RoleTooLow", f"{caller.name} is mes, and answers for jobs; this is for an operator")
    if known.job:
        _answer_job(services, known, answer, caller.name)
    else:
        _answer_question(services, known, answer, caller.name)
    return alarm_info(services.alarms.note_answer(alarm, answer.answer, caller.name))


def _answer_job(services: Services, alarm: Alarm, answer: AlarmAnswer, by: str) -> None:
    """Gives an answer to a job, which may have gone on and ask something else while this alarm is looked at.

    Raises:
        UnknownName: The alarm does not offer that answer.
        WrongState: The job waits for it no longer.
    """
    jobs = services.session.jobs
    job = jobs.open.get(alarm.job)  # before the alarm, which is then of this version or a later one
    now = services.alarms.require_choice(alarm.id, answer.answer, answer.question)
    if job is None or job.question != now.question:
        raise WrongState(f"job '{alarm.job}' does not wait for that answer any more: look what it asks now")
    try:
        jobs.answer(alarm.job, answer.answer, by=by, expects=job.version)
    except StaleVersion:
        raise WrongState(f"job '{alarm.job}' has gone on meanwhile: look what it asks now") from None


def _answer_question(services: Services, alarm: Alarm, answer: AlarmAnswer, by: str) -> None:
    """Gives an answer to a robot.

    Raises:
        UnknownName: The alarm does not offer that answer.
        WrongState: It waits for it no longer.
    """
    now = services.alarms.require_choice(alarm.id, answer.answer, answer.question)
    assert now.question is not None, "alarms that offer choices are those of jobs and of questions"
    try:
        services.session.questions.answer(now.question, answer.answer, by=by)
    except UnknownName as error:
        raise WrongState(f"the question is not open any more: {error}") from None


def _number(cursor: str) -> int:
    """Reads where a page begins.

    Raises:
        Problem: It is no cursor of ours.
    """
    if cursor and not (cursor.isascii() and cursor.isdecimal() and len(cursor) < 19):
        raise Problem(422, "InvalidRequest", "cursor: give what the page before said in 'next'")
    return int(cursor or 0)
