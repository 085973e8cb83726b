"""What could be done about a cause: single changes, none of them tried yet."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product

from skiros_py.planning.domain.literals import CAN, HAS, NOTHING, VALUE, compared
from skiros_py.planning.explanation.causes import Found
from skiros_py.planning.explanation.edits import Add, Assign, Move, Relate, Remove, SceneEdit
from skiros_py.planning.explanation.facts import is_variable
from skiros_py.planning.explanation.obstacle import Obstacle
from skiros_py.planning.explanation.wording import listed
from skiros_py.planning.reasons import Cause, CauseKind
from skiros_py.skills.conditions import Condition
from skiros_py.skills.conditions.comparison import Comparison, Constant
from skiros_py.world.element import Placement
from skiros_py.world.names import local_name
from skiros_py.world.terms import Family
from skiros_py.world.view import WorldView
from skiros_py.world.vocabulary import ON

__all__ = ["Remedy", "advice", "remedies"]

_FLOOR = "sk:Floor"
_CHOICES = 3
"""Of how many things or places each is a choice of its own."""


@dataclass(frozen=True, slots=True)
class Remedy:
    """One thing to do.

    Attributes:
        cost: How much of a change it is; the smallest is offered first.
        edits: What it changes in the scene.
        without: Conditions to give up.
    """

    cost: int
    edits: tuple[SceneEdit, ...] = ()
    without: tuple[Condition, ...] = ()


def remedies(found: Found, view: WorldView) -> list[Remedy]:
    """Returns what could be done about a cause, smallest changes first."""
    edits = _edits(found, view)
    given_up = (Remedy(4, without=(condition,)) for condition in found.cause.conditions[:_CHOICES])
    return sorted((*edits, *given_up), key=lambda remedy: remedy.cost)


def advice(cause: Cause) -> str:
    """Returns what somebody has to see to outside of the scene; empty where nothing is known."""
    if cause.kind is CauseKind.NO_SKILL and cause.skill is not None and not cause.precondition:
        return f"give {listed(cause.elements, 'or')} the skill '{cause.skill}', or start a robot that has it"
    if cause.kind is CauseKind.MISSING_ELEMENT:
        return f"see to it that there is a {local_name(cause.elements[0])}"
    if cause.kind is CauseKind.MISSING_FACT and cause.precondition:
        return f"see to it that {cause.precondition}"
    return ""


def _edits(found: Found, view: WorldView) -> Iterator[Remedy]:
    if found.cause.kind is CauseKind.TOO_FEW:
        yield from _more(found.cause, view)
    obstacle = found.obstacle
    if obstacle is None:
        return
    match obstacle.kind:
        case CauseKind.MISSING_ELEMENT:
            yield from (Remedy(2, (Add(obstacle.elements[0], home),)) for home in _homes(obstacle.elements[0], view))
        case CauseKind.MISSING_FACT:
            yield from _stated(obstacle, view)
        case CauseKind.FULL:
            yield from _cleared(obstacle, view)


def _more(cause: Cause, view: WorldView) -> Iterator[Remedy]:
    """Brings as many more as are lacking."""
    classes = [name for name in cause.elements if name in view.ontology.classes]
    there = [name for name in cause.elements if name not in view.ontology.classes]
    lacking = len(cause.conditions) - len(there)
    for class_ in classes:
        for home in _homes(class_, view):
            yield Remedy(2 * lacking, (Add(class_, home),) * lacking)


def _homes(class_: str, view: WorldView) -> list[Placement]:
    """Returns where things of a class are, or else of the next wider one of which some are anywhere."""
    for above in view.ontology.ancestors(class_):
        placed = (view.placement(thing) for thing in view.instances(above))
        there = dict.fromkeys(p for p in placed if p is not None)
        if there:
            return list(there)[:_CHOICES]
    return []


def _cleared(obstacle: Obstacle, view: WorldView) -> Iterator[Remedy]:
    """Takes away what is in the way: to where such things lie, else to the floor, else out of the scene."""
    for thing in obstacle.elements:
        at = view.placement(thing) if view.has(thing) else None
        if at is None or at.place not in obstacle.elements:
            continue
        others = [home for home in _homes(view.element(thing).type, view) if home.place not in obstacle.elements]
        yield from (Remedy(1, (Move(thing, home.relation, home.place),)) for home in others[:1])
        yield from (Remedy(2, (Move(thing, ON, floor),)) for floor in view.instances(_FLOOR)[:1])
        yield Remedy(3, (Remove(thing),))


def _stated(obstacle: Obstacle, view: WorldView) -> Iterator[Remedy]:
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
        yield from _related(atom.predicate, choices[0], choices[1], view)


def _things(argument: str, obstacle: Obstacle, view: WorldView) -> tuple[str, ...]:
    if not is_variable(argument):
        return (argument,)
    class_ = obstacle.types.get(argument, "")
    return view.instances(class_)[:_CHOICES] if class_ in view.ontology.classes else ()


def _valued(property_: str, things: tuple[str, ...], view: WorldView) -> Iterator[Remedy]:
    """Takes the value over from a thing of the same class; nobody invents one."""
    for thing in things:
        like = (other for other in view.instances(view.element(thing).type) if other != thing)
        donors = ((other, view.value(other, property_)) for other in like)
        for other, value in donors:
            if value is not None:
                yield Remedy(1, (Assign(thing, property_, value, other),))
                break


def _value(comparison: Comparison) -> Constant | None:
    """Returns a value that compares as wanted; None where none is as good as any other."""
    value = comparison.value
    tried: list[Constant] = [value]
    if isinstance(value, bool):
        tried.append(not value)
    elif isinstance(value, int | float):
        tried += [value + 1.0, value - 1.0]
    return next((one for one in tried if comparison.allows(one)), None)


def _related(relation: str, subjects: tuple[str, ...], objects: tuple[str, ...], view: WorldView) -> Iterator[Remedy]:
    ontology = view.ontology
    for subject, object_ in product(subjects, objects):
        if ontology.family(relation) in (Family.COMPUTED, Family.STRUCTURE):
            return  # saying so would not make it so
        if ontology.is_placement(relation):
            element, placement = ontology.placed(subject, relation, object_)
            yield Remedy(1, (Move(element, relation, placement.place),))
        else:
            yield Remedy(1, (Relate(subject, relation, object_),))
