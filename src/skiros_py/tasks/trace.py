"""What happened in a task, in sentences for people and as data for machines."""

from __future__ import annotations

import enum
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields
from typing import Any

from skiros_py.listeners import Listeners

_LONGEST = 10_000
"""Entries kept of one task; the oldest go first."""


class TraceEventKind(enum.StrEnum):
    """What kind of thing happened."""

    BEGUN = "begun"
    """The task began."""
    PLANNED = "planned"
    """There is a plan; the data has its steps and their order."""
    NO_PLAN = "no plan"
    """There is none; the data has the reasons."""
    STARTED = "started"
    """A step started."""
    WAITS = "waits"
    """A step, or the whole task, waits for something that somebody else uses."""
    ENDED = "ended"
    """A step ended well."""
    FAILED = "failed"
    """A step failed."""
    BROKEN_OFF = "broken off"
    """A step was ended because it leads nowhere any more, or because somebody stopped the task."""
    RETRIED = "retried"
    """The plan still leads to the goal: the step that failed is done once more."""
    REPLANS = "replans"
    """The plan leads to the goal no longer."""
    GIVEN_UP = "given up"
    """A condition of the goal was given up."""
    ASKED = "asked"
    """A person was asked."""
    ANSWERED = "answered"
    """A person answered."""
    PAUSED = "paused"
    """Everything comes to a standstill where it is."""
    RESUMED = "resumed"
    """It goes on after a pause, or by one step."""
    STOPPED = "stopped"
    """Somebody wants the task to end."""
    FINISHED = "finished"
    """The task is over; the data has its outcome."""


@dataclass(frozen=True, slots=True)
class TraceEntry:
    """One thing that happened.

    Attributes:
        time: Run time [s].
        what: What kind of thing.
        text: The whole of it in a sentence.
        step: Number of the step in the order in which steps were started, from 1; None for what is about no step.
        skill: The skill of that step.
        arguments: Its arguments by parameter key.
        agent: Id of the subsystem that does it.
        data: What a machine may want besides, as plain data.
        id: Id of what this is about: the step, whose runs of modules have it as their parent, or the task.
        parent: Id of what that is part of: the task of a step; empty for a task.
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
        """Returns it as plain data."""
        plain = {one.name: getattr(self, one.name) for one in fields(self)}
        return plain | {"what": self.what.value, "arguments": dict(self.arguments), "data": dict(self.data)}


class Trace:
    """The entries of one task, oldest first; a bounded number of them.

    Args:
        longest: How many entries are kept.

    Attributes:
        forgotten: How many entries were dropped since.
    """

    def __init__(self, longest: int = _LONGEST) -> None:
        self._entries: deque[TraceEntry] = deque(maxlen=longest)
        self._listeners = Listeners[[TraceEntry]]("trace entries")
        self.forgotten = 0

    @property
    def entries(self) -> tuple[TraceEntry, ...]:
        """What is kept, oldest first."""
        return tuple(self._entries)

    def subscribe(self, listener: Callable[[TraceEntry], None]) -> Callable[[], None]:
        """Calls the listener with each new entry, in the control thread; it must be quick. Returns how to end that."""
        return self._listeners.add(listener)

    def add(self, entry: TraceEntry) -> None:
        """Takes an entry and hands it to all listeners."""
        self.forgotten += len(self._entries) == self._entries.maxlen
        self._entries.append(entry)
        self._listeners.notify(entry)

    def as_json(self) -> list[dict[str, Any]]:
        """Returns the entries as plain data."""
        return [entry.as_json() for entry in tuple(self._entries)]

    def __str__(self) -> str:
        return "\n".join(str(entry) for entry in tuple(self._entries))


def step_id(task: str, number: int) -> str:
    """Returns the id of a step: parent of the run that does it.

    Args:
        task: Name of its task.
        number: Its number among the steps that the task started, from 1.
    """
    return f"{task}#{number}"
