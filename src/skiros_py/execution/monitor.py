"""What is going on, as a stream: which module started, how far it is, how it ended (paper §4.1)."""

from __future__ import annotations

import enum
import logging
from collections.abc import Callable
from dataclasses import dataclass

from skiros_py.execution.pulse import CycleOverrun

__all__ = ["ModuleEvent", "Monitor", "Status"]

_log = logging.getLogger(__name__)


class Status(enum.Enum):
    """State of a module."""

    STARTED = "started"
    """Its first tick comes with this cycle."""
    RUNNING = "running"
    """It reported progress."""
    PREEMPTED = "preempted"
    """It was stopped from outside."""
    TERMINATED = "terminated"
    """It ended well."""
    ERROR = "error"
    """It ended without success; the text says why."""


@dataclass(frozen=True, slots=True)
class ModuleEvent:
    """One message about one module.

    Attributes:
        time: Run time [s].
        kind: "skill" or "primitive".
        module: Its name.
        status: Its state.
        code: Progress code; negative for an error.
        text: Words for a person.
        target: Id of the element that a skill is done to; empty for primitives.
        agent: Id of the subsystem whose skill manager runs it.
        caller: Name of the module that it is part of; empty for a module that was started by itself.
        task: Name of the task that it is done for; empty for none.
        implementation: Label of the way in which a skill is done, may be empty; None for a primitive, and where that
            is not known.
    """

    time: float
    kind: str
    module: str
    status: Status
    code: int
    text: str
    target: str = ""
    agent: str = ""
    caller: str = ""
    task: str = ""
    implementation: str | None = None


class Monitor:
    """Hands module events to whoever listens, in order."""

    def __init__(self) -> None:
        self._listeners: list[Callable[[ModuleEvent], None]] = []

    def subscribe(self, listener: Callable[[ModuleEvent], None]) -> Callable[[], None]:
        """Calls the listener with each event; it must be quick. Returns how to end that."""
        self._listeners.append(listener)
        return lambda: self._listeners.remove(listener)

    def publish(self, event: ModuleEvent) -> None:
        """Hands an event to all listeners."""
        for listener in tuple(self._listeners):
            try:
                listener(event)
            except (KeyboardInterrupt, CycleOverrun):
                raise
            except BaseException:  # noqa: BLE001 - whoever only looks on must not break what is going on
                _log.exception("a listener of module events broke")
