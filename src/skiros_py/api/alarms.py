"""Alarms on the wire: what stopped a robot, or waits for a person; and stopping everything."""

from __future__ import annotations

import enum
from datetime import datetime

from pydantic import Field

from skiros_py.api.wire import Answer, Page, Request


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

    id: str = Field(examples=["1f2e3d4c-7"])
    """Names this alarm, and never another one."""
    kind: AlarmKind = Field(examples=["job"])
    """What it is about."""
    severity: Severity = Field(examples=["high"])
    """How soon somebody has to look."""
    text: str = Field(examples=["job kit-17 is held: the program ended between two steps: look, then answer"])
    """What there is, in the operator's words."""
    source: str = Field(examples=["kit-17"])
    """What it comes from: a subsystem, a module, a job, …."""
    active: bool = Field(examples=[True])
    """Whether its reason is there."""
    state: str = Field(examples=["unacknowledged"])
    """After ISA-18.2: unacknowledged or acknowledged while it is active; returned (it went before anybody acknowledged
    it) or normal afterwards.
    """
    lasts: bool = Field(examples=[True])
    """True: it goes by itself when its reason does. False: it is over when somebody acknowledges it."""
    since: datetime = Field(examples=["2026-11-20T09:30:00Z"])
    """When it came."""
    until: datetime | None = Field(default=None, examples=[None])
    """When it went; null while it is active."""
    acknowledged: datetime | None = Field(default=None, examples=[None])
    """When it was acknowledged; null before."""
    by: str = Field(default="", examples=[""])
    """Who acknowledged it."""
    choices: tuple[str, ...] = Field(default=(), examples=[["retry", "abort"]])
    """The answers that it waits for; empty for none."""
    job: str = Field(default="", examples=["kit-17"])
    """Id of the job that waits; empty where none does."""
    question: int | None = Field(default=None, examples=[None])
    """Number of the question that a robot asks; null where none does."""


AlarmPage = Page[AlarmInfo]
"""Some alarms, oldest first."""


class AlarmAnswer(Request):
    """What a person answers."""

    answer: str = Field(max_length=200, examples=["retry"])
    """One of the alarm's choices."""
    question: int | None = Field(default=None, examples=[None])
    """The alarm's `question` that was seen: if it asks something else by now, the answer is refused."""


class StopRequest(Request):
    """Why everything shall stop; may be left out."""

    reason: str = Field(default="", max_length=1000, examples=["a person is in the cell"])
    """Why, for a person."""


class StopInfo(Answer):
    """Whether everything is halted."""

    halted: bool = Field(examples=[True])
    """Whether nothing may move until somebody resets it."""
    why: str = Field(default="", examples=["a person is in the cell"])
    """Why; empty where nothing is."""
    by: str = Field(default="", examples=["panel at the door"])
    """Who wanted it; empty where it was the watchdog or a module."""
    since: datetime | None = Field(default=None, examples=["2026-11-20T09:30:00.125Z"])
    """Since when; null while nothing is halted."""
    standing: bool | None = Field(examples=[True])
    """Whether all arms and bases stand; null if unknown: the control thread does not run."""
    obeyed: bool = Field(examples=[True])
    """Whether the control thread has come round since. If not, do not rely on it: press the button of the machine."""
