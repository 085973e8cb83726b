"""Patterns as conjunctions of literals, with the variables that quantifiers bring along."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import product
from typing import cast

from skiros_py.errors import PlanningError
from skiros_py.planning.domain.classes import IS
from skiros_py.planning.domain.model import Atom, NoneSuch, Variable
from skiros_py.planning.domain.normal import is_stored, normal
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
)
from skiros_py.skills.conditions.compare import Comparison, Operator
from skiros_py.world.element import Value
from skiros_py.world.names import local_name
from skiros_py.world.ontology import Ontology

CAN = "can_"
HAS = "has "
NOTHING = "nothing "
VALUE = "value "
"""Prefix of the predicate stating that a property satisfies a comparison."""
BY_CLASS = "class "
"""Prefix of the predicate stating that classes are related."""
NOT = "not "
"""Prefix of the predicate stating a negation."""

Asked = Has | Compare | IsA | ClassRelated | Computed
"""A literal that is evaluated at the start, or whose negation is; the others are stored."""


@dataclass(frozen=True, slots=True)
class Conjunction:
    """Atoms that hold together, over the pattern's variables and further ones, and things that must not exist."""

    atoms: tuple[Atom, ...] = ()
    variables: tuple[Variable, ...] = ()
    none: tuple[NoneSuch, ...] = ()


def atom_of(pattern: Pattern) -> Atom:
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
        case Not(Related() | Has() | Compare() | IsA() | ClassRelated() | Computed() as inner):
            return negated(atom_of(inner))
        case _:
            raise PlanningError(f"{pattern} is not one literal")


def negated(atom: Atom) -> Atom:
    """Returns the negation of an atom."""
    return Atom(NOT + atom.predicate, atom.arguments)


def compared(predicate: str) -> tuple[str, Comparison]:
    """Returns the property, and how it is compared with what, of the predicate of a :class:`Compare`."""
    property_, op, value = predicate.removeprefix(VALUE).split(" ", 2)
    return property_, Comparison(cast(Operator, op), json.loads(value))


def expand(pattern: Pattern, where: str, ontology: Ontology, fresh: Iterator[int]) -> tuple[Conjunction, ...]:
    """Returns the pattern as a disjunction of conjunctions of literals.

    Args:
        pattern: Any pattern; existentials become variables.
        where: For the message of a refusal ("precondition X of skill 'y'").
        ontology: Gives the class of what a relation relates, and which relations are narrower than others.
        fresh: Numbers that make the variables of different existentials unique.

    Raises:
        PlanningError: A part of it cannot be expressed in a precondition; the message names it.
    """
    return _expand(normal(pattern, where, ontology), where, fresh)


def _expand(pattern: Pattern, where: str, fresh: Iterator[int]) -> tuple[Conjunction, ...]:
    match pattern:
        case AllOf(patterns):
            combinations = product(*(_expand(p, where, fresh) for p in patterns))
            return tuple(_join(combination) for combination in combinations)
        case AnyOf(patterns):
            return tuple(conjunction for p in patterns for conjunction in _expand(p, where, fresh))
        case Exists():
            name = f"{pattern.variable} #{next(fresh)}"
            ways = _expand(pattern.pattern.rename({pattern.variable: name}), where, fresh)
            variable = Variable(name, pattern.class_)
            return tuple(Conjunction(c.atoms, (variable, *c.variables), c.none) for c in ways)
        case Not(Exists() as there):
            return (Conjunction(none=_none_such(there, where, fresh)),)
        case _:
            return (Conjunction((atom_of(pattern),)),)


def _none_such(pattern: Exists, where: str, fresh: Iterator[int]) -> tuple[NoneSuch, ...]:
    """Negates an existential: none of its alternatives may exist."""
    ways = _expand(pattern, where, fresh)
    if any(way.none for way in ways):
        class_ = local_name(pattern.class_)
        raise PlanningError(f"{where}: 'no {class_} of which there is no …' cannot be planned with; say what should be")
    return tuple(NoneSuch(way.variables, way.atoms) for way in ways)


def _join(parts: tuple[Conjunction, ...]) -> Conjunction:
    atoms = tuple(atom for part in parts for atom in part.atoms)
    variables = tuple(variable for part in parts for variable in part.variables)
    none = tuple(none for part in parts for none in part.none)
    return Conjunction(tuple(dict.fromkeys(atoms)), tuple(dict.fromkeys(variables)), tuple(dict.fromkeys(none)))


def asked_literals(patterns: Iterable[Pattern], ontology: Ontology) -> dict[str, Asked | Not]:
    """Returns the literals of patterns that are evaluated at the start, by predicate, over variables "1" and "2"."""
    found = (literal for pattern in patterns for literal in _asked(pattern, ontology, holds=True))
    return {atom_of(literal).predicate: literal for literal in found}


def _asked(pattern: Pattern, ontology: Ontology, *, holds: bool) -> Iterator[Asked | Not]:
    match pattern:
        case Has() | Compare() | IsA():
            own: Asked = pattern.rename({pattern.subject: "1"})
            yield own if holds else Not(own)
        case ClassRelated(relation):
            yield ClassRelated(relation, "1", "2") if holds else Not(ClassRelated(relation, "1", "2"))
        case Computed(relation, _, _, function):
            yield Computed(relation, "1", "2", function) if holds else Not(Computed(relation, "1", "2", function))
        case Related(relation, subject, object_) if not is_stored(relation, ontology):
            yield from _asked(Computed(relation, subject, object_), ontology, holds=holds)
        case AllOf(patterns) | AnyOf(patterns):
            for part in patterns:
                yield from _asked(part, ontology, holds=holds)
        case Not(Exists(_, _, inner)):  # a goal checks each element for the opposite, a precondition for absence
            yield from _asked(inner, ontology, holds=holds)
            yield from _asked(inner, ontology, holds=not holds)
        case Not(inner):
            yield from _asked(inner, ontology, holds=not holds)
        case Exists(_, _, inner):
            yield from _asked(inner, ontology, holds=holds)
        case _:
            pass


def property_of(literal: Asked | Not) -> str | None:
    """Returns the property that a literal is about, or None if skills cannot change it."""
    match literal:
        case Has(property_) | Compare(property_) | Not(Has(property_) | Compare(property_)):
            return property_
        case _:
            return None


def allows_value(literal: Asked | Not, value: Value | None) -> bool:
    """Returns whether a literal about a property holds for elements with this value, or with none."""
    match literal:
        case Has():
            return value is not None
        case Compare():
            return literal.allows(value)
        case Not(Has() | Compare() as inner):
            return not allows_value(inner, value)
        case _:
            raise PlanningError(f"{literal} is about no property")
