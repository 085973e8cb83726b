"""Possible remedies for a cause: single changes, not yet tested, and other places for unreachable placements."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations, islice, product

from skiros_py.messages import Message, all_of, listed
from skiros_py.planning.domain.actions import actions_of
from skiros_py.planning.domain.goals import asked_emptiness
from skiros_py.planning.domain.literals import CAN, HAS, NOT, NOTHING, VALUE, compared
from skiros_py.planning.domain.matching import is_variable
from skiros_py.planning.edits import Add, Assign, Move, Relate, Remove, SceneEdit
from skiros_py.planning.explanation.wording import Found, Reason, Shortage, some
from skiros_py.planning.plan import Cause, CauseKind, Exchange, Repair
from skiros_py.planning.problem.task import Capability
from skiros_py.skills.conditions import Condition
from skiros_py.skills.conditions.condition import Comparison, Constant
from skiros_py.world.element import Placement
from skiros_py.world.names import local_name
from skiros_py.world.ontology import Ontology
from skiros_py.world.terms import Family
from skiros_py.world.view import WorldView
from skiros_py.world.vocabulary import FLOOR, HAS_A, LOCATION, ON, UNKNOWN_LOCATION


class Room:
    """Determines which places skills reserve for a single thing: those they require to be empty.

    Args:
        capabilities: The available skills.
        ontology: Their classes.
    """

    def __init__(self, capabilities: Sequence[Capability], ontology: Ontology) -> None:
        self._ontology = ontology
        actions = (action for c in capabilities for action in actions_of(c.skill, ontology))
        self._kept = frozenset((kept.relation, kept.class_) for kept in asked_emptiness(actions))

    def homes(self, class_: str, view: WorldView, besides: Sequence[str] = ()) -> list[Placement]:
        """Returns where things of a class are stored, or else of the nearest superclass with stored things.

        Single-thing places are returned only if there is no other storage, and only free ones.

        Args:
            class_: CURIE of the class.
            view: The world.
            besides: Places to exclude.
        """
        free: dict[Placement, None] = {}
        for above in view.ontology.ancestors(class_):
            placed = (view.placement(thing) for thing in view.instances(above))
            homes = [p for p in dict.fromkeys(placed) if p is not None and self._is_home(p, view, besides)]
            stored = [home for home in homes if not self.keeps_one(home, view)]
            if stored:
                return stored
            free |= dict.fromkeys(home for home in homes if self.has_room(home, view))
        return list(free)

    def has_room(self, placement: Placement, view: WorldView) -> bool:
        """Returns whether one more thing can be put somewhere."""
        return not (self.keeps_one(placement, view) and view.subjects(placement.relation, placement.place))

    def is_free(self, place: str, view: WorldView) -> bool:
        """Returns whether a place is a single-thing place and empty."""
        relations = {r for r, c in self._kept if self._ontology.is_a(view.element(place).type, c)}
        return bool(relations) and not any(view.subjects(relation, place) for relation in relations)

    def keeps_one(self, placement: Placement, view: WorldView) -> bool:
        """Returns whether skills reserve a place for a single thing."""
        type_ = view.element(placement.place).type
        return any(placement.relation == r and self._ontology.is_a(type_, c) for r, c in self._kept)

    def _is_home(self, placement: Placement, view: WorldView, besides: Sequence[str]) -> bool:
        type_ = view.element(placement.place).type
        nowhere = any(self._ontology.is_a(type_, class_) for class_ in (FLOOR, UNKNOWN_LOCATION))
        return placement.place not in besides and self._ontology.is_a(type_, LOCATION) and not nowhere


_ELSEWHERE_CHOICES = 4
"""How many alternative places are considered per condition."""
_CONDITIONS = 3
"""For how many conditions alternatives are considered."""


def exchanges(found: Found, goal: Sequence[Condition], view: WorldView, room: Room) -> Iterator[Exchange]:
    """Yields conditions with another place instead; whether they are reachable has not been tested yet.

    Args:
        found: Why there is no plan.
        goal: The whole goal; places that it names are not used.
        view: The world.
        room: Tells which places are free.
    """
    named = {name for condition in goal for name in condition.names}
    for condition in found.cause.conditions[:_CONDITIONS]:
        if type(condition) is not Condition or condition.negated:
            continue  # conditions on several things, or on none, do not name one place
        for place in condition.arguments:
            others = (other for other in _instead_of(place, found, view, room) if other not in named)
            for other in list(others)[:_ELSEWHERE_CHOICES]:
                yield Exchange(condition, condition.bind({place: other}))


def _instead_of(place: str, found: Found, view: WorldView, room: Room) -> list[str]:
    """Returns free places that could replace one that is the problem; none if it is not."""
    if not view.has(place):
        return []
    reason = found.reason
    if reason is None:
        is_short = found.shortage is not None and place in found.shortage.there
        return _like(place, view.element(place).type, view, room) if is_short else []
    if reason.skill is None or place not in reason.elements:
        return []
    if reason.kind is CauseKind.NO_SKILL:
        classes = [name for name in reason.elements if name in view.ontology.classes]
        return _like(place, classes[0], view, room) if classes else []
    if reason.kind in (CauseKind.FULL, CauseKind.DOES_NOT_FIT):
        return _like(place, view.element(place).type, view, room)
    return []


def _like(place: str, class_: str, view: WorldView, room: Room) -> list[str]:
    """Returns the free single-thing places of a class, those of the same whole first."""
    wholes = set(view.subjects(HAS_A, place))
    free = [other for other in view.instances(class_) if other != place and room.is_free(other, view)]
    return sorted(free, key=lambda other: wholes.isdisjoint(view.subjects(HAS_A, other)))


_CHOICES = 3
"""How many things or places are offered as individual choices."""


@dataclass(frozen=True, slots=True)
class Change:
    """A change that may be a remedy, or several together.

    Attributes:
        cost: The size of the change; the smallest is offered first.
        edits: Changes to the scene.
        without: Conditions to give up.
        instead: Conditions to replace.
    """

    cost: int = 0
    edits: tuple[SceneEdit, ...] = ()
    without: tuple[Condition, ...] = ()
    instead: tuple[Exchange, ...] = ()

    def and_(self, remedy: Change) -> Change | None:
        """Returns the change with one more remedy.

        None if it adds nothing new, moves a thing again, or changes an already replaced condition.
        """
        edits = tuple(e for e in remedy.edits if isinstance(e, Add) or e not in self.edits)
        without = tuple(c for c in remedy.without if c not in self.without)
        if not (edits or without or remedy.instead) or _placed(edits) & _placed(self.edits):
            return None
        if {exchange.by for exchange in self.instead}.intersection(without, (e.condition for e in remedy.instead)):
            return None
        both = self.edits + edits, self.without + without, self.instead + remedy.instead
        return Change(self.cost + remedy.cost, *both)

    def wanted(self, goal: Sequence[Condition]) -> list[Condition]:
        """Returns the goal after the change."""
        by = {exchange.condition: exchange.by for exchange in self.instead}
        return [by.get(condition, condition) for condition in goal if condition not in self.without]

    def leaving_out(self) -> Iterator[Change]:
        """Yields the changes with one remedy less."""
        for i in range(len(self.edits)):
            yield replace(self, edits=self.edits[:i] + self.edits[i + 1 :])
        for condition in self.without:
            yield replace(self, without=tuple(c for c in self.without if c is not condition))
        for exchange in self.instead:
            yield replace(self, instead=tuple(e for e in self.instead if e is not exchange))

    @property
    def key(self) -> tuple[tuple[str, ...], ...]:
        """A key that is equal for equivalent changes."""
        return tuple(tuple(sorted(map(str, each))) for each in (self.edits, self.without, self.instead))

    @property
    def is_nothing(self) -> bool:
        """Whether it changes nothing."""
        return not (self.edits or self.without or self.instead)

    def includes(self, offer: Repair) -> bool:
        """Returns whether it does everything an offer does; alternative places are considered equivalent."""
        otherwise = {exchange.condition for exchange in offer.instead}
        also = otherwise <= {exchange.condition for exchange in self.instead}
        return also and set(offer.edits) <= set(self.edits) and set(offer.without) <= set(self.without)

    def repair(self) -> Repair:
        """Returns it as a repair to be offered."""
        given_up = [Message("give up {conditions}", conditions=listed(map(str, self.without)))] if self.without else []
        text = all_of([*map(str, self.instead), *map(str, dict.fromkeys(self.edits)), *given_up])
        return Repair(text, self.edits, self.without, self.instead)


def _placed(edits: Sequence[SceneEdit]) -> set[str]:
    """Returns the elements that are placed or removed."""
    return {edit.element for edit in edits if isinstance(edit, Move | Remove)}


def remedies(found: Found, goal: Sequence[Condition], view: WorldView, room: Room) -> list[Change]:
    """Returns the possible remedies for a cause, smallest changes first."""
    otherwise = (Change(1, instead=(exchange,)) for exchange in exchanges(found, goal, view, room))
    return sorted((*otherwise, *_edits(found, view, room), *_given_up(found)), key=lambda remedy: remedy.cost)


def _given_up(found: Found) -> Iterator[Change]:
    """Gives up one condition, or as many as exceed the supply."""
    conditions = found.cause.conditions
    yield from (Change(4, without=(condition,)) for condition in conditions[:_CHOICES])
    excess = found.shortage.excess if found.shortage is not None else 0
    if 1 < excess < len(conditions):
        yield Change(4 * excess, without=conditions[-excess:])


def advice(cause: Cause) -> str:
    """Returns what the user has to arrange outside the scene; empty if unknown."""
    if cause.kind is CauseKind.NO_SKILL and cause.skill is not None and not cause.precondition:
        return Message(
            "give {agents} the skill '{skill}', or start a robot that has it",
            agents=listed(cause.elements, either=True),
            skill=cause.skill,
        )
    if cause.kind is CauseKind.MISSING_ELEMENT:
        return Message("see to it that there is {kind}", kind=some(local_name(cause.elements[0])))
    if cause.kind is CauseKind.MISSING_FACT and cause.precondition:
        return Message("see to it that {precondition}", precondition=cause.precondition)
    return ""


def _edits(found: Found, view: WorldView, room: Room) -> Iterator[Change]:
    if found.shortage is not None:
        yield from _more(found.cause, found.shortage, view, room)
        yield from _fewer(found.cause, found.shortage, view)
    reason = found.reason
    if reason is None:
        return
    if reason.missing is not None and reason.missing.predicate.startswith(NOT):
        yield from _taken_out(reason, view, room)
        return
    match reason.kind:
        case CauseKind.MISSING_ELEMENT:
            homes = room.homes(reason.elements[0], view)[:_CHOICES]
            yield from (Change(2, (Add(reason.elements[0], home),)) for home in homes)
        case CauseKind.MISSING_FACT:
            yield from _stated(reason, view, room)
        case CauseKind.FULL:
            yield from _cleared(reason, view, room)


def _more(cause: Cause, shortage: Shortage, view: WorldView, room: Room) -> Iterator[Change]:
    """Adds as many things as are lacking."""
    for class_ in (name for name in cause.elements if name in view.ontology.classes):
        for home in room.homes(class_, view)[:_CHOICES]:
            if shortage.excess == 1 or not room.keeps_one(home, view):
                yield Change(2 * shortage.excess, (Add(class_, home),) * shortage.excess)


def _fewer(cause: Cause, shortage: Shortage, view: WorldView) -> Iterator[Change]:
    """Removes things that there is no room for from the scene, except things the goal names or that have parts."""
    named = {name for condition in cause.conditions for name in condition.arguments}
    things = [
        t for t in dict.fromkeys(shortage.things) if t not in named and view.has(t) and not view.objects(t, HAS_A)
    ]
    for chosen in islice(combinations(things, shortage.excess), _CHOICES):
        yield Change(3 * shortage.excess, tuple(map(Remove, chosen)))


def _taken_out(reason: Reason, view: WorldView, room: Room) -> Iterator[Change]:
    """Removes a thing from a place where it should not be."""
    atom = reason.missing
    relation = atom.predicate.removeprefix(NOT) if atom is not None else ""
    if atom is None or relation not in view.ontology.relations or not view.ontology.is_placement(relation):
        return
    subjects, objects = (_things(argument, reason, view) for argument in atom.arguments)
    for subject, object_ in product(subjects, objects):
        if view.related(subject, relation, object_):
            thing, placement = view.ontology.placed(subject, relation, object_)
            yield from _away(thing, (placement.place,), view, room)


def _cleared(reason: Reason, view: WorldView, room: Room) -> Iterator[Change]:
    """Removes what blocks a place."""
    for thing in reason.elements:
        at = view.placement(thing) if view.has(thing) else None
        if at is not None and at.place in reason.elements:
            yield from _away(thing, reason.elements, view, room)


def _away(thing: str, places: Sequence[str], view: WorldView, room: Room) -> Iterator[Change]:
    """Moves a thing out of places: to where such things are stored, else to the floor, else out of the scene."""
    homes = room.homes(view.element(thing).type, view, besides=places)
    yield from (Change(1, (Move(thing, home.relation, home.place),)) for home in homes[:1])
    if not homes:
        yield from (Change(2, (Move(thing, ON, floor),)) for floor in view.instances(FLOOR)[:1])
    yield Change(3, (Remove(thing),))


def _stated(reason: Reason, view: WorldView, room: Room) -> Iterator[Change]:
    """Makes the missing fact true."""
    atom = reason.missing
    if atom is None or atom.predicate.startswith((CAN, NOTHING)):
        return
    choices = [_things(argument, reason, view) for argument in atom.arguments]
    if atom.predicate.startswith(HAS):
        yield from _valued(atom.predicate.removeprefix(HAS), choices[0], view)
    elif atom.predicate.startswith(VALUE):
        property_, comparison = compared(atom.predicate)
        value = _value(comparison)
        if value is not None:
            yield from (Change(1, (Assign(thing, property_, value),)) for thing in choices[0])
    elif atom.predicate in view.ontology.relations and len(choices) == 2:
        yield from _related(atom.predicate, choices[0], choices[1], view, room)


def _things(argument: str, reason: Reason, view: WorldView) -> tuple[str, ...]:
    if not is_variable(argument):
        return (argument,)
    class_ = reason.types.get(argument, "")
    return view.instances(class_)[:_CHOICES] if class_ in view.ontology.classes else ()


def _valued(property_: str, things: tuple[str, ...], view: WorldView) -> Iterator[Change]:
    """Copies the value from a thing of the same class; values are never invented."""
    for thing in things:
        like = (other for other in view.instances(view.element(thing).type) if other != thing)
        donors = ((other, view.value(other, property_)) for other in like)
        for other, value in donors:
            if value is not None:
                yield Change(1, (Assign(thing, property_, value, other),))
                break


def _value(comparison: Comparison) -> Constant | None:
    """Returns a value that satisfies the comparison; None if no particular value is preferable."""
    value = comparison.value
    tried: list[Constant] = [value]
    if isinstance(value, bool):
        tried.append(not value)
    elif isinstance(value, int | float):
        tried += [value + 1.0, value - 1.0]
    return next((one for one in tried if comparison.allows(one)), None)


def _related(
    relation: str, subjects: tuple[str, ...], objects: tuple[str, ...], view: WorldView, room: Room
) -> Iterator[Change]:
    ontology = view.ontology
    for subject, object_ in product(subjects, objects):
        if ontology.family(relation) in (Family.COMPUTED, Family.STRUCTURE):
            return  # stating it would not make it true
        if ontology.is_placement(relation):
            element, placement = ontology.placed(subject, relation, object_)
            if room.has_room(placement, view):
                yield Change(1, (Move(element, relation, placement.place),))
        else:
            yield Change(1, (Relate(subject, relation, object_),))
