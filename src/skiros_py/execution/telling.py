"""What the monitor hears of a run, and the one way in which runs of primitives and of skills end."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

from skiros_py.execution.monitor import ModuleEvent, Status, end_of
from skiros_py.execution.pulse import CycleOverrun
from skiros_py.execution.scope import Scope
from skiros_py.skills.execution import Execution
from skiros_py.skills.outcome import BROKEN, Outcome

Tell = Callable[[Status, int, str], None]
"""Takes the state of a module, its progress code, and words for a person."""


class ModuleRun(Protocol):
    """One run of a module.

    Attributes:
        started: True when the monitor has heard of it.
    """

    started: bool

    def run(self) -> Execution[Outcome]:
        """Does it."""
        ...

    def leave(self) -> bool:
        """Ends it at once where it is; returns whether it keeps its devices to recover."""
        ...

    def release(self) -> None:
        """Gives its devices back; may be called twice."""
        ...


def teller(
    kind: str,
    name: str,
    scope: Scope,
    run: str,
    target: Callable[[], str] = lambda: "",
    implementation: Callable[[], str | None] = lambda: None,
) -> Tell:
    """Returns how a run in a scope reports to the monitor.

    Args:
        kind: "skill", "primitive" or "document".
        name: The module.
        scope: What it runs in.
        run: Id of the run.
        target: Gives the id of the element that it is done to, as far as that is known.
        implementation: Gives the label of the way in which it is done, as far as that is known.
    """
    caller = scope.callers[-1] if scope.callers else ""

    def tell(status: Status, code: int, text: str) -> None:
        time, way = scope.context.board.snapshot.time, implementation()
        event = ModuleEvent(
            time, kind, name, status, code, text, target(), scope.agent, caller, scope.task, way,
            id=run, parent=scope.id, root=scope.root, path=scope.path,
        )  # fmt: skip
        scope.monitor.publish(event)

    return tell


def to_its_end(module: ModuleRun, scope: Scope, tell: Tell) -> Execution[Outcome]:
    """Runs a module until it ends or is broken off, tells of it, and gives its devices back.

    The end of what stands alone and was broken off is told by whoever started it, when all of it stands.
    """
    kept, nested = False, bool(scope.callers)
    try:
        outcome = yield from module.run()
    except GeneratorExit:
        kept = module.leave()
        if module.started:
            tell(*((Status.PREEMPTED, 0, "broken off") if nested else (Status.RUNNING, 0, "stopping")))
        raise
    except CycleOverrun:
        if nested:
            tell(Status.ERROR, BROKEN, "held the control cycle too long")
        raise
    finally:
        if not kept:
            module.release()
    tell(*end_of(outcome))
    return outcome
