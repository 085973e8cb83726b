"""The causes that need no search: what never becomes true, and what in the goal excludes each other."""

from __future__ import annotations

from skiros_py.planning.domain.model import Atom
from skiros_py.planning.explanation.contradictions import Contradictions
from skiros_py.planning.explanation.everyone import with_everyone
from skiros_py.planning.explanation.found import Found
from skiros_py.planning.explanation.obstacle import Obstacle
from skiros_py.planning.explanation.obstacles import Obstacles
from skiros_py.planning.explanation.relaxation import Relaxation, relaxing
from skiros_py.planning.pieces import Work, at_once
from skiros_py.planning.problem.task import PlanningTask
from skiros_py.planning.reasons import Cause, CauseKind
from skiros_py.skills.conditions import Condition
from skiros_py.world.view import WorldView
from skiros_py.world.vocabulary import HAS_A

__all__ = ["certain_causes", "find_causes", "finding_causes"]


def certain_causes(task: PlanningTask, view: WorldView) -> tuple[Cause, ...]:
    """Returns causes each of which proves that there is no plan, without a search; none where nobody knows.

    Args:
        task: The task; one with sequence numbers, or in time, has no plan either where this has none.
        view: The world it was made from, with all of its stock.
    """
    return tuple(found.cause for found in find_causes(task, view))


def find_causes(task: PlanningTask, view: WorldView) -> tuple[Found, ...]:
    """Returns the cause of each condition that can never hold by itself, then those of what excludes each other.

    Each proves by itself that there is no plan. Empty when each condition could hold, and nothing simple keeps them
    from holding together.
    """
    return at_once(finding_causes(task, view))


def finding_causes(task: PlanningTask, view: WorldView) -> Work[tuple[Found, ...]]:
    """Does what :func:`find_causes` does, in pieces."""
    task = with_everyone(task, view)
    yield
    relaxed = yield from relaxing(task, view.ontology)
    obstacles = Obstacles(relaxed, view)
    missing = [(condition, _first(atoms, relaxed)) for condition, atoms in task.goal]
    found: list[Found] = []
    for condition, atom in missing:
        if atom is not None:
            found.append(_unreachable(condition, obstacles.of(atom), view))
            yield
    hopeless = {condition for condition, atom in missing if atom is not None}
    together = Contradictions(relaxed, view.ontology).found()
    return (*found, *(one for one in together if not hopeless.intersection(one.cause.conditions)))


def _first(atoms: tuple[Atom, ...], relaxed: Relaxation) -> Atom | None:
    return next((atom for atom in atoms if atom not in relaxed.facts), None)


def _unreachable(condition: Condition, obstacle: Obstacle, view: WorldView) -> Found:
    full = _full(condition, obstacle, view)
    text = f"{condition} cannot be reached: {''.join(f'{whole} is full: ' for whole in full)}{obstacle.text}"
    parts = obstacle.skill, obstacle.precondition, (*full, *obstacle.elements)
    return Found(Cause(obstacle.kind, text, (condition,), *parts), obstacle)


def _full(condition: Condition, obstacle: Obstacle, view: WorldView) -> tuple[str, ...]:
    """Returns what the condition names that is built of the places that are taken: the kit that is full."""
    if obstacle.kind is not CauseKind.FULL:
        return ()
    named = (argument for argument in condition.arguments if view.has(argument))
    return tuple(whole for whole in named if set(view.objects(whole, HAS_A)).intersection(obstacle.elements))
