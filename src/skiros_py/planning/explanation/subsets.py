"""Which conditions of a goal cannot be reached together: a minimal unsolvable subset, by a bounded number of plans."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from skiros_py.planning.explanation.wording import listed
from skiros_py.planning.pieces import Work
from skiros_py.planning.reasons import Cause, CauseKind
from skiros_py.skills.conditions import Condition

__all__ = ["conflict_of", "smallest_unsolvable"]

Reachable = Callable[[Sequence[Condition]], Work[bool | None]]
"""Tells whether conditions can be reached together, None when nobody knows; yields while it looks for a plan."""

_MOST_CALLS = 16
"""So often a planner is asked for one explanation."""


def smallest_unsolvable(goal: Sequence[Condition], reachable: Reachable) -> Work[tuple[Condition, ...]]:
    """Leaves conditions out for as long as the rest still cannot be reached; yields after each call of the planner.

    What is known to be unsolvable only counts: where the planner does not know, the condition stays. In a goal of more
    conditions than calls, the last ones stay.
    """
    kept = list(goal)
    for condition in goal[:_MOST_CALLS]:
        rest = [other for other in kept if other is not condition]
        if rest and (yield from reachable(rest)) is False:
            kept = rest
        yield
    return tuple(kept)


def conflict_of(conditions: Sequence[Condition]) -> Cause:
    """Returns the cause that conditions cannot be reached together although nothing is lacking for each."""
    if len(conditions) > 1:
        why, text = "", f"{listed(map(str, conditions))} could each be reached, but not all of them together"
    else:
        why = "whatever is done for it undoes something else that it needs"
        text = f"{conditions[0]} cannot be reached: {why}"
    arguments = dict.fromkeys(argument for condition in conditions for argument in condition.arguments)
    return Cause(CauseKind.CONFLICT, text, tuple(conditions), elements=tuple(arguments), why=why)
