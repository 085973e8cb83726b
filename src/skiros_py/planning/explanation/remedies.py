"""Possible remedies for a cause: single changes, not yet tested."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations, islice, product

from skiros_py.planning.domain.literals import CAN, HAS, NOT, NOTHING, VALUE, compared
from skiros_py.planning.explanation.edits import Add, Assign, Move, Relate, Remove, SceneEdit
from skiros_py.planning.explanation.elsewhere import exchanges
from skiros_py.planning.explanation.facts import is_variable
from skiros_py.planning.explanation.found import Found, Obstacle, Shortage
from skiros_py.planning.explanation.room import Room
from skiros_py.planning.explanation.wording import listed, some
from skiros_py.planning.reasons import Cause, CauseKind, Exchange
from skiros_py.skills.conditions import Condition
from skiros_py.skills.conditions.compare import Comparison, Constant
from skiros_py.world.names import local_name
from skiros_py.world.terms import Family
from skiros_py.world.view import WorldView
from skiros_py.world.vocabulary import FLOOR, HAS_A, ON

_CHOICES = 3
"""How many things or places are offered as individual choices."""


@dataclass(frozen=True, slots=True)
class Remedy:
    """One possible change.

    Attributes:
        cost: The size of the change; the smallest is offered first.
        edits: Its changes to the scene.
        without: Conditions to give up.
        instead: Conditions to replace.
    """

    cost: int
    edits: tuple[SceneEdit, ...] = ()
    without: tuple[Condition, ...] = ()
    instead: tuple[Exchange, ...] = ()


def remedies(found: Found, goal: Sequence[Condition], view: WorldView, room: Room) -> list[Remedy]:
    """Returns the possible remedies for a cause, smallest changes first."""
    otherwise = (Remedy(1, instead=(exchange,)) for exchange in exchanges(found, goal, view, room))
    return sorted((*otherwise, *_edits(found, view, room), *_given_up(found)), key=lambda remedy: remedy.cost)


def _given_up(found: Found) -> Iterator[Remedy]:
    """Gives up one condition, or as many as exceed the supply."""
    conditions = found.cause.conditions
    yield from (Remedy(4, without=(condition,)) for condition in conditions[:_CHOICES])
    excess = found.shortage.excess if found.shortage is not None else 0
    if 1 < excess < len(conditions):
        yield Remedy(4 * excess, without=conditions[-excess:])


def advice(cause: Cause) -> str:
    """Returns what the user has to arrange outside the scene; empty if unknown."""
    if cause.kind is CauseKind.NO_SKILL and cause.skill is not None and not cause.precondition:
        return f"give {listed(cause.elements, 'or')} the skill '{cause.skill}', or start a robot that has it"
    if cause.kind is CauseKind.MISSING_ELEMENT:
        return f"see to it that there is {some(local_name(cause.elements[0]))}"
    if cause.kind is CauseKind.MISSING_FACT and cause.precondition:
        return f"see to it that {cause.precondition}"
    return ""


def _edits(found: Found, view: WorldView, room: Room) -> Iterator[Remedy]:
    if found.shortage is not None:
        yield from _more(found.cause, found.shortage, view, room)
        yield from _fewer(found.cause, found.shortage, view)
    obstacle = found.obstacle
    if obstacle is None:
        return
    if obstacle.missing is not None and obstacle.missing.predicate.startswith(NOT):
        yield from _taken_out(obstacle, view, room)
        return
    match obstacle.kind:
        case CauseKind.MISSING_ELEMENT:
            homes = room.homes(obstacle.elements[0], view)[:_CHOICES]
            yield from (Remedy(2, (Add(obstacle.elements[0], home),)) for home in homes)
        case CauseKind.MISSING_FACT:
            yield from _stated(obstacle, view, room)
        case CauseKind.FULL:
            yield from _cleared(obstacle, view, room)


def _more(cause: Cause, shortage: Shortage, view: WorldView, room: Room) -> Iterator[Remedy]:
    """Adds as many things as are lacking."""
    for class_ in (name for name in cause.elements if name in view.ontology.classes):
        for home in room.homes(class_, view)[:_CHOICES]:
            if shortage.excess == 1 or not room.keeps_one(home, view):
                yield Remedy(2 * shortage.excess, (Add(class_, home),) * shortage.excess)


def _fewer(cause: Cause, shortage: Shortage, view: WorldView) -> Iterator[Remedy]:
    """Removes things that there is no room for from the scene, except things the goal names or that have parts."""
    named = {name for condition in cause.conditions for name in condition.arguments}
    things = [
        t for t in dict.fromkeys(shortage.things) if t not in named and view.has(t) and not view.objects(t, HAS_A)
    ]
    for chosen in islice(combinations(things, shortage.excess), _CHOICES):
        yield Remedy(3 * shortage.excess, tuple(map(Remove, chosen)))


def _taken_out(obstacle: Obstacle, view: WorldView, room: Room) -> Iterator[Remedy]:
    """Removes a thing from a place where it should not be."""
    atom = obstacle.missing
    relation = atom.predicate.removeprefix(NOT) if atom is not None else ""
    if atom is None or relation not in view.ontology.relations or not view.ontology.is_placement(relation):
        return
    subjects, objects = (_things(argument, obstacle, view) for argument in atom.arguments)
    for subject, object_ in product(subjects, objects):
        if view.related(subject, relation, object_):
            thing, placement = view.ontology.placed(subject, relation, object_)
            yield from _away(thing, (placement.place,), view, room)


def _cleared(obstacle: Obstacle, view: WorldView, room: Room) -> Iterator[Remedy]:
    """Removes what blocks a place."""
    for thing in obstacle.elements:
        at = view.placement(thing) if view.has(thing) else None
        if at is not None and at.place in obstacle.elements:
            yield from _away(thing, obstacle.elements, view, room)


def _away(thing: str, places: Sequence[str], view: WorldView, room: Room) -> Iterator[Remedy]:
    """Moves a thing out of places: to where such things are stored, else to the floor, else out of the scene."""
    homes = room.homes(view.element(thing).type, view, besides=places)
    yield from (Remedy(1, (Move(thing, home.relation, home.place),)) for home in homes[:1])
    if not homes:
        yield from (Remedy(2, (Move(thing, ON, floor),)) for floor in view.instances(FLOOR)[:1])
    yield Remedy(3, (Remove(thing),))


def _stated(obstacle: Obstacle, view: WorldView, room: Room) -> Iterator[Remedy]:
    """Makes the missing fact true."""
    atom = obstacle.missing
    if atom is None or atom.predicate.startswith((CAN, NOTHING)):
        return
    choices = [_things(argument, obstacle, view) for argument in atom.arguments]
    if atom.predicate.startswith(HAS):
        yield from _valued(atom.predicate.removeprefix(HAS), choices[0], view)
    elif atom.predicate.startswith(VALUE):
        property_, comparison = compared(atom.predicate)
        value = _value(comparison)
        if value is not None:
            yield from (Remedy(1, (Assign(thing, property_, value),)) for thing in choices[0])
    elif atom.predicate in view.ontology.relations and len(choices) == 2:
        yield from _related(atom.predicate, choices[0], choices[1], view, room)


def _things(argument: str, obstacle: Obstacle, view: WorldView) -> tuple[str, ...]:
    if not is_variable(argument):
        return (argument,)
    class_ = obstacle.types.get(argument, "")
    return view.instances(class_)[:_CHOICES] if class_ in view.ontology.classes else ()


def _valued(property_: str, things: tuple[str, ...], view: WorldView) -> Iterator[Remedy]:
    """Copies the value from a thing of the same class; values are never invented."""
    for thing in things:
        like = (other for other in view.instances(view.element(thing).type) if other != thing)
        donors = ((other, view.value(other, property_)) for other in like)
        for other, value in donors:
            if value is not None:
                yield Remedy(1, (Assign(thing, property_, value, other),))
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
) -> Iterator[Remedy]:
    ontology = view.ontology
    for subject, object_ in product(subjects, objects):
        if ontology.family(relation) in (Family.COMPUTED, Family.STRUCTURE):
            return  # stating it would not make it true
        if ontology.is_placement(relation):
            element, placement = ontology.placed(subject, relation, object_)
            if room.has_room(placement, view):
                yield Remedy(1, (Move(element, relation, placement.place),))
        else:
            yield Remedy(1, (Relate(subject, relation, object_),))
