"""Alarms on the wire: what stopped a robot, or waits for a person; and stopping everything."""

from __future__ import annotations

import enum
from datetime import datetime

from pydantic import Field

from skiros_py.api.wire import Answer, Request


class Severity(enum.StrEnum):
    """How soon somebody has to look."""

    CRITICAL = "critical"
    """At once: nothing works any more."""
    HIGH = "high"
    """Soon: something stands until somebody comes."""
    MEDIUM = "medium"
    """Today: something does not work as it should, the rest goes on."""
    LOW = "low"
    """A warning: good to know."""


class AlarmKind(enum.StrEnum):
    """What an alarm is about."""

    HALTED = "halted"
    """Everything was halted: by somebody, by the watchdog, by a module."""
    STATION = "station"
    """The control cycle broke: there is no station until it is reopened."""
    CYCLE = "cycle"
    """Something holds the control cycle, and does not come back."""
    MANAGER = "manager"
    """A skill manager is lost."""
    MODULE = "module"
    """A module is broken: a mistake in somebody's code."""
    TASK = "task"
    """A task ended with a fault, such as a planner that broke."""
    QUESTION = "question"
    """A robot asks a person."""
    JOB = "job"
    """A job is held, and waits for an answer."""
    PLUGIN = "plug-in"
    """A plug-in does not load, or its signal provider was switched off or left out."""
    STALE = "stale"
    """Something was changed so that only a reset of the simulation, or a new start, brings it about."""
    WEBHOOK = "webhook"
    """Something could not be delivered to another system."""


class AlarmInfo(Answer):
    """One alarm."""

    id: str = Field(description="Names this alarm, and never another one.", examples=["1f2e3d4c-7"])
    kind: AlarmKind = Field(description="What it is about.", examples=["job"])
    severity: Severity = Field(description="How soon somebody has to look.", examples=["high"])
    text: str = Field(
        description="What there is, in the operator's words.",
        examples=["job kit-17 is held: the program ended between two steps: look, then answer"],
    )
    source: str = Field(description="What it comes from: a subsystem, a module, a job, ….", examples=["kit-17"])
    active: bool = Field(description="Whether its reason is there.", examples=[True])
    state: str = Field(
        description="After ISA-18.2: unacknowledged or acknowledged while it is active; returned (it went before"
        " anybody acknowledged it) or normal afterwards.",
        examples=["unacknowledged"],
    )
    lasts: bool = Field(
        description="True: it goes by itself when its reason does. False: it is over when somebody acknowledges it.",
        examples=[True],
    )
    since: datetime = Field(description="When it came.", examples=["2026-11-20T09:30:00Z"])
    until: datetime | None = Field(default=None, description="When it went; null while it is active.", examples=[None])
    acknowledged: datetime | None = Field(
        default=None, description="When it was acknowledged; null before.", examples=[None]
    )
    by: str = Field(default="", description="Who acknowledged it.", examples=[""])
    choices: tuple[str, ...] = Field(
        default=(), description="The answers that it waits for; empty for none.", examples=[["retry", "abort"]]
    )
    job: str = Field(default="", description="Id of the job that waits; empty where none does.", examples=["kit-17"])
    question: int | None = Field(
        default=None, description="Number of the question that a robot asks; null where none does.", examples=[None]
    )


class AlarmPage(Answer):
    """Some alarms, oldest first."""

    items: tuple[AlarmInfo, ...] = Field(description="The alarms.")
    next: str | None = Field(default=None, description="Where to go on (`cursor`); null where these were the last.")


class AlarmAnswer(Request):
    """What a person answers."""

    answer: str = Field(max_length=200, description="One of the alarm's choices.", examples=["retry"])
    question: int | None = Field(
        default=None,
        description="The alarm's `question` that was seen: if it asks something else by now, the answer is refused.",
        examples=[None],
    )


class StopRequest(Request):
    """Why everything shall stop; may be left out."""

    reason: str = Field(
        default="", max_length=1000, description="Why, for a person.", examples=["a person is in the cell"]
    )


class StopInfo(Answer):
    """Whether everything is halted."""

    halted: bool = Field(description="Whether nothing may move until somebody resets it.", examples=[True])
    why: str = Field(default="", description="Why; empty where nothing is.", examples=["a person is in the cell"])
    by: str = Field(
        default="",
        description="Who wanted it; empty where it was the watchdog or a module.",
        examples=["panel at the door"],
    )
    since: datetime | None = Field(
        default=None, description="Since when; null while nothing is halted.", examples=["2026-11-20T09:30:00.125Z"]
    )
    standing: bool | None = Field(
        description="Whether all arms and bases stand; null if unknown: the control thread does not run.",
        examples=[True],
    )
    obeyed: bool = Field(
        description="Whether the control thread has come round since. If not, do not rely on it: press the button of"
        " the machine.",
        examples=[True],
    )
