"""One thing that happened, as everybody outside hears of it."""

from __future__ import annotations

import enum
import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

__all__ = ["Event", "Kind"]


class Kind(enum.StrEnum):
    """What an event is about."""

    WORLD = "world"
    """A change of what is believed."""
    MODULE = "module"
    """A skill or primitive started, got on, or ended."""
    TASK = "task"
    """Something happened in a task: a plan, a step, a question."""
    JOB = "job"
    """A job has a new version."""
    ALARM = "alarm"
    """An alarm came, was answered, acknowledged, or went."""
    SYSTEM = "system"
    """The station itself: opened anew, halted, reset."""


@dataclass(frozen=True)
class Event:
    """One thing that happened.

    Attributes:
        number: Counts events without gaps, from 1 for each start of the server.
        wall: When [s since 1970].
        time: When, in run time [s].
        kind: What it is about.
        type: What happened, in one word of its kind ("changed", "started", "aborted").
        subject: What it happened to: id of a job, name of a task or module, empty for a change of the world.
        job: Id of the job that it belongs to; empty where there is none.
        elements: Ids of the elements of the world that it touches.
        data: All there is to say, as plain data.
    """

    number: int
    wall: float
    time: float
    kind: Kind
    type: str
    subject: str = ""
    job: str = ""
    elements: frozenset[str] = frozenset()
    data: Mapping[str, Any] = field(default_factory=dict)

    @cached_property
    def text(self) -> str:
        """The event as JSON, made once for all who get it."""
        return json.dumps(
            {
                "number": self.number,
                "wall": self.wall,
                "time": self.time,
                "kind": self.kind.value,
                "type": self.type,
                "subject": self.subject,
                "job": self.job,
                "data": self.data,
            },
            separators=(",", ":"),
        )
