"""Conditions that could each be reached, but exclude each other: one thing in two places, one place for two.

What of a thing or a place there is only one is known without any search; nothing here depends on the skills' order.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import combinations

from skiros_py.planning.domain.literals import NOTHING, allows_value, property_of
from skiros_py.planning.domain.model import Atom
from skiros_py.planning.explanation.demands import Demand, demands_of, is_exclusive
from skiros_py.planning.explanation.matching import short
from skiros_py.planning.explanation.relaxation import Relaxation
from skiros_py.planning.explanation.wording import listed
from skiros_py.planning.reasons import Cause, CauseKind
from skiros_py.skills.conditions import Compare, Condition, Not
from skiros_py.world.element import Value
from skiros_py.world.names import local_name
from skiros_py.world.ontology import Ontology
from skiros_py.world.stock import by_stock

__all__ = ["Contradictions"]

_FEW = 2
"""Up to so many things or places are named: more are not what it is about."""

_Apart = Callable[[Demand, Demand], bool]


class Contradictions:
    """Finds what in a goal excludes each other."""

    def __init__(self, relaxed: Relaxation, ontology: Ontology) -> None:
        self._relaxed = relaxed
        self._ontology = ontology
        self._demands = demands_of(relaxed, ontology)

    def causes(self) -> tuple[Cause, ...]:
        """Returns each contradiction once; of those about the same conditions, the first."""
        found: dict[frozenset[str], Cause] = {}
        for cause in self._all():
            found.setdefault(frozenset(map(str, cause.conditions)), cause)
        smallest = sorted(found, key=len)
        kept = [key for i, key in enumerate(smallest) if not any(other < key for other in smallest[:i])]
        return tuple(cause for key, cause in found.items() if key in kept)

    def _all(self) -> Iterator[Cause]:
        yield from self._negations()
        yield from self._values()
        yield from self._emptiness()
        yield from self._two_places()
        yield from self._too_few_things()
        yield from self._too_few_places()

    # ------------------------------------------------------------ what one condition says of another

    def _negations(self) -> Iterator[Cause]:
        for one, other in combinations(self._relaxed.task.conditions, 2):
            if one == ~other:
                yield _contradiction((one, other), "the one says that the other is not so", one.arguments)

    def _emptiness(self) -> Iterator[Cause]:
        for condition, atom in self._atoms():
            if not atom.predicate.startswith(NOTHING):
                continue
            relation, place = atom.predicate.removeprefix(NOTHING), atom.arguments[0]
            for demand in self._demands:
                if demand.relation == relation and demand.places == {place}:
                    why = f"{place} cannot be empty and taken at once"
                    yield _contradiction((condition, demand.condition), why, (place, *_only(demand.things)))

    def _values(self) -> Iterator[Cause]:
        about = [(condition, atom) for condition, atom in self._atoms() if self._property(atom) is not None]
        for (one, first), (other, second) in combinations(about, 2):
            same = self._property(first) == self._property(second) and first.arguments == second.arguments
            if same and not self._agree(first, second):
                name = self._ontology.properties[str(self._property(first))].label
                thing = first.arguments[0]
                yield _contradiction((one, other), f"the {name} of {thing} has one value only", (thing,))

    def _property(self, atom: Atom) -> str | None:
        literal = self._relaxed.task.asked.get(atom.predicate)
        return None if literal is None else property_of(literal)

    def _agree(self, *atoms: Atom) -> bool:
        """Tells whether some value is what all atoms about it want."""
        literals = [self._relaxed.task.asked[atom.predicate] for atom in atoms]
        inner = [literal.pattern if isinstance(literal, Not) else literal for literal in literals]
        constants = [literal.value for literal in inner if isinstance(literal, Compare)]
        return any(all(allows_value(literal, v) for literal in literals) for v in _around(constants))

    def _atoms(self) -> list[tuple[Condition, Atom]]:
        return [(condition, atom) for condition, atoms in self._relaxed.task.goal for atom in atoms]

    # ------------------------------------------------------------ things and places

    def _two_places(self) -> Iterator[Cause]:
        for one, other in combinations(self._demands, 2):
            by_name = not self._classes(one) and not self._classes(other)
            if by_name and len(one.things) == 1 and one.things == other.things and not one.places & other.places:
                (thing,) = one.things
                where = [_place(one), _place(other)]
                why = f"{thing} has one place only, it cannot be {where[0]} and {where[1]}"
                yield _contradiction((one.condition, other.condition), why, (thing, *_only(one.places | other.places)))

    def _too_few_things(self) -> Iterator[Cause]:
        apart = _apart(self._demands, lambda one, other: not one.places & other.places)
        lacking = [apart[i] for i in short([demand.things for demand in apart])]
        things = sorted(frozenset[str]().union(*(demand.things for demand in lacking)))
        if things and any(self._classes(demand) for demand in lacking):
            classes = tuple(dict.fromkeys(c for demand in lacking for c in self._classes(demand)))
            what = listed((local_name(c) for c in classes), "or") or "such thing"
            text = f"{len(lacking)} of {what} are wanted, but there {_is(len(things))} only {listed(by_stock(things))}"
            yield _together(CauseKind.TOO_FEW, lacking, text, (*classes, *things))

    def _too_few_places(self) -> Iterator[Cause]:
        bounded = [d for d in self._demands if all(is_exclusive(self._relaxed, d.relation, p) for p in d.places)]
        for relation in dict.fromkeys(d.relation for d in bounded):
            own = [d for d in bounded if d.relation == relation]
            apart = _apart(own, lambda one, other: not one.things & other.things)
            lacking = [apart[i] for i in short([demand.places for demand in apart])]
            places = sorted(frozenset[str]().union(*(demand.places for demand in lacking)))
            if len(places) == 1 and all(places[0] in demand.condition.arguments for demand in lacking):
                why = f"{places[0]} takes one thing only"
                yield _contradiction([d.condition for d in lacking], why, (*places, *_things(lacking)))
            elif lacking:
                wholes = self._wholes(lacking)
                where = f"{listed(wholes)} has" if wholes else "there is"
                text = f"{where} room for {len(places)} only ({listed(places)}), and {len(lacking)} are wanted there"
                yield _together(CauseKind.FULL, lacking, text, (*wholes, *places))

    def _classes(self, demand: Demand) -> tuple[str, ...]:
        return tuple(a for a in demand.condition.arguments if a in self._ontology.classes)

    def _wholes(self, demands: Sequence[Demand]) -> tuple[str, ...]:
        """Returns what all conditions name that is neither thing nor place: the kit that they are about."""
        own = [set(demand.condition.arguments) - demand.things - demand.places for demand in demands]
        common = set.intersection(*own)
        return tuple(sorted(a for a in common if a not in self._ontology.classes))


def _apart(demands: Sequence[Demand], are_apart: _Apart) -> list[Demand]:
    """Returns demands each of which needs one of its own, for no two could be served by the same."""
    found: list[Demand] = []
    for demand in sorted(demands, key=lambda d: (len(d.things) * len(d.places), str(d.condition))):
        if all(are_apart(demand, other) for other in found):
            found.append(demand)
    return found


def _contradiction(conditions: Sequence[Condition], why: str, elements: Iterable[str]) -> Cause:
    text = f"{listed(dict.fromkeys(map(str, conditions)))} exclude each other: {why}"
    return Cause(
        CauseKind.CONTRADICTION, text, tuple(dict.fromkeys(conditions)), elements=tuple(dict.fromkeys(elements))
    )


def _together(kind: CauseKind, demands: Sequence[Demand], why: str, elements: Iterable[str]) -> Cause:
    conditions = tuple(dict.fromkeys(demand.condition for demand in demands))
    text = f"{listed(map(str, conditions))} cannot be reached together: {why}"
    return Cause(kind, text, conditions, elements=tuple(dict.fromkeys(elements)))


def _around(constants: Iterable[Value]) -> list[Value | None]:
    """Returns values among which is one that fulfils comparisons with the constants, if there is any at all."""
    values: list[Value | None] = [None, True, False, ""]
    numbers: list[float] = []
    for constant in constants:
        values.append(constant)
        if isinstance(constant, str):
            values.append(f"other than {constant}")
        elif isinstance(constant, int | float) and not isinstance(constant, bool):
            numbers.append(constant)
    between = [(a + b) / 2.0 for a, b in combinations(numbers, 2)]
    return [*values, *between, *(n + step for n in numbers for step in (-1.0, 1.0))]


def _only(names: frozenset[str]) -> tuple[str, ...]:
    """Returns the names where they are few enough to be what it is about."""
    return tuple(sorted(names)) if len(names) <= _FEW else ()


def _things(demands: Sequence[Demand]) -> tuple[str, ...]:
    return tuple(thing for demand in demands for thing in _only(demand.things))


def _place(demand: Demand) -> str:
    return f"{local_name(demand.relation)} {listed(sorted(demand.places), 'or')}"


def _is(count: int) -> str:
    return "is" if count == 1 else "are"
