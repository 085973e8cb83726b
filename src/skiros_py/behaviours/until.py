"""Runs a child that its parent may end: by a timeout, a guard, or the skill around it."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import closing

from skiros_py.skills.behaviour import Behaviour, Scope
from skiros_py.skills.conditions.watch import Watch
from skiros_py.skills.execution import Execution
from skiros_py.skills.outcome import Failure, Outcome


def run_until(
    child: Behaviour, key: str, scope: Scope, end: Callable[[Execution[Outcome]], Outcome | None]
) -> Execution[Outcome]:
    """Runs a child until it ends or is ended; then runs the recovery of what was cancelled.

    Args:
        child: The child.
        key: Its key.
        scope: Scope of its parent.
        end: Called in each cycle: ticks the child's run, or ends it; returns its outcome, None while it goes on.
    """
    with scope.apart() as inner, closing(inner.run(child, key)) as run:
        while True:
            outcome = end(run)
            if outcome is not None:
                break
            yield
        run.close()
        yield from inner.recover()
    return outcome


def lost(watch: Watch, what: str) -> Failure | None:
    """Returns the failure where a watched condition holds no longer; its text begins with the words given."""
    broken = watch.broken()
    return None if broken is None else Failure(f"{what} {broken.sentence}")
