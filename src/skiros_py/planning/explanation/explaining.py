"""Explaining as one call: causes, a conflict where there is none, repairs."""

from __future__ import annotations

from skiros_py.planning.explanation.causes import finding_causes
from skiros_py.planning.explanation.explanation import Explanation
from skiros_py.planning.explanation.found import Found
from skiros_py.planning.explanation.pairs import exclusive_conditions
from skiros_py.planning.explanation.repairs import Solve, find_repairs
from skiros_py.planning.explanation.subsets import conflict_of, smallest_unsolvable
from skiros_py.planning.pieces import Work, at_once
from skiros_py.planning.problem.task import PlanningTask
from skiros_py.world.view import WorldView

__all__ = ["explain", "explaining"]


def explaining(task: PlanningTask, view: WorldView, solve: Solve | None = None) -> Work[Explanation]:
    """Explains why a task has no plan; yields after each piece of work, so that others can go on in between.

    Args:
        task: The task, complete: what was left out of it is not explained.
        view: The world it was made from.
        solve: Tries changed worlds and goals; left out, no conflict is narrowed down and no repair offered.
    """
    found = yield from finding_causes(task, view)
    if not found:
        yield
        goal = exclusive_conditions(task, view.ontology)
        found = (Found(conflict_of(goal)),) if goal else ()
    if not found:
        goal = task.conditions
        if solve is not None and len(goal) > 1:
            yield
            goal = yield from smallest_unsolvable(goal, lambda some: solve(view, some))
        found = (Found(conflict_of(goal)),)
    causes = tuple(one.cause for one in found)
    if solve is None:
        return Explanation(causes)
    repairs = yield from find_repairs(found, view, task.conditions, task.capabilities, solve)
    return Explanation(causes, repairs)


def explain(task: PlanningTask, view: WorldView, solve: Solve | None = None) -> Explanation:
    """Explains at once; see :func:`explaining`."""
    return at_once(explaining(task, view, solve))
