"""Numbers as the reason that there is no plan: a charge that does not last."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from math import inf, isfinite

from skiros_py.messages import Message
from skiros_py.planning.domain.model import Atom
from skiros_py.planning.domain.numbers import change_of, farthest, number_compared, numbers_in, numbers_of
from skiros_py.planning.edits import Assign
from skiros_py.planning.plan import Step
from skiros_py.planning.problem.task import PlanningTask
from skiros_py.planning.replay import Flaw, replay
from skiros_py.world.overlay import Overlay


def uncounted(task: PlanningTask) -> PlanningTask:
    """Returns the task as if the numbers that skills raise and lower did not matter; unchanged if there are none."""
    numbers = numbers_of(task.domain.actions)
    if not numbers:
        return task

    def others(atoms: Iterable[Atom]) -> tuple[Atom, ...]:
        compared = ((atom, number_compared(atom.predicate)) for atom in atoms)
        return tuple(atom for atom, number in compared if number is None or number[0] not in numbers)

    actions = tuple(
        replace(action, pre=others(action.pre), add=others(action.add), delete=others(action.delete), changes=())
        for action in task.domain.actions
    )
    problem = replace(task.problem, goal=others(task.problem.goal))
    return replace(task, domain=replace(task.domain, actions=actions), problem=problem)


def shortfall(task: PlanningTask, steps: Sequence[Step]) -> tuple[str, tuple[Assign, ...]]:
    """Explains how a plan made without the numbers fails because of them, however good they are at the start.

    Args:
        task: The task with the numbers.
        steps: The plan.

    Returns:
        The reason, and the numbers with which the plan would not fail, if there are any.
    """
    ends = {
        (change_of(change)[1], end)
        for action in task.domain.actions
        for change in action.changes
        if isfinite(end := farthest(change, action.pre))
    }
    best, given = replay(task.view, steps, task.conditions, task.skills), tuple[Assign, ...]()
    for property_, end in sorted(ends):
        elements = (element for name, element in sorted(numbers_in(task.problem.init)) if name == property_)
        edits = tuple(Assign(element, property_, end) for element in elements)
        supposed = Overlay(task.view)
        for edit in edits:
            supposed.set_value(edit.element, property_, end)
        flaw = replay(supposed, steps, task.conditions, task.skills)
        if _reached(flaw, steps) > _reached(best, steps):
            best, given = flaw, edits
    start = (
        {"property": task.view.ontology.properties[given[0].property].label, "value": given[0].value} if given else {}
    )
    if best is None:
        text = Message("it could be reached, but the skills that change it do not get there")
        return Message(
            "with a {property} of {value:g} at the start {text}", text=text, **start
        ) if start else text, given
    text = Message("{why} at the end", why=best.verdict.why)
    if best.step is not None:
        at = {"number": best.step + 1, "step": steps[best.step]}
        text = Message("{why} at step {number}, {step}", why=best.verdict.why, **at)
    if start:
        text = Message("even with a {property} of {value:g} at the start: {why}", why=text, **start)
    return text, ()


def _reached(flaw: Flaw | None, steps: Sequence[Step]) -> float:
    return inf if flaw is None else len(steps) if flaw.step is None else flaw.step
