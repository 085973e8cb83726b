"""Goals inside a planning task: plain facts stay facts, everything else becomes bookkeeping of the actions.

A goal such as "any starter in compartment a" or "InKit" has a variable or an alternative in it, which a STRIPS goal
cannot say. So there is an action per such part of the goal, applicable once the robots have finished: its precondition
is the part's pattern, its effect a fact stating "this part is reached". Nothing can be undone afterwards, because
skills need "still working". Nested parts have their own facts, so that the task grows linearly with the goal rather
than with its combinations; "for all" is expanded for each existing element.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, partial
from itertools import count

from skiros_py.errors import PlanningError, UsageError
from skiros_py.planning.domain.actions import shown
from skiros_py.planning.domain.literals import NOT, NOTHING, atom_of, is_stored, normal, something
from skiros_py.planning.domain.model import Action, Atom, NoneSuch, Variable
from skiros_py.skills.conditions import AllOf, AnyOf, Condition, Exists, Not, Nothing, Pattern
from skiros_py.skills.references import variables
from skiros_py.world.ontology import Ontology
from skiros_py.world.view import WorldView
from skiros_py.world.vocabulary import ELEMENT


@dataclass(frozen=True, slots=True)
class Emptiness:
    """A precondition's requirement that nothing has a relation to a place of this class."""

    relation: str
    class_: str

    @property
    def predicate(self) -> str:
        """Its predicate."""
        return NOTHING + self.relation


def emptiness_classes(actions: Iterable[Action]) -> dict[str, str]:
    """Returns the class of place that each "nothing …" precondition asks about; after :func:`maintain_emptiness`."""
    return {e.predicate: e.class_ for e in asked_emptiness(actions)}


def maintain_emptiness(actions: Iterable[Action], ontology: Ontology) -> tuple[Action, ...]:
    """Adds what skills do to "nothing is there": filling ends it, taking the only thing restores it.

    This is sound if every action that fills such a place requires it to be empty before, and if it is known of each
    freed place whether it is such a place. Otherwise the precondition becomes a quantified one, which needs a planner
    that supports quantifiers. Things that are there already and stay neither fill nor free a place.
    """
    drafts = tuple(actions)
    for predicate in sorted({e.predicate for e in asked_emptiness(drafts)}):
        asked = [e for e in asked_emptiness(drafts) if e.predicate == predicate]
        kept = [_maintaining(action, asked[0], ontology) for action in drafts]
        if len(asked) == 1 and None not in kept:
            drafts = tuple(filter(None, kept))
        else:
            drafts = tuple(_with_quantifier(action, asked[0], ontology) for action in drafts)
    return drafts


def asked_emptiness(actions: Iterable[Action]) -> tuple[Emptiness, ...]:
    """Returns what the preconditions of actions require to be empty."""
    found = (
        Emptiness(atom.predicate.removeprefix(NOTHING), action.types.get(atom.arguments[0], ""))
        for action in actions
        for atom in action.pre
        if atom.predicate.startswith(NOTHING)
    )
    return tuple(dict.fromkeys(found))


def _maintaining(action: Action, emptiness: Emptiness, ontology: Ontology) -> Action | None:
    """Returns the action with its effects on emptiness; None if it is not known which places it fills or frees."""

    def concerned(atoms: Iterable[Atom], but: Iterable[Atom]) -> list[str]:
        places = [a.arguments[1] for a in atoms if a.predicate == emptiness.relation and a not in but]
        return [place for place in places if ontology.overlap(action.types[place], emptiness.class_)]

    freed = concerned(action.delete, but=action.add)
    starts = tuple(Atom(emptiness.predicate, (place,)) for place in freed)
    ends = tuple(Atom(emptiness.predicate, (place,)) for place in concerned(action.add, but=action.pre))
    if not set(ends) <= set(action.pre) or not all(
        _within(action.types[place], emptiness.class_, ontology) for place in freed
    ):
        return None
    added = [f"effect {shown(atom)}: it held one thing only" for atom in starts]
    ended = [f"effect not {shown(atom)}: something is there now" for atom in ends]
    notes = (*action.notes, *added, *ended)
    return replace(action, add=action.add + starts, delete=action.delete + ends, notes=notes)


def _with_quantifier(action: Action, emptiness: Emptiness, ontology: Ontology) -> Action:
    asked = [atom for atom in action.pre if atom.predicate == emptiness.predicate]
    class_ = ontology.relations[emptiness.relation].domain or ELEMENT
    none = []
    for atom in asked:
        (place,) = atom.arguments
        holder = f"?{place.lstrip('?')} holder #{emptiness.relation}"
        none.append(NoneSuch((Variable(holder, class_),), (Atom(emptiness.relation, (holder, place)),)))
    notes = tuple(f"precondition {shown(atom)} with a quantifier: not every skill keeps track of it" for atom in asked)
    pre = tuple(atom for atom in action.pre if atom not in asked)
    return replace(action, pre=pre, none=(*action.none, *none), notes=(*action.notes, *notes))


def _within(class_: str, other: str, ontology: Ontology) -> bool:
    """Returns whether all things of a class are of another; no class stands for any thing."""
    return not other or (bool(class_) and ontology.is_a(class_, other))


WORKING = Atom("working")
FINISHED = Atom("finished")
REACHED = "reached "

Scope = Mapping[str, str]
"""Class by variable bound by enclosing quantifiers."""


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
        UsageError: A condition cannot be expressed in typed STRIPS.
    """
    parts = [_Part(condition, number, actions, view) for number, condition in enumerate(goal, start=1)]
    atoms = tuple(part.atoms for part in parts)
    bookkeeping = [action for part in parts for action in part.bookkeeping]
    if not bookkeeping:
        return CompiledGoal(tuple(actions), frozenset(), atoms)
    why = "precondition working: all is done before the goal is looked for"
    working = (replace(a, pre=(WORKING, *a.pre), notes=(*a.notes, why)) for a in actions)
    note = "the goal has variables or alternatives: it is looked for once the robots have finished"
    finish = Action("bookkeeping:finish", None, (), (WORKING,), (FINISHED,), (WORKING,), (note,))
    return CompiledGoal((*working, finish, *bookkeeping), frozenset({WORKING}), atoms)


class _Part:
    """One condition of a goal being compiled.

    Attributes:
        atoms: The atoms that stand for it.
        bookkeeping: The actions that achieve those that are not facts of the world.
    """

    def __init__(self, condition: Condition, number: int, actions: Sequence[Action], view: WorldView) -> None:
        self.bookkeeping: list[Action] = []
        self._where = f"goal '{condition}'"
        self._number = number
        self._nodes = count()
        self._fresh = count(1)
        self._tracked = emptiness_classes(actions)
        self._may_relate = cache(partial(_may_relate, actions=actions, ontology=view.ontology))
        self._view = view
        try:
            pattern = normal(condition.closed_pattern(view.ontology), self._where, view.ontology)
        except PlanningError as error:
            raise UsageError(str(error)) from error
        self.atoms = tuple(dict.fromkeys(self._all(pattern, {})))

    def _all(self, pattern: Pattern, scope: Scope) -> Iterator[Atom]:
        """Yields atoms that hold together exactly when the pattern holds."""
        match pattern:
            case AllOf(patterns):
                for part in patterns:
                    yield from self._all(part, scope)
            case AnyOf() | Exists():
                yield self._reached(pattern, scope)
            case Not(Exists() as there):
                yield from (self._reached(pattern, scope),) if scope else self._for_all(there, scope)
            case Nothing(relation, place) if not self._is_tracked(pattern, scope):
                yield from self._all(Not(something(relation, place, self._view.ontology)), scope)
            case _:
                yield from filter(self._is_open, (atom_of(pattern),))

    def _reached(self, pattern: Pattern, scope: Scope) -> Atom:
        """Creates bookkeeping for a pattern that no list of atoms can express; returns the atom it achieves."""
        node = next(self._nodes)
        label = f"{self._number}.{node}" if node else f"{self._number}"
        free = set(variables(pattern))
        own = tuple(Variable(name, class_) for name, class_ in scope.items() if name in free)
        reached = Atom(f"{REACHED}{label}", tuple(variable.name for variable in own))
        for way, (further, atoms) in enumerate(self._ways(pattern, scope), start=1):
            name = f"bookkeeping:reach-goal-{label}" + (f"-{way}" if way > 1 else "")
            note = f"{self._where}: one action for each way in which this part of it can hold"
            pre = tuple(dict.fromkeys((FINISHED, *atoms)))
            self.bookkeeping.append(Action(name, None, own + further, pre, (reached,), (), (note,)))
        return reached

    def _ways(self, pattern: Pattern, scope: Scope) -> Iterator[tuple[tuple[Variable, ...], tuple[Atom, ...]]]:
        """Yields each way in which a pattern can hold: further variables, and what must hold of all."""
        match pattern:
            case AnyOf(patterns):
                for part in patterns:
                    yield from self._ways(part, scope)
            case Exists():
                variable, inner = self._opened(pattern)
                for further, atoms in self._ways(inner, {**scope, variable.name: variable.type}):
                    yield (variable, *further), atoms
            case Not(Exists() as there):
                yield (), tuple(self._for_all(there, scope))
            case _:
                yield (), tuple(self._all(pattern, scope))

    def _for_all(self, there: Exists, scope: Scope) -> Iterator[Atom]:
        """Yields for each element of the class an atom stating that it does not match."""
        variable, inner = self._opened(there)
        contrary = normal(inner, self._where, self._view.ontology, holds=False)
        atoms = tuple(self._all(contrary, {**scope, variable.name: variable.type}))
        for element in self._view.instances(variable.type):
            yield from filter(self._is_open, (atom.bind({variable.name: element}) for atom in atoms))

    def _opened(self, pattern: Exists) -> tuple[Variable, Pattern]:
        """Returns the variable of a quantifier under a unique name, and its inner pattern."""
        name = f"?{pattern.variable} #{next(self._fresh)}"
        return Variable(name, pattern.class_), pattern.pattern.rename({pattern.variable: name})

    def _is_tracked(self, nothing: Nothing, scope: Scope) -> bool:
        """Returns whether skills keep track of whether something is there."""
        class_ = self._tracked.get(atom_of(nothing).predicate)
        of = scope.get(nothing.object) or self._view.element(nothing.object).type
        return class_ is not None and self._view.ontology.is_a(of, class_)

    def _is_open(self, atom: Atom) -> bool:
        """Returns whether an atom may be false at the end: some things are not related, now or by any skill."""
        relation = atom.predicate.removeprefix(NOT)
        if relation == atom.predicate or not is_stored(relation, self._view.ontology):
            return True
        if any(argument.startswith("?") for argument in atom.arguments):
            return True
        classes = tuple(self._view.element(argument).type for argument in atom.arguments)
        return self._view.related(atom.arguments[0], relation, atom.arguments[1]) or self._may_relate(relation, classes)


def _may_relate(relation: str, classes: Sequence[str], actions: Iterable[Action], ontology: Ontology) -> bool:
    """Returns whether a skill could make a relation hold between things of these most specific classes."""

    def fits(class_: str, wanted: str) -> bool:
        return wanted not in ontology.classes or ontology.is_a(class_, wanted)

    added = ((a, atom) for a in actions for atom in a.add if atom.predicate == relation)
    return any(all(map(fits, classes, (a.types[name] for name in atom.arguments))) for a, atom in added)
