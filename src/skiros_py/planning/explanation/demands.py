"""What a goal wants where: for each condition, which things could be the one, and in which places."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from skiros_py.planning.domain.literals import NOTHING
from skiros_py.planning.domain.model import Action, Atom
from skiros_py.planning.explanation.relaxation import Relaxation
from skiros_py.skills.conditions import Condition
from skiros_py.world.ontology import Ontology

__all__ = ["Demand", "Way", "demands_of", "is_exclusive", "ways_of"]

_MOST = 2000
"""How many ways to fulfil one condition are looked at; with more, nothing can be said of it."""


@dataclass(frozen=True, slots=True)
class Way:
    """One way in which a condition of the goal could hold: these atoms at once.

    Attributes:
        condition: The condition.
        atoms: The atoms, perhaps with variables.
        action: The goal's bookkeeping whose preconditions they are; None where the atoms stand in the goal itself.
    """

    condition: Condition
    atoms: tuple[Atom, ...]
    action: Action | None = None


@dataclass(frozen=True, slots=True)
class Demand:
    """A condition wants one of these things in one of these places.

    Attributes:
        condition: The condition.
        relation: The placement relation.
        things: What could be the thing.
        places: Where it could be.
    """

    condition: Condition
    relation: str
    things: frozenset[str]
    places: frozenset[str]


def ways_of(relaxed: Relaxation) -> Iterator[tuple[Way, ...]]:
    """Yields for each condition of the goal the ways in which it could hold."""
    for condition, atoms in relaxed.task.goal:
        closing = [a for a in relaxed.task.domain.actions if a.skill is None and set(a.add) & set(atoms)]
        yield tuple(Way(condition, a.pre, a) for a in closing) or (Way(condition, atoms),)


def demands_of(relaxed: Relaxation, ontology: Ontology) -> list[Demand]:
    """Returns what the goal wants where; conditions that could hold in very many ways are left out."""
    found = (demand for ways in ways_of(relaxed) for demand in _of_condition(ways, relaxed, ontology))
    return [demand for demand in found if demand.things and demand.places]


def _of_condition(ways: Sequence[Way], relaxed: Relaxation, ontology: Ontology) -> list[Demand]:
    """A condition with several ways wants one thing in one place, if each of the ways does."""
    each = [_of_way(way, relaxed, ontology) for way in ways]
    if len(each) == 1:
        return each[0]
    if any(len(demands) != 1 for demands in each) or len({demands[0].relation for demands in each}) != 1:
        return []
    things = frozenset().union(*(demands[0].things for demands in each))
    places = frozenset().union(*(demands[0].places for demands in each))
    return [Demand(ways[0].condition, each[0][0].relation, things, places)]


def _of_way(way: Way, relaxed: Relaxation, ontology: Ontology) -> list[Demand]:
    placing = [a for a in way.atoms if a.predicate in ontology.relations and ontology.is_placement(a.predicate)]
    if not placing:
        return []
    if way.action is None:
        return [_demand(way.condition, atom, ({},), relaxed, ontology) for atom in placing]
    found = relaxed.ways(way.action, way.atoms, {}, {}, _MOST)
    if len(found) == _MOST:
        return []
    return [_demand(way.condition, atom, found, relaxed, ontology) for atom in placing]


def _demand(
    condition: Condition,
    atom: Atom,
    bindings: Iterable[Mapping[str, str]],
    relaxed: Relaxation,
    ontology: Ontology,
) -> Demand:
    placed = [ontology.placed(*_statement(atom.bind(binding))) for binding in bindings]
    things = frozenset(alike for thing, _ in placed for alike in relaxed.alike(thing))
    places = frozenset(alike for _, placement in placed for alike in relaxed.alike(placement.place))
    return Demand(condition, atom.predicate, things, places)


def _statement(atom: Atom) -> tuple[str, str, str]:
    return atom.arguments[0], atom.predicate, atom.arguments[1]


def is_exclusive(relaxed: Relaxation, relation: str, place: str) -> bool:
    """Tells whether a place takes one thing only: every skill that puts something there wants it to be empty."""
    filling = [
        _asks_for_emptiness(action, atom)
        for action in relaxed.task.domain.actions
        for atom in action.add
        if atom.predicate == relation and relaxed.fits(place, action.types.get(atom.arguments[1], ""))
    ]
    return bool(filling) and all(filling)


def _asks_for_emptiness(action: Action, added: Atom) -> bool:
    place = added.arguments[1]
    nones = (atom for none in action.none for atom in none.atoms)
    return Atom(NOTHING + added.predicate, (place,)) in action.pre or any(
        atom.predicate == added.predicate and atom.arguments[1] == place for atom in nones
    )
