"""Alarms: what stopped a robot, or waits for a person."""

from __future__ import annotations

from skiros_py.api.alarms import AlarmAnswer, AlarmInfo, AlarmPage
from skiros_py.client.call import Call, path_of


def list_alarms(*, active: bool | None = None, limit: int = 100, cursor: str | None = None) -> Call[AlarmPage]:
    """Lists alarms, oldest first: all, those that are active, or those that are over."""
    query = {"active": active, "limit": limit, "cursor": cursor}
    return Call("GET", "/alarms", AlarmPage, query)


def get_alarm(alarm: str) -> Call[AlarmInfo]:
    """Describes one alarm."""
    return Call("GET", path_of("alarms", alarm), AlarmInfo)


def acknowledge_alarm(alarm: str) -> Call[AlarmInfo]:
    """Notes that somebody has seen it."""
    return Call("POST", path_of("alarms", alarm, "acknowledge"), AlarmInfo)


def answer_alarm(alarm: str, answer: str, *, question: int | None = None) -> Call[AlarmInfo]:
    """Answers who waits.

    Args:
        alarm: Its id.
        answer: One of its choices.
        question: What it asked when it was looked at, so that nothing else is answered; None for whatever it asks.
    """
    body = AlarmAnswer(answer=answer, question=question).model_dump(mode="json")
    return Call("POST", path_of("alarms", alarm, "answer"), AlarmInfo, json=body, repeatable=False)
