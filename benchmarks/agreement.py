"""Compares reduced and complete problems: whether one has a plan exactly if the other has."""

from __future__ import annotations

from random_tasks import RandomTask

from skiros_py.planning.domain.pddl import write_pddl
from skiros_py.planning.domain.sequencing import in_sequence
from skiros_py.planning.plan import Step
from skiros_py.planning.plan_validation import read_plan
from skiros_py.planning.planners.planner import Planner, Unsolvable
from skiros_py.planning.problem.stock import with_stock
from skiros_py.planning.problem.task import PlanningTask, build_task
from skiros_py.planning.replay import replay
from skiros_py.planning.sequence import counts


def disagreement(task: RandomTask, planner: Planner, width: int = 2) -> str:
    """Plans with everything, with what is relevant, and with a few candidates, and replays each plan.

    Args:
        task: The world, and what is wanted.
        planner: A planner that proves it where there is no plan.
        width: How few candidates.

    Returns:
        What differs, in words, or "" where all is as it should be. That the few candidates are not enough is no
        difference: then more are tried.
    """
    view = with_stock(task.world, task.goal, whole=True)
    whole = build_task(view, task.capabilities, task.goal, whole=True)
    relevant = build_task(view, task.capabilities, task.goal)
    few = build_task(view, task.capabilities, task.goal, width=width)
    each = {"whole": whole, "relevant": relevant, "few": few}
    plans = {name: _plan(in_sequence(one), planner) for name, one in each.items()}
    skills = {c.skill.name: c.skill for c in task.capabilities}
    for name, plan in plans.items():
        flaw = replay(view, plan, task.goal, skills) if plan is not None else None
        if flaw is not None:
            return f"the plan of the {name} problem breaks: {flaw}"
    if (plans["whole"] is None) != (plans["relevant"] is None) or (plans["whole"] is None and plans["few"] is not None):
        found = ", ".join(name for name, plan in plans.items() if plan is not None)
        return f"only these have a plan: {found}; goal {', '.join(map(str, task.goal))}"
    if plans["whole"] is None and counts(view):
        free = _plan(whole, planner)
        if free is not None and replay(view, free, task.goal, skills) is None:
            return f"a plan keeps to the numbers, but none was found with them; goal {', '.join(map(str, task.goal))}"
    return ""


def _plan(task: PlanningTask, planner: Planner) -> tuple[Step, ...] | None:
    texts = write_pddl(task.domain, task.problem, name="random")
    answer = planner.solve(texts.domain, texts.problem).result()
    if isinstance(answer, Unsolvable):
        return None
    return read_plan(task, texts, answer)
