"""The trace of a task: its events as sentences and as data."""

from __future__ import annotations

import enum
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields, replace
from typing import Any

from skiros_py.execution.monitor import ModuleEvent, Monitor, Status
from skiros_py.listeners import Listeners
from skiros_py.messages import Message, messages_in
from skiros_py.planning.plan import Step
from skiros_py.skills.outcome import Outcome
from skiros_py.skills.parameters import Kind
from skiros_py.skills.skill import SkillDescription

_LONGEST = 10_000
"""How many entries are kept per task; the oldest are dropped first."""


class TraceEventKind(enum.StrEnum):
    """The kind of event."""

    BEGUN = "begun"
    """The task began."""
    REHEARSES = "rehearses"
    """It is carried out in a second physics world first."""
    REHEARSED = "rehearsed"
    """That has ended; the data has its result."""
    PLANNED = "planned"
    """There is a plan; the data has its steps and their order."""
    NO_PLAN = "no plan"
    """There is none; the data has the reasons."""
    STARTED = "started"
    """A step started."""
    WAITS = "waits"
    """A step, or the whole task, waits for something that another task uses."""
    ENDED = "ended"
    """A step ended well."""
    FAILED = "failed"
    """A step failed."""
    CANCELLED = "cancelled"
    """A step was cancelled because it was no longer useful or the task was stopped."""
    RETRIED = "retried"
    """The plan still leads to the goal: the failed step is repeated."""
    REPLANS = "replans"
    """The plan no longer leads to the goal."""
    GIVEN_UP = "given up"
    """A condition of the goal was given up."""
    ASKED = "asked"
    """A question was put to the user."""
    ANSWERED = "answered"
    """The user answered."""
    PAUSED = "paused"
    """Everything comes to a standstill."""
    RESUMED = "resumed"
    """It was resumed after a pause, or for one step."""
    STOPPED = "stopped"
    """The task was asked to stop."""
    FINISHED = "finished"
    """The task is over; the data has its outcome."""


@dataclass(frozen=True, slots=True)
class TraceEntry:
    """One event.

    Attributes:
        time: Run time [s].
        what: The kind of event.
        text: The event in one sentence.
        step: Number of the step in the order in which steps were started, from 1; None if it concerns no step.
        skill: The skill of that step.
        arguments: Its arguments by parameter key.
        agent: Id of the subsystem that runs it.
        data: Additional details as plain data.
        id: Id of the subject: the step (the parent of its module runs) or the task.
        parent: Id of the subject's parent: the task of a step; empty for a task.
    """

    time: float
    what: TraceEventKind
    text: str
    step: int | None = None
    skill: str = ""
    arguments: Mapping[str, str] = field(default_factory=dict)
    agent: str = ""
    data: Mapping[str, Any] = field(default_factory=dict)
    id: str = ""
    parent: str = ""

    def __str__(self) -> str:
        return f"{self.time:7.2f} s  {self.text}"

    def as_json(self) -> dict[str, Any]:
        """Returns it as plain data, with what its texts are made of."""
        plain = {one.name: getattr(self, one.name) for one in fields(self)}
        plain |= {"what": self.what.value, "arguments": dict(self.arguments), "data": dict(self.data)}
        return plain | {"texts": messages_in((self.text, self.data))}


@dataclass(frozen=True, slots=True)
class StepRun:
    """One started step.

    Attributes:
        number: Its number among all steps the task started, from 1; a repeated step gets a new one.
        step: The skill with its arguments.
        agent: Id of the subsystem that runs it.
        start: Run time [s].
    """

    number: int
    step: Step
    agent: str
    start: float


@dataclass(frozen=True, slots=True)
class StepEnd:
    """The end of a step.

    Attributes:
        run: The step.
        skill: Its skill.
        outcome: How it ended.
        time: Run time [s].
    """

    run: StepRun
    skill: SkillDescription
    outcome: Outcome
    time: float


class Trace:
    """The entries of one task, oldest first; a bounded number of them.

    Args:
        task: Name of the task.
        clock: Gives the run time [s].
        monitor: Where steps that wait are published as well; None for nowhere.
        longest: How many entries are kept.

    Attributes:
        forgotten: How many entries were dropped.
    """

    def __init__(
        self, task: str, clock: Callable[[], float], monitor: Monitor | None = None, *, longest: int = _LONGEST
    ) -> None:
        self._task = task
        self._clock = clock
        self._monitor = monitor
        self._entries: deque[TraceEntry] = deque(maxlen=longest)
        self._listeners = Listeners[[TraceEntry]]("trace entries")
        self.forgotten = 0

    @property
    def entries(self) -> tuple[TraceEntry, ...]:
        """The kept entries, oldest first."""
        return tuple(self._entries)

    def subscribe(self, listener: Callable[[TraceEntry], None]) -> Callable[[], None]:
        """Calls the listener with each new entry in the control thread, quickly; returns how to unsubscribe."""
        return self._listeners.add(listener)

    def write(
        self, what: TraceEventKind, text: str, data: Mapping[str, Any] | None = None, run: StepRun | None = None
    ) -> None:
        """Adds an entry and passes it to all listeners.

        Args:
            what: The kind of event.
            text: The event in one sentence.
            data: Further details as plain data.
            run: The step; number 0 if it has not started. None for the whole task.
        """
        entry = TraceEntry(self._clock(), what, text, data=data or {}, id=self._task)
        if run is not None:
            step = run.step
            entry = replace(entry, skill=step.skill, arguments=dict(step.arguments), agent=run.agent)
            if run.number:
                own = step_id(self._task, run.number)
                entry = replace(entry, step=run.number, id=own, parent=self._task)
        self.forgotten += len(self._entries) == self._entries.maxlen
        self._entries.append(entry)
        self._listeners.notify(entry)
        if what is TraceEventKind.WAITS and self._monitor is not None:
            waits, own = Message("waits: {why}", why=entry.data["reason"]), self._task
            event = ModuleEvent(
                entry.time, "skill", entry.skill, Status.RUNNING, 0, waits, agent=entry.agent, task=own, id=own
            )
            self._monitor.publish(event)

    def __str__(self) -> str:
        return "\n".join(str(entry) for entry in tuple(self._entries))


def step_id(task: str, number: int) -> str:
    """Returns the id of a step, which is the parent id of its module run.

    Args:
        task: Name of its task.
        number: Its number among the steps that the task started, from 1.
    """
    return f"{task}#{number}"


def describe_step(step: Step, skill: SkillDescription) -> str:
    """Returns a step as text: agent, skill and arguments."""
    return f"{step.arguments[skill.agent]}: {short_step(step, skill)}"


def short_step(step: Step, skill: SkillDescription) -> str:
    """Returns a step in short: the skill and its user-specified arguments, without devices and derived ones."""
    said = [
        str(step.arguments[p.key])
        for p in skill.params
        if p.key in step.arguments and p.kind not in (Kind.HARDWARE, Kind.PLANNING)
    ]
    return " ".join((step.skill, *said))
