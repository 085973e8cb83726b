"""What sequence, fallback and retry share: one run after the other until an outcome of one kind."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from skiros_py.skills.behaviour import Behaviour, Scope
from skiros_py.skills.execution import Execution
from skiros_py.skills.outcome import Outcome, Success


def numbered(children: Iterable[Behaviour]) -> Mapping[str, Behaviour]:
    """Returns children by their number, counted from 0."""
    return {str(number): child for number, child in enumerate(children)}


def in_turn(
    children: Iterable[Behaviour], scope: Scope, *, ends_with: type[Outcome], same: bool = False
) -> Execution[Outcome]:
    """Runs behaviours in turn; each starts in the cycle after the end of the one before.

    Args:
        children: The behaviours.
        scope: Scope of their parent.
        ends_with: The outcome that ends it.
        same: True where all are one child that is tried again.
    """
    outcome: Outcome = Success()
    for number, child in enumerate(children):
        if number:
            yield
        outcome = yield from scope.run(child, "0" if same else str(number))
        if isinstance(outcome, ends_with):
            return outcome
    return outcome
