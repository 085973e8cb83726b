"""What bringing a condition about does to the world, as data: for planning, for pretending, and for writing.

This is the one place that says which conditions can be brought about, and how.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

from skiros_py.errors import DescriptionError
from skiros_py.skills.conditions.condition import OPPOSITE, Compare, Comparison, Condition, Operator
from skiros_py.skills.conditions.pattern import AllOf, Has, Not, Nothing, NumberChange, Pattern, Related
from skiros_py.world.element import Value
from skiros_py.world.literals import DATATYPES
from skiros_py.world.ontology import Ontology
from skiros_py.world.overlay import Overlay
from skiros_py.world.transaction import Transaction


@dataclass(frozen=True, slots=True)
class Relate:
    """A relation comes to hold; a placement moves what it places."""

    relation: str
    subject: str
    object: str


@dataclass(frozen=True, slots=True)
class Unrelate:
    """A relation holds no longer."""

    relation: str
    subject: str
    object: str


@dataclass(frozen=True, slots=True)
class Assign:
    """A property gets a value of its own; None takes that away.

    Attributes:
        property: CURIE of the property.
        subject: The element.
        value: The value; of a comparison such as "at least 8", its limit, with which plans count.
        op: How the value compares afterwards: where it does already, a sensed value is not overwritten.
    """

    property: str
    subject: str
    value: Value | None
    op: Operator = "="


Effect = Relate | Unrelate | Assign | NumberChange
"""One thing that changes; over a skill's parameters, or over elements once the condition is bound."""


def effects_of(condition: Condition) -> tuple[Effect, ...]:
    """Returns what has to be done that a condition holds; nothing for what merely follows ("nothing is there").

    Raises:
        DescriptionError: It cannot be brought about; the text names it.
    """
    return _effects(condition.pattern, condition)


def brought_about(condition: Condition) -> tuple[Effect, ...]:
    """Returns the effects of a condition; none where it cannot be brought about."""
    try:
        return effects_of(condition)
    except DescriptionError:
        return ()


def _effects(pattern: Pattern, condition: Condition) -> tuple[Effect, ...]:
    match pattern:
        case Related(relation, subject, object_):
            return (Relate(relation, subject, object_),)
        case Not(Related(relation, subject, object_)):
            return (Unrelate(relation, subject, object_),)
        case Compare(property_, "=", subject, value):
            return (Assign(property_, subject, value),)
        case Compare(property_, ("<" | "<=" | ">" | ">=") as op, subject, (int() | float()) as value):
            nearest = value if "=" in op else math.nextafter(value, math.inf if op == ">" else -math.inf)
            return (Assign(property_, subject, nearest, ">=" if ">" in op else "<="),)
        case Not(Compare(property_, ("<" | "<=" | ">" | ">=") as op, subject, value)):
            return _effects(Compare(property_, OPPOSITE[op], subject, value), condition)
        case NumberChange():
            return (pattern,)
        case Compare(property_, "!=", subject, bool(value)) | Not(Compare(property_, "=", subject, bool(value))):
            return (Assign(property_, subject, not value),)
        case Not(Has(property_, subject)):
            return (Assign(property_, subject, None),)
        case Nothing() | Not(Nothing()):
            return ()
        case Not(Not(inner)):
            return _effects(inner, condition)
        case AllOf(patterns):
            return tuple(effect for part in patterns for effect in _effects(part, condition))
        case _:
            raise DescriptionError(
                f"{condition} cannot be brought about: a skill can bring about a relation, the end of one, a value of "
                "a property (= < <= > >=), that it grows or falls, that it has none, or that nothing is there; use "
                "what this condition follows from"
            )


def _fitting(ontology: Ontology, property_: str, value: Value | None, op: Operator) -> Value | None:
    """Returns the limit of a comparison as the property can have it: more than 8 are 9, if it is a whole number."""
    known = ontology.properties.get(property_)
    if known is None or op == "=" or not isinstance(value, float) or DATATYPES[known.range].fits(value):
        return value
    return math.ceil(value) if op == ">=" else math.floor(value)


def suppose_effects(overlay: Overlay, effects: Iterable[Effect]) -> None:
    """Lets effects be so on an overlay.

    Raises:
        UnknownName: An element, relation or property is not there.
    """
    for effect in effects:
        match effect:
            case Relate(relation, subject, object_):
                overlay.set_relation(subject, relation, object_)
            case Unrelate(relation, subject, object_):
                overlay.unset_relation(subject, relation, object_)
            case Assign(property_, subject, value, op):
                overlay.set_value(subject, property_, _fitting(overlay.ontology, property_, value, op))
            case NumberChange(property_, subject, _, object_):
                if (after := effect.after(overlay, subject, object_)) is not None:
                    overlay.set_value(subject, property_, after)


def write_effects(tx: Transaction, ontology: Ontology, effects: Iterable[Effect]) -> None:
    """Writes effects into the world; what is so already stays as it is.

    The end of a placement is left out: everything is somewhere, so it ends by another one.
    """
    for effect in effects:
        match effect:
            case Relate(relation, subject, object_):
                tx.relate(subject, relation, object_)
            case Unrelate(relation, subject, object_):
                known = relation in ontology.relations and tx.view.has(subject) and tx.view.has(object_)
                if not known or (not ontology.is_placement(relation) and tx.view.related(subject, relation, object_)):
                    tx.unrelate(subject, relation, object_)  # which says what is wrong, if anything
            case Assign(property_, subject, int() | float() as value, ">=" | "<=" as op):
                if not Comparison(op, value).allows(tx.view.value(subject, property_)):
                    tx.set(subject, property_, _fitting(ontology, property_, value, op))
            case Assign(property_, subject, value):
                tx.set(subject, property_, value)
            case NumberChange(property_, subject, _, object_):
                if (after := effect.after(tx.view, subject, object_)) is not None:
                    tx.set(subject, property_, after)
