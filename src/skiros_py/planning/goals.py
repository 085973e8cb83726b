"""Goals inside a planning task: plain facts stay facts, everything else becomes a bookkeeping action at the end.

A goal such as "any starter in compartment a" or "InKit" has a variable in it, which a STRIPS goal cannot say. So there
is one action per such goal that may be taken once the robots have finished: what it needs is the goal's pattern, what
it gives is a fact that says "this goal is reached". Nothing can be undone afterwards, because skills need "still
working".
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from skiros_py.errors import PlanningError, UsageError
from skiros_py.planning.literals import Conjunction, expand
from skiros_py.planning.model import Action, Atom, Variable
from skiros_py.skills.conditions import Condition, Exists, Pattern
from skiros_py.world.ontology import Ontology

__all__ = ["REACHED", "CompiledGoal", "compile_goal"]

WORKING = Atom("working")
FINISHED = Atom("finished")
REACHED = "reached "


@dataclass(frozen=True, slots=True)
class CompiledGoal:
    """Actions with the goal's bookkeeping, facts that hold at the start for it, and the goal as atoms."""

    actions: tuple[Action, ...]
    init: frozenset[Atom]
    atoms: tuple[Atom, ...]


def compile_goal(goal: Sequence[Condition], actions: Sequence[Action], ontology: Ontology) -> CompiledGoal:
    """Compiles a conjunction of conditions over elements and classes.

    Raises:
        UsageError: A condition cannot be said in typed STRIPS.
    """
    atoms: list[Atom] = []
    bookkeeping: list[Action] = []
    for number, condition in enumerate(goal, start=1):
        ways = _ways(condition, ontology)
        if len(ways) == 1 and not ways[0].variables:
            atoms += ways[0].atoms
        else:
            reached = Atom(f"{REACHED}{number}")
            atoms.append(reached)
            bookkeeping += [_reach(number, i, way, reached) for i, way in enumerate(ways, start=1)]
    if not bookkeeping:
        return CompiledGoal(tuple(actions), frozenset(), tuple(atoms))
    working = tuple(replace(action, pre=(WORKING, *action.pre)) for action in actions)
    finish = Action("finish", None, (), (WORKING,), (FINISHED,), (WORKING,))
    return CompiledGoal((*working, finish, *bookkeeping), frozenset({WORKING}), tuple(atoms))


def _ways(condition: Condition, ontology: Ontology) -> tuple[Conjunction, ...]:
    try:
        return expand(_pattern(condition, ontology), f"goal {condition}", ontology)
    except PlanningError as error:
        advice = "that something is not so cannot be planned for; say what should be so instead"
        raise UsageError(f"goal '{condition}': {advice}") from error


def _pattern(condition: Condition, ontology: Ontology) -> Pattern:
    pattern = condition.pattern
    for class_ in dict.fromkeys(a for a in condition.arguments if a in ontology.classes):
        pattern = Exists(class_, class_, pattern)
    return pattern


def _reach(number: int, way: int, conjunction: Conjunction, reached: Atom) -> Action:
    names = {v.name: "?" + v.name for v in conjunction.variables}
    variables = tuple(Variable(names[v.name], v.type) for v in conjunction.variables)
    pre = (FINISHED, *(atom.bind(names) for atom in conjunction.atoms))
    name = f"reach-goal-{number}" if way == 1 else f"reach-goal-{number}-{way}"
    return Action(name, None, variables, pre, (reached,), ())
