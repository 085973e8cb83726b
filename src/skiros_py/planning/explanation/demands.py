"""Placement demands of a goal, including those in composite conditions: one of some things in one of some places."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import reduce

from skiros_py.planning.domain.literals import NOTHING
from skiros_py.planning.domain.model import Action, Atom
from skiros_py.planning.explanation.facts import Binding, unified
from skiros_py.planning.explanation.relaxation import Relaxation
from skiros_py.skills.conditions import Condition
from skiros_py.world.ontology import Ontology
from skiros_py.world.vocabulary import ELEMENT

_MOST = 2000
"""How many ways to fulfil one condition are considered; with more, the condition is skipped."""


@dataclass(frozen=True, slots=True)
class Demand:
    """A condition requires one of these things in one of these places.

    Attributes:
        condition: The condition.
        relation: The placement relation.
        things: What could be the thing.
        places: Where it could be.
        meant: True if the goal means these specific things: by name, or because it quantifies over all of a class.
    """

    condition: Condition
    relation: str
    things: frozenset[str]
    places: frozenset[str]
    meant: bool = False


@dataclass(frozen=True, slots=True)
class _Want:
    """One of these things is required in one of these places, regardless of the condition."""

    relation: str
    things: frozenset[str]
    places: frozenset[str]

    def or_(self, other: _Want) -> _Want:
        """Returns what is required if either of the two is."""
        return _Want(self.relation, self.things | other.things, self.places | other.places)


def demands_of(relaxed: Relaxation, ontology: Ontology) -> list[Demand]:
    """Returns all placement demands of the goal; conditions with very many alternatives are left out."""
    wants = _Wants(relaxed, ontology)
    return [
        Demand(condition, want.relation, want.things, want.places, want.things.issubset(named))
        for condition, atoms in relaxed.task.goal
        for atom in atoms
        for named in ({*condition.arguments, *atom.arguments},)
        for want in wants.of(atom)
    ]


class _Wants:
    """Traces the goal's bookkeeping actions backwards: which facts must hold, and in which ways they can."""

    def __init__(self, relaxed: Relaxation, ontology: Ontology) -> None:
        self._relaxed = relaxed
        self._ontology = ontology
        self._known: dict[Atom, tuple[_Want, ...]] = {}
        self._closing: dict[str, list[tuple[Action, Atom]]] = {}
        for action in relaxed.task.domain.actions:
            for effect in action.add if action.skill is None else ():
                self._closing.setdefault(effect.predicate, []).append((action, effect))

    def of(self, atom: Atom) -> tuple[_Want, ...]:
        """Returns the demands that all hold, each in some way, whenever a goal fact holds."""
        if atom not in self._known:
            self._known[atom] = self._worked_out(atom)
        return self._known[atom]

    def _worked_out(self, atom: Atom) -> tuple[_Want, ...]:
        if atom.predicate in self._ontology.relations and self._ontology.is_placement(atom.predicate):
            return (self._stated(atom),)
        ways: list[tuple[_Want, ...]] = []
        for action, binding in self._ways(atom):
            if len(ways) == _MOST:
                return ()
            ways.append(tuple(want for pre in action.pre for want in self.of(pre.bind(binding))))
        return _any_of(ways)

    def _ways(self, atom: Atom) -> Iterator[tuple[Action, Binding]]:
        for action, effect in self._closing.get(atom.predicate, ()):
            start = unified(effect, atom, {}, action.types, self._relaxed.fits)
            if start is not None:
                for binding in self._relaxed.ways(action, action.pre, start, {}, _MOST):
                    yield action, binding

    def _stated(self, atom: Atom) -> _Want:
        thing, placement = self._ontology.placed(atom.arguments[0], atom.predicate, atom.arguments[1])
        alike = self._relaxed.alike
        return _Want(atom.predicate, frozenset(alike(thing)), frozenset(alike(placement.place)))


def _any_of(ways: Sequence[Sequence[_Want]]) -> tuple[_Want, ...]:
    """Returns what is required if one of several ways is taken: every choice of one demand per way."""
    if not ways or not all(ways):
        return ()
    count = max(map(len, ways))
    chosen = ([way[min(i, len(way) - 1)] for way in ways] for i in range(count))
    return tuple(dict.fromkeys(_joined(wants) for wants in chosen if len({want.relation for want in wants}) == 1))


def _joined(wants: Iterable[_Want]) -> _Want:
    return reduce(_Want.or_, dict.fromkeys(wants))


def is_exclusive(relaxed: Relaxation, relation: str, place: str, ontology: Ontology) -> bool:
    """Returns whether a place takes only one thing: every skill that puts something there requires it to be empty.

    Things that are there before a skill and stay do not count.
    """
    fillings = [(a, put) for a in relaxed.task.domain.actions if (put := _put(a, relation, place, relaxed))]
    return bool(fillings) and all(
        len(put) == 1 and _asks_for_emptiness(action, put[0], ontology) for action, put in fillings
    )


def _put(action: Action, relation: str, place: str, relaxed: Relaxation) -> list[Atom]:
    """Returns the placements an action may add to a place."""
    new = (atom for atom in action.add if atom.predicate == relation and atom not in action.pre)
    return [atom for atom in new if relaxed.fits(place, action.types.get(atom.arguments[1], ""))]


def _asks_for_emptiness(action: Action, added: Atom, ontology: Ontology) -> bool:
    place = added.arguments[1]
    anything = ontology.relations[added.predicate].domain or ELEMENT
    nones = (
        none.atoms[0] for none in action.none if len(none.atoms) == 1 and [v.type for v in none.variables] == [anything]
    )
    return Atom(NOTHING + added.predicate, (place,)) in action.pre or any(
        atom.predicate == added.predicate and atom.arguments[1] == place for atom in nones
    )
