"""Conditions that are reachable individually but exclude each other: one thing in two places, one place for two."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache, reduce
from itertools import combinations, islice
from typing import NamedTuple

from skiros_py.messages import Message, listed
from skiros_py.planning.domain.actions import is_placement
from skiros_py.planning.domain.literals import NOTHING, allows_value, common_class, property_of
from skiros_py.planning.domain.matching import Binding, unified
from skiros_py.planning.domain.model import Action, Atom
from skiros_py.planning.explanation.wording import Found, Shortage, some
from skiros_py.planning.plan import Cause, CauseKind
from skiros_py.planning.problem.reachability import Relaxation
from skiros_py.skills.conditions import Compare, Condition, Not
from skiros_py.world.element import Value
from skiros_py.world.names import local_name
from skiros_py.world.ontology import Ontology
from skiros_py.world.stock import by_stock
from skiros_py.world.vocabulary import ELEMENT

_MOST = 2000
"""How many ways to fulfil one condition are considered; with more, the condition is skipped."""


_Chosen = tuple[object, ...]
"""What the thing of a demand is: an element, or a variable of the goal; for each way to fulfil it, if they differ."""


class _Want(NamedTuple):
    """One of these things is required in one of these places, regardless of the condition."""

    relation: str
    things: frozenset[str]
    places: frozenset[str]
    chosen: _Chosen


@dataclass(frozen=True, slots=True)
class Demand:
    """A condition requires one of these things in one of these places.

    Attributes:
        condition: The condition.
        relation: The placement relation.
        things: What could be the thing.
        places: Where it could be.
        chosen: What the thing is. The demands of "exists b: Ball (In(b, box_a) and In(b, slot_1))" are about one thing,
            those of two variables need not be.
        meant: True if the goal means these specific things: by name, or because it quantifies over all of a class.
    """

    condition: Condition
    relation: str
    things: frozenset[str]
    places: frozenset[str]
    chosen: _Chosen
    meant: bool


def _demands_of(relaxed: Relaxation) -> list[Demand]:
    """Returns all placement demands of the goal; conditions with very many alternatives are left out.

    Traces the goal's bookkeeping actions backwards: which facts must hold, and in which ways they can.
    """
    ontology = relaxed.task.view.ontology
    closing = [(a, e) for a in relaxed.task.domain.actions if a.skill is None for e in a.add]

    @cache
    def wants(atom: Atom) -> tuple[_Want, ...]:
        """Returns what is required, all of it in some way, whenever a goal fact holds."""
        if is_placement(atom, ontology):
            thing, placement = ontology.placed(atom.arguments[0], atom.predicate, atom.arguments[1])
            things, places = (frozenset(relaxed.alike(one)) for one in (thing, placement.place))
            return (_Want(atom.predicate, things, places, (thing,)),)
        each = [tuple(parts(atom, a, b)) for a, b in islice(ways(atom), _MOST + 1)]
        return _any_of(each) if len(each) <= _MOST else ()

    def parts(atom: Atom, action: Action, binding: Binding) -> Iterator[_Want]:
        """Yields what the preconditions of a bookkeeping action require."""
        (reached,) = action.add
        for pre in action.pre:
            free = (a for a in pre.arguments if a in binding and a not in reached.arguments)
            own: dict[object, object] = {binding[a]: (atom, action.name, a) for a in free}
            for want in wants(pre.bind(binding)):
                yield want._replace(chosen=tuple(own.get(one, one) for one in want.chosen))

    def ways(atom: Atom) -> Iterator[tuple[Action, Binding]]:
        for action, effect in closing:
            if effect.predicate == atom.predicate:
                start = unified(effect, atom, {}, action.types, relaxed.fits)
                if start is not None:
                    for binding in relaxed.ways(action, action.pre, start, {}, _MOST):
                        yield action, binding

    return [
        Demand(condition, *want, meant=want.things <= {*condition.arguments, *atom.arguments})
        for condition, atoms in relaxed.task.goal
        for atom in atoms
        for want in wants(atom)
    ]


def _any_of(ways: Sequence[Sequence[_Want]]) -> tuple[_Want, ...]:
    """Returns what is required if one of several ways is taken: every choice of one demand per way."""
    if not ways or not all(ways):
        return ()
    chosen = [[way[min(i, len(way) - 1)] for way in ways] for i in range(max(map(len, ways)))]
    alike = [wants for wants in chosen if len({want.relation for want in wants}) == 1]
    return tuple(dict.fromkeys(map(_either, alike)))


def _either(wants: Sequence[_Want]) -> _Want:
    things = frozenset[str]().union(*(want.things for want in wants))
    places = frozenset[str]().union(*(want.places for want in wants))
    chosen = tuple(one for want in wants for one in want.chosen)
    return _Want(wants[0].relation, things, places, chosen if len(set(chosen)) > 1 else chosen[:1])


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


_FEW = 2
"""How many things or places a cause names at most: with more, they are not the point."""

_MOST_PAIRS = 400
"""How many demands are compared; further ones are ignored."""

_Apart = Callable[[Demand, Demand], bool]


class Contradictions:
    """Finds conditions of a goal that exclude each other."""

    def __init__(self, relaxed: Relaxation) -> None:
        self._relaxed = relaxed
        self._ontology = relaxed.task.view.ontology
        self._demands = _demands_of(relaxed)
        self._exclusive: dict[tuple[str, str], bool] = {}

    def found(self) -> tuple[Found, ...]:
        """Returns each contradiction once; of several about the same conditions, the first."""
        first: dict[frozenset[str], Found] = {}
        for one in self._all():
            first.setdefault(frozenset(map(str, one.cause.conditions)), one)
        smallest = sorted(first, key=len)
        kept = [key for i, key in enumerate(smallest) if not any(other < key for other in smallest[:i])]
        return tuple(one for key, one in first.items() if key in kept)

    def _all(self) -> Iterator[Found]:
        yield from map(Found, self._negations())
        yield from map(Found, self._values())
        yield from map(Found, self._emptiness())
        yield from map(Found, self._two_places())
        yield from self._too_few_things()
        yield from self._too_few_places()

    # ------------------------------------------------------------ comparing conditions

    def _negations(self) -> Iterator[Cause]:
        for one, other in combinations(self._relaxed.task.conditions, 2):
            if one == ~other:
                yield cause_of((one, other), Message("the one says that the other is not so"), one.arguments)

    def _emptiness(self) -> Iterator[Cause]:
        for condition, atom in self._atoms():
            if not atom.predicate.startswith(NOTHING):
                continue
            relation, place = atom.predicate.removeprefix(NOTHING), atom.arguments[0]
            for demand in self._demands:
                if demand.relation == relation and demand.places == {place}:
                    why = Message("{place} cannot be empty and taken at once", place=place)
                    yield cause_of((condition, demand.condition), why, (place, *_only(demand.things)))

    def _values(self) -> Iterator[Cause]:
        about = [(condition, atom) for condition, atom in self._atoms() if self._property(atom) is not None]
        for (one, first), (other, second) in combinations(about, 2):
            same = self._property(first) == self._property(second) and first.arguments == second.arguments
            if same and not self._agree(first, second):
                name = self._ontology.properties[str(self._property(first))].label
                thing = first.arguments[0]
                yield cause_of(
                    (one, other),
                    Message("the {property} of {thing} has one value only", property=name, thing=thing),
                    (thing,),
                )

    def _property(self, atom: Atom) -> str | None:
        literal = self._relaxed.task.asked.get(atom.predicate)
        return None if literal is None else property_of(literal)

    def _agree(self, *atoms: Atom) -> bool:
        """Returns whether some value satisfies all atoms about it."""
        literals = [self._relaxed.task.asked[atom.predicate] for atom in atoms]
        inner = [literal.pattern if isinstance(literal, Not) else literal for literal in literals]
        constants = [literal.value for literal in inner if isinstance(literal, Compare)]
        return any(all(allows_value(literal, v) for literal in literals) for v in _around(constants))

    def _atoms(self) -> list[tuple[Condition, Atom]]:
        return [(condition, atom) for condition, atoms in self._relaxed.task.goal for atom in atoms]

    # ------------------------------------------------------------ things and places

    def _two_places(self) -> Iterator[Cause]:
        wanted: dict[object, list[Demand]] = {}
        for demand in self._demands:
            is_one = len(demand.things) == 1 and not self._classes(demand)
            wanted.setdefault(min(demand.things) if is_one else demand.chosen, []).append(demand)
        for demands in wanted.values():
            for one, other in combinations(demands, 2):
                if one.places.isdisjoint(other.places):
                    thing = self._thing(one)
                    why = Message(
                        "{thing} has one place only, it cannot be {one} and {other}",
                        thing=thing,
                        one=self._place(one),
                        other=self._place(other),
                    )
                    named = *_only(one.things), *_only(one.places | other.places)
                    yield cause_of((one.condition, other.condition), why, named)

    def _place(self, demand: Demand) -> str:
        places = listed(sorted(demand.places), either=True)
        return Message("{relation} {places}", relation=self._ontology.relations[demand.relation].label, places=places)

    def _thing(self, demand: Demand) -> str:
        """Returns the name of the thing that a demand is about, or a name for any."""
        classes = self._classes(demand)
        if len(demand.things) == 1 and not classes:
            return min(demand.things)
        return some(local_name(classes[0])) if classes else Message("a thing")

    def _too_few_things(self) -> Iterator[Found]:
        def are_apart(one: Demand, other: Demand) -> bool:
            return one.places.isdisjoint(other.places) and set(one.chosen).isdisjoint(other.chosen)

        apart = _apart(self._demands, are_apart)
        lacking = _lacking(apart, lambda demand: demand.things)
        things = sorted(frozenset[str]().union(*(demand.things for demand in lacking)))
        if things and any(self._classes(demand) for demand in lacking):
            classes = tuple(dict.fromkeys(c for demand in lacking for c in self._classes(demand)))
            what = listed(map(local_name, classes), either=True) or Message("such thing")
            there = {"count": len(lacking), "kind": what, "things": listed(by_stock(things))}
            text = Message("{count} of {kind} are wanted, but there are only {things}", **there)
            if len(things) == 1:
                text = Message("{count} of {kind} are wanted, but there is only {things}", **there)
            cause = cause_of((d.condition for d in lacking), text, (*classes, *things), CauseKind.TOO_FEW)
            yield Found(cause, shortage=Shortage(len(lacking), tuple(things)))

    def _too_few_places(self) -> Iterator[Found]:
        bounded = [d for d in self._demands if all(self._takes_one(d.relation, place) for place in d.places)]
        for relation in dict.fromkeys(d.relation for d in bounded):
            own = [d for d in bounded if d.relation == relation]
            apart = _apart(own, lambda one, other: one.things.isdisjoint(other.things))
            lacking = _lacking(apart, lambda demand: demand.places)
            if lacking:
                places = sorted(frozenset[str]().union(*(demand.places for demand in lacking)))
                things = [min(demand.things) for demand in lacking if len(demand.things) == 1]
                yield Found(self._full(lacking, places), shortage=Shortage(len(lacking), tuple(places), tuple(things)))

    def _full(self, lacking: Sequence[Demand], places: Sequence[str]) -> Cause:
        """Returns the cause that there are fewer single-thing places than required."""
        conditions = {str(demand.condition) for demand in lacking}
        if len(places) == 1 and len(conditions) > 1 and all(places[0] in d.condition.arguments for d in lacking):
            why = Message("{place} takes one {kind} only", place=places[0], kind=self._kind(lacking))
            return cause_of([d.condition for d in lacking], why, (*places, *_things(lacking)))
        wholes = self._wholes(lacking)
        room = {"count": len(places), "places": listed(places), "wanted": len(lacking)}
        text = Message("there is room for {count} only ({places}), and {wanted} are wanted there", **room)
        if wholes:
            where = listed(wholes)
            text = Message(
                "{where} has room for {count} only ({places}), and {wanted} are wanted there", where=where, **room
            )
        if all(len(demand.things) == 1 for demand in lacking):
            text = Message("{text} ({things})", text=text, things=listed(min(demand.things) for demand in lacking))
        return cause_of((d.condition for d in lacking), text, (*wholes, *places), CauseKind.FULL)

    def _kind(self, demands: Sequence[Demand]) -> str:
        """Returns a common name for all wanted things."""
        objects = self._relaxed.task.problem.objects
        named = [thing for demand in demands for thing in demand.things]
        types = [objects[thing] for thing in named if thing in objects]  # in a trial, it may have been removed
        if not types:
            return "thing"
        class_ = reduce(lambda one, other: common_class(one, other, self._ontology), types)
        return self._ontology.classes[class_].label if class_ in self._ontology.classes else "thing"

    def _takes_one(self, relation: str, place: str) -> bool:
        """Returns whether a place never holds more than one thing; one that holds several now may continue to."""
        key = relation, place
        if key not in self._exclusive:
            init = self._relaxed.task.problem.init
            now = [atom for atom in init if atom.predicate == relation and atom.arguments[1] == place]
            at_object = self._ontology.relations[relation].place_end == "object"
            exclusive = is_exclusive(self._relaxed, relation, place, self._ontology)
            self._exclusive[key] = at_object and len(now) <= 1 and exclusive
        return self._exclusive[key]

    def _classes(self, demand: Demand) -> tuple[str, ...]:
        """Returns the classes of which any thing will do; none if the goal means specific things."""
        if demand.meant:
            return ()
        objects = self._relaxed.task.problem.objects
        types = {objects[thing] for thing in demand.things}
        named = (name for name in demand.condition.names if name in self._ontology.classes)
        return tuple(c for c in named if all(self._ontology.is_a(t, c) for t in types))

    def _wholes(self, demands: Sequence[Demand]) -> tuple[str, ...]:
        """Returns what all conditions name besides things and places: the kit they are about."""
        own = [set(demand.condition.arguments) - demand.things - demand.places for demand in demands]
        common = set.intersection(*own)
        return tuple(sorted(a for a in common if a not in self._ontology.classes))


def _lacking(apart: Sequence[Demand], of: Callable[[Demand], frozenset[str]]) -> list[Demand]:
    """Returns the demands for which there is too little of something, and that want nothing else."""
    few = [apart[i] for i in short([of(demand) for demand in apart])]
    there = frozenset[str]().union(*map(of, few))
    return [demand for demand in apart if few and of(demand) <= there]


def _apart(demands: Sequence[Demand], are_apart: _Apart) -> list[Demand]:
    """Returns demands that each need a resource of their own, since no two could share one."""
    found: list[Demand] = []
    for demand in sorted(demands, key=_narrowest)[:_MOST_PAIRS]:
        if all(are_apart(demand, other) for other in found):
            found.append(demand)
    return found


def _narrowest(demand: Demand) -> tuple[int, str, str]:
    return len(demand.things) * len(demand.places), str(demand.condition), min(demand.things)


def cause_of(
    conditions: Iterable[Condition], why: str, elements: Iterable[str], kind: CauseKind = CauseKind.CONTRADICTION
) -> Cause:
    """Returns the cause why conditions cannot be reached: one alone, or several together."""
    concerned = tuple(dict.fromkeys(conditions))
    names = list(dict.fromkeys(map(str, concerned)))
    said = {"conditions": listed(names), "why": why}
    text = Message("{conditions} cannot be reached: {why}", **said)
    if len(names) > 1 and kind is CauseKind.CONTRADICTION:
        text = Message("{conditions} exclude each other: {why}", **said)
    elif len(names) > 1:
        text = Message("{conditions} cannot be reached together: {why}", **said)
    return Cause(kind, text, concerned, elements=tuple(dict.fromkeys(elements)), why=why)


def _around(constants: Iterable[Value]) -> list[Value | None]:
    """Returns test values that include one satisfying the comparisons with the constants, if one exists."""
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
    """Returns the names if they are few enough to be mentioned."""
    return tuple(sorted(names)) if len(names) <= _FEW else ()


def _things(demands: Sequence[Demand]) -> tuple[str, ...]:
    return tuple(thing for demand in demands for thing in _only(demand.things))


def short(wanted: Sequence[Iterable[str]]) -> tuple[int, ...]:
    """Returns the indices of demands that outnumber the resources they could use; empty if all can be served.

    Args:
        wanted: For each demand the resources of which it needs one.
    """
    options = [sorted(each) for each in wanted]
    taken: dict[str, int] = {}
    for demand in range(len(options)):
        seen: set[int] = set()
        if not _served(demand, options, taken, seen):
            return tuple(sorted(seen))
    return ()


def _served(demand: int, options: Sequence[Sequence[str]], taken: dict[str, int], seen: set[int]) -> bool:
    """Assigns a resource to a demand, reassigning others where necessary."""
    seen.add(demand)
    for resource in options[demand]:
        holder = taken.get(resource)
        if holder is None or (holder not in seen and _served(holder, options, taken, seen)):
            taken[resource] = demand
            return True
    return False
