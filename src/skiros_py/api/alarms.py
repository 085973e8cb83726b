"""Alarms on the wire: what stopped a robot, or waits for a person; and stopping everything."""

from __future__ import annotations

import enum
from datetime import datetime

from pydantic import Field, StrictInt

from skiros_py.api.wire import Page, Request, Sentence, Told


class Severity(enum.StrEnum):
    """How urgent the alarm is."""

    CRITICAL = "critical"
    """Immediate: nothing works."""
    HIGH = "high"
    """Soon: something is stopped until a person responds."""
    MEDIUM = "medium"
    """Today: something does not work properly, everything else continues."""
    LOW = "low"
    """A warning."""


class AlarmKind(enum.StrEnum):
    """The subject of an alarm."""

    HALTED = "halted"
    """Everything was halted: by a person, the watchdog or a module."""
    STATION = "station"
    """The control cycle failed: the station is closed until it is reopened."""
    CYCLE = "cycle"
    """A call blocks the control cycle and does not return."""
    MANAGER = "manager"
    """A skill manager is lost."""
    MODULE = "module"
    """A module is faulty: an error in its code."""
    TASK = "task"
    """A task ended with a fault, for example of a planner."""
    QUESTION = "question"
    """A robot asks a question."""
    JOB = "job"
    """A job is held and waits for an answer."""
    RECORD = "record"
    """A stored record, such as a job, cannot be read: it is left out of all lists."""
    PLUGIN = "plug-in"
    """A plug-in does not load, or its signal provider was switched off or left out."""
    STALE = "stale"
    """A change takes effect only after a reset of the simulation, or a restart."""
    DISK = "disk"
    """The disk cannot be written: everything is paused, and goes on by itself as soon as it can."""
    CAMERA = "camera"
    """A camera sees things elsewhere than it should: it has to be calibrated."""
    WEBHOOK = "webhook"
    """A message could not be delivered to another system."""


class AlarmInfo(Told):
    """One alarm."""

    id: str = Field(examples=["1f2e3d4c-7"])
    """Its unique id."""
    kind: AlarmKind = Field(examples=["job"])
    """Its kind."""
    severity: Severity = Field(examples=["high"])
    """How urgent the alarm is."""
    text: Sentence = Field(examples=["job kit-17 is held: the program ended between two steps: look, then answer"])
    """Description for the operator."""
    source: str = Field(examples=["kit-17"])
    """Its source: a subsystem, a module, a job, …."""
    active: bool = Field(examples=[True])
    """Whether its cause persists."""
    state: str = Field(examples=["unacknowledged"])
    """State of ISA-18.2: unacknowledged or acknowledged while it is active; afterwards returned (if it was not
    acknowledged) or normal.
    """
    lasts: bool = Field(examples=[True])
    """True: it ends when its cause does. False: it ends when it is acknowledged."""
    since: datetime = Field(examples=["2026-11-20T09:30:00Z"])
    """When it was raised."""
    until: datetime | None = Field(default=None, examples=[None])
    """When it ended; null while it is active."""
    acknowledged: datetime | None = Field(default=None, examples=[None])
    """When it was acknowledged; null if it was not."""
    by: str = Field(default="", examples=[""])
    """Who acknowledged it."""
    choices: tuple[str, ...] = Field(default=(), examples=[["retry", "abort"]])
    """The possible answers; empty if it needs none."""
    job: str = Field(default="", examples=["kit-17"])
    """Id of the waiting job; empty if there is none."""
    question: StrictInt | None = Field(default=None, examples=[None])
    """Number of the robot's question; null if there is none."""


AlarmPage = Page[AlarmInfo]
"""Some alarms, oldest first."""


class AlarmAnswer(Request):
    """An answer by a person."""

    answer: str = Field(max_length=200, examples=["retry"])
    """One of the alarm's choices."""
    question: StrictInt | None = Field(default=None, examples=[None])
    """The alarm's `question` that was seen; if it asks another one by now, the answer is refused."""


class StopRequest(Request):
    """The reason for a stop; optional."""

    reason: str = Field(default="", max_length=1000, examples=["a person is in the cell"])
    """Reason, for people."""


class StopInfo(Told):
    """Whether everything is halted."""

    halted: bool = Field(examples=[True])
    """Whether nothing may move until a reset."""
    why: Sentence = Field(default="", examples=["a person is in the cell"])
    """Reason; empty if nothing is halted."""
    by: str = Field(default="", examples=["panel at the door"])
    """Who requested it; empty for the watchdog or a module."""
    since: datetime | None = Field(default=None, examples=["2026-11-20T09:30:00.125Z"])
    """Since when; null if nothing is halted."""
    standing: bool | None = Field(examples=[True])
    """Whether all devices stand still; null if unknown, because the control thread does not run."""
    obeyed: bool = Field(examples=[True])
    """Whether the control thread has executed it. If not, do not rely on it: use the emergency stop of the machine."""
