"""What a goal wants where: one of these things in one of these places, down into composite conditions."""

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
"""How many ways to fulfil one condition are looked at; with more, nothing can be said of it."""


@dataclass(frozen=True, slots=True)
class Demand:
    """A condition wants one of these things in one of these places.

    Attributes:
        condition: The condition.
        relation: The placement relation.
        things: What could be the thing.
        places: Where it could be.
        meant: True if the goal means these very things: by name, or because it says so of all of a class.
    """

    condition: Condition
    relation: str
    things: frozenset[str]
    places: frozenset[str]
    meant: bool = False


@dataclass(frozen=True, slots=True)
class _Want:
    """One of these things is wanted in one of these places, whoever wants it."""

    relation: str
    things: frozenset[str]
    places: frozenset[str]

    def or_(self, other: _Want) -> _Want:
        """Returns what is wanted where either of both is."""
        return _Want(self.relation, self.things | other.things, self.places | other.places)


def demands_of(relaxed: Relaxation, ontology: Ontology) -> list[Demand]:
    """Returns what the goal wants where, all of it; what could be in very many ways is left out."""
    wants = _Wants(relaxed, ontology)
    return [
        Demand(condition, want.relation, want.things, want.places, want.things.issubset(named))
        for condition, atoms in relaxed.task.goal
        for atom in atoms
        for named in ({*condition.arguments, *atom.arguments},)
        for want in wants.of(atom)
    ]


class _Wants:
    """Reads the goal's bookkeeping backwards: what must hold of it, and in which ways it can."""

    def __init__(self, relaxed: Relaxation, ontology: Ontology) -> None:
        self._relaxed = relaxed
        self._ontology = ontology
        self._known: dict[Atom, tuple[_Want, ...]] = {}
        self._closing: dict[str, list[tuple[Action, Atom]]] = {}
        for action in relaxed.task.domain.actions:
            for effect in action.add if action.skill is None else ():
                self._closing.setdefault(effect.predicate, []).append((action, effect))

    def of(self, atom: Atom) -> tuple[_Want, ...]:
        """Returns what holds in some way, each of it, wherever a fact of the goal does."""
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
    """Returns what is wanted where one of several ways is taken: of each way one want, in any choice that is made."""
    if not ways or not all(ways):
        return ()
    count = max(map(len, ways))
    chosen = ([way[min(i, len(way) - 1)] for way in ways] for i in range(count))
    return tuple(dict.fromkeys(_joined(wants) for wants in chosen if len({want.relation for want in wants}) == 1))


def _joined(wants: Iterable[_Want]) -> _Want:
    return reduce(_Want.or_, dict.fromkeys(wants))


def is_exclusive(relaxed: Relaxation, relation: str, place: str, ontology: Ontology) -> bool:
    """Returns whether a place takes one thing only: every skill that puts something there wants it to be empty.

    What is there before a skill, and stays, fills nothing.
    """
    fillings = [(a, put) for a in relaxed.task.domain.actions if (put := _put(a, relation, place, relaxed))]
    return bool(fillings) and all(
        len(put) == 1 and _asks_for_emptiness(action, put[0], ontology) for action, put in fillings
    )


def _put(action: Action, relation: str, place: str, relaxed: Relaxation) -> list[Atom]:
    """Returns what an action may newly put into a place."""
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
