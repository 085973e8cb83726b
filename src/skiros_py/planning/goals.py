"""Goals inside a planning task: plain facts stay facts, everything else becomes a bookkeeping action at the end.

A goal such as "any starter in compartment a" or "InKit" has a variable in it, which a STRIPS goal cannot say. So there
is one action per such goal that may be taken once the robots have finished: what it needs is the goal's pattern, what
it gives is a fact that says "this goal is reached". Nothing can be undone afterwards, because skills need "still
working".
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import count

from skiros_py.errors import PlanningError, UsageError
from skiros_py.planning.actions import emptiness_classes
from skiros_py.planning.literals import NOTHING, Conjunction, expand
from skiros_py.planning.model import Action, Atom, Variable
from skiros_py.skills.conditions import Condition
from skiros_py.world.ontology import Ontology
from skiros_py.world.view import WorldView

__all__ = ["REACHED", "CompiledGoal", "compile_goal"]

WORKING = Atom("working")
FINISHED = Atom("finished")
REACHED = "reached "


@dataclass(frozen=True, slots=True)
class CompiledGoal:
    """A goal as part of a task.

    Attributes:
        actions: The skills' actions and the goal's bookkeeping.
        init: Facts that hold at the start for the bookkeeping.
        atoms: The atoms that stand for each condition, in the order of the goal.
    """

    actions: tuple[Action, ...]
    init: frozenset[Atom]
    atoms: tuple[tuple[Atom, ...], ...]


def compile_goal(goal: Sequence[Condition], actions: Sequence[Action], view: WorldView) -> CompiledGoal:
    """Compiles a conjunction of conditions over elements and classes.

    Raises:
        UsageError: A condition cannot be said in typed STRIPS.
    """
    atoms: list[tuple[Atom, ...]] = []
    bookkeeping: list[Action] = []
    for number, condition in enumerate(goal, start=1):
        ways = _ways(condition, view.ontology)
        _check_emptiness(condition, ways, actions, view)
        if len(ways) == 1 and not ways[0].variables:
            atoms.append(ways[0].atoms)
        else:
            reached = Atom(f"{REACHED}{number}")
            atoms.append((reached,))
            bookkeeping += [_reach(number, i, way, reached) for i, way in enumerate(ways, start=1)]
    if not bookkeeping:
        return CompiledGoal(tuple(actions), frozenset(), tuple(atoms))
    working = tuple(replace(action, pre=(WORKING, *action.pre)) for action in actions)
    finish = Action("bookkeeping:finish", None, (), (WORKING,), (FINISHED,), (WORKING,))
    return CompiledGoal((*working, finish, *bookkeeping), frozenset({WORKING}), tuple(atoms))


def _ways(condition: Condition, ontology: Ontology) -> tuple[Conjunction, ...]:
    try:
        return expand(condition.closed_pattern(ontology), f"goal '{condition}'", ontology, count(1))
    except PlanningError as error:
        raise UsageError(str(error)) from error


def _check_emptiness(
    condition: Condition, ways: Sequence[Conjunction], actions: Sequence[Action], view: WorldView
) -> None:
    """Refuses "nothing is there" for places of which no skill keeps track whether something is there."""
    tracked = emptiness_classes(actions)
    for atom in (atom for way in ways for atom in way.atoms if atom.predicate.startswith(NOTHING)):
        place = atom.arguments[0]
        class_ = tracked.get(atom.predicate)
        if class_ is None or (view.has(place) and not view.ontology.is_a(view.element(place).type, class_)):
            known = f"; it can be for a {class_.partition(':')[2]}" if class_ else ""
            raise UsageError(f"goal '{condition}': that nothing is there cannot be planned for{known}")


def _reach(number: int, way: int, conjunction: Conjunction, reached: Atom) -> Action:
    names = {v.name: "?" + v.name for v in conjunction.variables}
    variables = tuple(Variable(names[v.name], v.type) for v in conjunction.variables)
    pre = (FINISHED, *(atom.bind(names) for atom in conjunction.atoms))
    name = f"bookkeeping:reach-goal-{number}" if way == 1 else f"bookkeeping:reach-goal-{number}-{way}"
    return Action(name, None, variables, pre, (reached,), ())
