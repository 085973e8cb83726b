"""Pairs of facts that can never hold together.

Finds conflicts that follow from several skills together: a robot that drives only with empty hands cannot hold a part
from one place and stand in another.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations, islice

import numpy as np
from numpy.typing import NDArray

from skiros_py.planning.domain.matching import is_variable, solutions
from skiros_py.planning.domain.model import Action, Atom
from skiros_py.planning.problem.reachability import Relaxation
from skiros_py.planning.problem.task import PlanningTask
from skiros_py.skills.conditions import Condition

_OBJECTS, _FACTS, _STEPS = 120, 600, 4000
"""Maximum number of objects, changing facts and ground actions for this analysis: more would take seconds."""


def exclusive_conditions(task: PlanningTask) -> tuple[Condition, ...]:
    """Returns two conditions of the goal (or one) that never hold together; none if there are none or it is unknown.

    Args:
        task: The task; each of its conditions could hold by itself.
    """
    if len(task.problem.objects) > _OBJECTS:
        return ()
    relaxed = Relaxation(task)
    changing = {atom.predicate for action in task.domain.actions for atom in (*action.add, *action.delete)}
    facts = [atom for atom in relaxed.facts if atom.predicate in changing]
    steps = list(islice(_steps(relaxed, changing), _STEPS + 1))
    if len(facts) > _FACTS or len(steps) > _STEPS or any(set(step.add) - set(facts) for step in steps):
        return ()
    number = {atom: i for i, atom in enumerate(facts)}
    reached = _reachable(task, steps, number)
    wanted = [(condition, number[atom]) for condition, atoms in task.goal for atom in atoms if atom in number]
    pairs = ((one, other) for (one, i), (other, j) in combinations(wanted, 2) if not reached[i, j])
    return tuple(dict.fromkeys(next(pairs, ())))


def _steps(relaxed: Relaxation, changing: set[str]) -> Iterator[Action]:
    """Yields ground actions, each with only those preconditions that can change."""
    seen: set[tuple[tuple[Atom, ...], ...]] = set()
    for action in relaxed.task.domain.actions:
        for binding in solutions(action.pre, relaxed.facts, {}, action.types, relaxed.fits):
            pre = tuple(atom.bind(binding) for atom in action.pre if atom.predicate in changing)
            add, delete = (tuple(atom.bind(binding) for atom in atoms) for atoms in (action.add, action.delete))
            free = any(is_variable(argument) for atom in (*add, *delete) for argument in atom.arguments)
            if free:
                add, delete = _filled(add, relaxed), tuple(a for a in delete if not any(map(is_variable, a.arguments)))
            if (pre, add, delete) not in seen:
                seen.add((pre, add, delete))
                yield Action(action.name, action.skill, (), pre, add, delete)


def _filled(atoms: tuple[Atom, ...], relaxed: Relaxation) -> tuple[Atom, ...]:
    """Binds free variables to all values at once: an over-approximation, so nothing is excluded wrongly."""
    return tuple(fact for atom in atoms for fact in relaxed.facts.candidates(atom))


def _reachable(task: PlanningTask, steps: list[Action], number: dict[Atom, int]) -> NDArray[np.bool_]:
    """Returns which pairs of facts could hold together."""
    reached: NDArray[np.bool_] = np.zeros((len(number), len(number)), dtype=np.bool_)
    start = [number[atom] for atom in task.problem.init if atom in number]
    reached[np.ix_(start, start)] = True
    rows = [tuple([number[a] for a in atoms if a in number] for atoms in (s.pre, s.add, s.delete)) for s in steps]
    size = -1
    while size != (size := int(reached.sum())):
        for pre, add, delete in rows:
            if not reached[np.ix_(pre, pre)].all():
                continue
            beside = np.array(reached[pre].all(axis=0) if pre else reached.diagonal())
            beside[delete] = False
            beside[add] = True
            reached[add] |= beside
            reached[:, add] |= beside[:, None]
    return reached
