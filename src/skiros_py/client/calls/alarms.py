"""Alarms: conditions that stopped a robot or need the user."""

from __future__ import annotations

from skiros_py.api.alarms import AlarmAnswer, AlarmInfo, AlarmPage
from skiros_py.client.request import Call, path_of


def list_alarms(*, active: bool | None = None, limit: int = 100, cursor: str | None = None) -> Call[AlarmPage]:
    """Lists alarms, oldest first: all, those that are active, or those that are over."""
    query = {"active": active, "limit": limit, "cursor": cursor}
    return Call("GET", "/alarms", AlarmPage, query)


def get_alarm(alarm: str) -> Call[AlarmInfo]:
    """Returns one alarm."""
    return Call("GET", path_of("alarms", alarm), AlarmInfo)


def acknowledge_alarm(alarm: str) -> Call[AlarmInfo]:
    """Acknowledges an alarm."""
    return Call("POST", path_of("alarms", alarm, "acknowledge"), AlarmInfo)


def answer_alarm(alarm: str, answer: str, *, question: int | None = None) -> Call[AlarmInfo]:
    """Answers the question of an alarm.

    Args:
        alarm: Its id.
        answer: One of its choices.
        question: Id of the question as seen by the caller, so that no other one is answered; None for the current one.
    """
    body = AlarmAnswer(answer=answer, question=question).model_dump(mode="json")
    return Call("POST", path_of("alarms", alarm, "answer"), AlarmInfo, json=body, repeatable=False)
