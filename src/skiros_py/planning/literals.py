"""Patterns as conjunctions of literals, with the variables that existentials bring along."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import product
from typing import cast

from skiros_py.errors import PlanningError
from skiros_py.planning.classes import IS
from skiros_py.planning.model import Atom, Variable
from skiros_py.skills.conditions import (
    AllOf,
    AnyOf,
    ClassRelated,
    Compare,
    Computed,
    Exists,
    Has,
    IsA,
    Not,
    Nothing,
    Pattern,
    Related,
    Sensor,
)
from skiros_py.skills.conditions.comparison import Comparison, Operator
from skiros_py.world.element import Value
from skiros_py.world.names import local_name
from skiros_py.world.ontology import Ontology

__all__ = [
    "BY_CLASS",
    "CAN",
    "HAS",
    "NOT",
    "NOTHING",
    "VALUE",
    "Asked",
    "Conjunction",
    "allows_value",
    "asked_literals",
    "atom_of",
    "compared",
    "expand",
    "property_of",
]

CAN = "can_"
HAS = "has "
NOTHING = "nothing "
VALUE = "value "
"""Prefix of the predicate that says that a property compares as wanted."""
BY_CLASS = "class "
"""Prefix of the predicate that says that classes are related."""
NOT = "not "
"""Prefix of the predicate that says that something is not so that is evaluated at the start."""

Asked = Has | Compare | IsA | ClassRelated | Computed
"""A literal that is evaluated at the start, or whose negation is; the others are stored."""


@dataclass(frozen=True, slots=True)
class Conjunction:
    """Positive atoms that hold together, over the pattern's variables and these further ones."""

    atoms: tuple[Atom, ...] = ()
    variables: tuple[Variable, ...] = ()


def atom_of(pattern: Related | Nothing | Asked | Not) -> Atom:
    """Returns the atom of a pattern that is one literal; its arguments are the pattern's variables."""
    match pattern:
        case Related(relation, subject, object_) | Computed(relation, subject, object_, _):
            return Atom(relation, (subject, object_))
        case Nothing(relation, object_):
            return Atom(NOTHING + relation, (object_,))
        case Has(property_, subject):
            return Atom(HAS + property_, (subject,))
        case Compare(property_, op, subject, value):
            return Atom(f"{VALUE}{property_} {op} {json.dumps(value, ensure_ascii=False)}", (subject,))
        case IsA(subject, class_):
            return Atom(IS + class_, (subject,))
        case ClassRelated(relation, subject, object_):
            return Atom(BY_CLASS + relation, (subject, object_))
        case Not(Has() | Compare() | IsA() | ClassRelated() | Computed() as inner):
            atom = atom_of(inner)
            return Atom(NOT + atom.predicate, atom.arguments)
        case _:
            raise PlanningError(f"{pattern} is not one literal")


def compared(predicate: str) -> tuple[str, Comparison]:
    """Returns the property, and how it is compared with what, of the predicate of a :class:`Compare`."""
    property_, op, value = predicate.removeprefix(VALUE).split(" ", 2)
    return property_, Comparison(cast(Operator, op), json.loads(value))


def expand(pattern: Pattern, where: str, ontology: Ontology, fresh: Iterator[int]) -> tuple[Conjunction, ...]:
    """Returns the pattern as a disjunction of conjunctions of positive literals.

    Args:
        pattern: Any pattern; existentials become variables.
        where: For the message of a refusal ("precondition X of skill 'y'").
        ontology: Gives the class of what a relation relates.
        fresh: Numbers that keep the variables of different existentials apart.

    Raises:
        PlanningError: It has a part that typed STRIPS cannot say; the message names it.
    """
    match pattern:
        case Related(relation, _, _) if len(ontology.sub_relations(relation)) > 1:
            narrower = ", ".join(r for r in ontology.sub_relations(relation) if r != relation)
            raise PlanningError(f"{where}: {relation} is too general to be planned with; name one of {narrower}")
        case Sensor(device, quantity) | Not(Sensor(device, quantity)):
            advice = "a hold condition or a guard may ask for it, a plan cannot"
            raise PlanningError(f"{where}: the {quantity} of {device} can only be sensed; {advice}")
        case Related() | Nothing() | Has() | Compare() | IsA() | ClassRelated() | Computed():
            return (Conjunction((atom_of(pattern),)),)
        case Not(Has() | Compare() | IsA() | ClassRelated() | Computed()):
            return (Conjunction((atom_of(pattern),)),)
        case Not(Nothing(relation, object_)):
            other = f"{object_} holder #{next(fresh)}"
            class_ = ontology.relations[relation].domain or ""
            return (Conjunction((Atom(relation, (other, object_)),), (Variable(other, class_),)),)
        case Not(Not(inner)):
            return expand(inner, where, ontology, fresh)
        case Not(AllOf(patterns)) if patterns:
            return expand(AnyOf(tuple(Not(p) for p in patterns)), where, ontology, fresh)
        case Not(AnyOf(patterns)):
            return expand(AllOf(tuple(Not(p) for p in patterns)), where, ontology, fresh)
        case AllOf(patterns):
            combinations = product(*(expand(p, where, ontology, fresh) for p in patterns))
            return tuple(_join(combination) for combination in combinations)
        case AnyOf(patterns):
            return tuple(conjunction for p in patterns for conjunction in expand(p, where, ontology, fresh))
        case Exists(variable, class_, inner):
            name = f"{variable} #{next(fresh)}"
            extra = (Variable(name, class_),)
            inner_ways = expand(inner.rename({variable: name}), where, ontology, fresh)
            return tuple(Conjunction(c.atoms, extra + c.variables) for c in inner_ways)
        case _:
            advice = "that something is not so cannot be planned for; say what should be so instead"
            raise PlanningError(f"{where}: {_negated(pattern)}{advice}")


def _negated(pattern: Pattern) -> str:
    match pattern:
        case Not(Related(relation, subject, object_)):
            return f"not {local_name(relation)}({subject}, {object_}): "
        case Not(Exists(_, class_, _)):
            return f"no {local_name(class_)} such that …: "
        case _:
            return ""


def _join(parts: tuple[Conjunction, ...]) -> Conjunction:
    atoms = tuple(atom for part in parts for atom in part.atoms)
    variables = tuple(variable for part in parts for variable in part.variables)
    return Conjunction(tuple(dict.fromkeys(atoms)), tuple(dict.fromkeys(variables)))


def asked_literals(patterns: Iterable[Pattern]) -> dict[str, Asked | Not]:
    """Returns the literals of patterns that are evaluated at the start, by predicate, over variables "1" and "2"."""
    found = (literal for pattern in patterns for literal in _asked(pattern, holds=True))
    return {atom_of(literal).predicate: literal for literal in found}


def _asked(pattern: Pattern, *, holds: bool) -> Iterator[Asked | Not]:
    match pattern:
        case Has() | Compare() | IsA():
            own: Asked = pattern.rename({pattern.subject: "1"})
            yield own if holds else Not(own)
        case ClassRelated(relation):
            yield ClassRelated(relation, "1", "2") if holds else Not(ClassRelated(relation, "1", "2"))
        case Computed(relation, _, _, function):
            yield Computed(relation, "1", "2", function) if holds else Not(Computed(relation, "1", "2", function))
        case AllOf(patterns) | AnyOf(patterns):
            for part in patterns:
                yield from _asked(part, holds=holds)
        case Not(inner):
            yield from _asked(inner, holds=not holds)
        case Exists(_, _, inner):
            yield from _asked(inner, holds=holds)
        case _:
            pass


def property_of(literal: Asked | Not) -> str | None:
    """Returns the property that a literal is about, or None where skills cannot change what it is about."""
    match literal:
        case Has(property_) | Compare(property_) | Not(Has(property_) | Compare(property_)):
            return property_
        case _:
            return None


def allows_value(literal: Asked | Not, value: Value | None) -> bool:
    """Tells whether a literal about a property holds of whatever has this value of it, or none."""
    match literal:
        case Has():
            return value is not None
        case Compare():
            return literal.allows(value)
        case Not(Has() | Compare() as inner):
            return not allows_value(inner, value)
        case _:
            raise PlanningError(f"{literal} is about no property")
