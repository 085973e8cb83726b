"""Module events: which module started, how far it is, how it ended (paper §4.1)."""

from __future__ import annotations

import enum
from collections.abc import Callable
from dataclasses import dataclass
from itertools import count
from typing import Any

from skiros_py.listeners import Listeners
from skiros_py.skills.outcome import CANCELLED, Outcome, Success


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
    EVENT = "event"
    """It announced a named event, maybe with a value."""


@dataclass(frozen=True, slots=True)
class ModuleEvent:
    """One message about one module.

    Attributes:
        time: Run time [s].
        kind: "skill", "primitive", "document", or "node" for a node in a skill's body.
        module: Its name; of a node, the module that it is part of.
        status: Its state.
        code: Progress code; negative for an error.
        text: Words for a person.
        target: Id of the element that a skill is done to; empty for primitives.
        agent: Id of the subsystem whose skill manager runs it.
        caller: Name of the module that it is part of; empty for a module that was started by itself.
        task: Name of the task that it is done for; empty for none.
        implementation: Label of the way in which a skill is done, may be empty; None for a primitive, and where that
            is not known.
        id: Id of the run that this is about; unique in this process.
        parent: Id of the run that it is part of: a step's for what does a step; empty for one that nothing called.
        root: Id of the outermost of these: the step, or else the module that was started by itself.
        path: Path of its node from the module that was started (``pick/body/0/2``): the same in each run.
        event: Name of the event that it announced; empty for none.
        value: Value of that event, as plain data.
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
    id: str = ""
    parent: str = ""
    root: str = ""
    path: str = ""
    event: str = ""
    value: Any = None

    def as_json(self) -> dict[str, Any]:
        """Returns it as plain data, without time, module and status; the id of its run is "run"."""
        return {"run": self.id, **{name: getattr(self, name) for name in _PLAIN}}


_PLAIN = (
    "kind", "agent", "code", "text", "target", "caller", "task", "implementation", "parent", "root", "path", "event",
    "value",
)  # fmt: skip


class Monitor:
    """Passes module events to listeners, in order, and numbers runs.

    Attributes:
        wants_nodes: True while a listener takes events of nodes; without one they cost nothing.
    """

    def __init__(self) -> None:
        self._listeners = Listeners[[ModuleEvent]]("module events")
        self._of_nodes = Listeners[[ModuleEvent]]("events of nodes")
        self._ids = count(1)
        self.wants_nodes = False

    def new_id(self) -> str:
        """Returns the id of a further run."""
        return f"r{next(self._ids)}"

    def subscribe(self, listener: Callable[[ModuleEvent], None], *, nodes: bool = False) -> Callable[[], None]:
        """Calls the listener with each event; it must be quick. Returns how to end that.

        Args:
            listener: Takes the events.
            nodes: Whether it wants the start and end of nodes in skills' bodies, too.
        """
        ends = [some.add(listener) for some in (self._listeners, *([self._of_nodes] if nodes else []))]
        self.wants_nodes = bool(self._of_nodes)

        def leave() -> None:
            for end in ends:
                end()
            self.wants_nodes = bool(self._of_nodes)

        return leave

    def publish(self, event: ModuleEvent) -> None:
        """Passes an event to all listeners that want it."""
        of_node = event.kind == "node" and event.status is not Status.EVENT
        (self._of_nodes if of_node else self._listeners).notify(event)


def end_of(outcome: Outcome) -> tuple[Status, int, str]:
    """Returns the state, progress code and text by which the end of a run is reported."""
    if isinstance(outcome, Success):
        return Status.TERMINATED, 1, outcome.message
    if outcome.code == CANCELLED:
        return Status.PREEMPTED, 0, outcome.reason
    return Status.ERROR, outcome.code, outcome.reason
