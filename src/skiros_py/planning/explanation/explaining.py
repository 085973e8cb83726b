"""Explains why there is no plan: causes, otherwise a conflict, and repairs."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from skiros_py.planning.explanation.causes import find_causes
from skiros_py.planning.explanation.found import Found
from skiros_py.planning.explanation.pairs import exclusive_conditions
from skiros_py.planning.explanation.repairs import Solve, find_repairs
from skiros_py.planning.explanation.wording import listed
from skiros_py.planning.problem.task import PlanningTask
from skiros_py.planning.reasons import Cause, CauseKind, Repair
from skiros_py.skills.conditions import Condition
from skiros_py.world.view import WorldView

Reachable = Callable[[Sequence[Condition]], bool | None]
"""Returns whether conditions can be reached together, None if that is not known."""

_MOST_CALLS = 16
"""Maximum number of planner calls per explanation."""


@dataclass(frozen=True, slots=True)
class Explanation:
    """Why there is no plan, and what would help.

    Attributes:
        causes: Why; empty if nothing was found.
        repairs: Minimal changes that make a plan possible, smallest first.
    """

    causes: tuple[Cause, ...]
    repairs: tuple[Repair, ...] = ()

    @property
    def reasons(self) -> tuple[str, ...]:
        """The causes in the operator's words."""
        return tuple(cause.text for cause in self.causes)


def explain(task: PlanningTask, view: WorldView, solve: Solve | None = None) -> Explanation:
    """Explains why a task has no plan.

    Args:
        task: The complete task: anything left out of it is not explained.
        view: The world it was made from.
        solve: Tries changed worlds and goals; if omitted, no conflict is narrowed down and no repair is offered.
    """
    found = find_causes(task, view)
    if not found:
        goal = exclusive_conditions(task, view.ontology)
        found = (Found(conflict_of(goal)),) if goal else ()
    if not found:
        goal = task.conditions
        if solve is not None and len(goal) > 1:
            goal = smallest_unsolvable(goal, lambda some: solve(view, some))
        found = (Found(conflict_of(goal)),)
    causes = tuple(one.cause for one in found)
    if solve is None:
        return Explanation(causes)
    return Explanation(causes, find_repairs(found, view, task.conditions, task.capabilities, solve))


def smallest_unsolvable(goal: Sequence[Condition], reachable: Reachable) -> tuple[Condition, ...]:
    """Removes conditions as long as the rest remains unreachable: returns a minimal unsolvable subset.

    Only proven unsolvability counts: if the planner cannot tell, the condition stays. In a goal with more conditions
    than planner calls, the last ones stay.
    """
    kept = list(goal)
    for condition in goal[:_MOST_CALLS]:
        rest = [other for other in kept if other is not condition]
        if rest and reachable(rest) is False:
            kept = rest
    return tuple(kept)


def conflict_of(conditions: Sequence[Condition]) -> Cause:
    """Returns the cause that conditions are unreachable together although each is reachable alone."""
    if len(conditions) > 1:
        why, text = "", f"{listed(map(str, conditions))} could each be reached, but not all of them together"
    else:
        why = "whatever is done for it undoes something else that it needs"
        text = f"{conditions[0]} cannot be reached: {why}"
    arguments = dict.fromkeys(argument for condition in conditions for argument in condition.arguments)
    return Cause(CauseKind.CONFLICT, text, tuple(conditions), elements=tuple(arguments), why=why)
