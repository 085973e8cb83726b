"""Patterns as conjunctions of literals, in one form for planning; classes as PDDL types."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import cast

from skiros_py.errors import PlanningError
from skiros_py.planning.domain.model import Action, Atom, NoneSuch, Variable
from skiros_py.skills.conditions import (
    AllOf,
    AnyOf,
    ClassRelated,
    Compare,
    Computed,
    Exists,
    Expression,
    Has,
    IsA,
    Not,
    Nothing,
    Pattern,
    Related,
)
from skiros_py.skills.conditions.condition import Comparison, Operator
from skiros_py.skills.conditions.pattern import NumberChange
from skiros_py.world.element import Value
from skiros_py.world.names import local_name
from skiros_py.world.ontology import Ontology
from skiros_py.world.terms import Family
from skiros_py.world.vocabulary import ELEMENT, PLACEMENT

IS = "is "
"""Prefix of the predicate stating that an object is of a class."""


def primary_line(ontology: Ontology, class_: str) -> tuple[str, ...]:
    """Returns the ancestors of a class along primary parents only, nearest first."""
    parent = ontology.classes[class_].primary_parent
    return (parent, *primary_line(ontology, parent)) if parent is not None and parent in ontology.classes else ()


def common_class(one: str, other: str, ontology: Ontology) -> str:
    """Returns the nearest class on both primary lines, or "object"; an empty class counts as any."""
    if one == other or not one or not other:
        return one or other
    if "object" in (one, other):
        return "object"
    others = (other, *primary_line(ontology, other))
    return next((c for c in (one, *primary_line(ontology, one)) if c in others), "object")


def with_class_predicates(
    actions: Sequence[Action], objects: Mapping[str, str], ontology: Ontology
) -> tuple[Action, ...]:
    """Widens parameters whose class some object has through a secondary parent, and adds a class predicate."""
    asked = {v.type for action in actions for v in action.variables if v.type}
    wide = {class_: _widened(class_, set(objects.values()), ontology) for class_ in asked}
    return tuple(_widen(action, wide) for action in actions)


def _widened(class_: str, present: set[str], ontology: Ontology) -> str:
    result = class_
    for type_ in sorted(present):
        if ontology.is_a(type_, class_) and class_ not in (type_, *primary_line(ontology, type_)):
            result = common_class(result, type_, ontology)
    return result


def _widen(action: Action, wide: Mapping[str, str]) -> Action:
    changed = [v for v in action.variables if v.type and wide[v.type] != v.type]
    if not changed:
        return action
    parameters, asks = _widened_variables(action.parameters, wide)
    none = ((_widened_variables(such.variables, wide), such.atoms) for such in action.none)
    notes = tuple(
        f"{v.name.lstrip('?')}: class {v.type} is asked for by a predicate, some have it by a second parent"
        for v in changed
    )
    return replace(
        action,
        parameters=parameters,
        pre=(*asks, *action.pre),
        none=tuple(NoneSuch(variables, (*own, *atoms)) for (variables, own), atoms in none),
        notes=(*action.notes, *notes),
    )


def _widened_variables(
    variables: Sequence[Variable], wide: Mapping[str, str]
) -> tuple[tuple[Variable, ...], tuple[Atom, ...]]:
    """Returns variables of wider classes, and the predicates for the narrower ones."""
    asks = tuple(Atom(IS + v.type, (v.name,)) for v in variables if v.type and wide[v.type] != v.type)
    return tuple(Variable(v.name, wide.get(v.type, v.type)) for v in variables), asks


def normal(pattern: Pattern, where: str, ontology: Ontology, *, holds: bool = True) -> Pattern:
    """Returns an equivalent pattern of AllOf, AnyOf, Exists, Not(Exists), literals and negated literals.

    A literal is about one relation, property or class; the body of a quantifier has the same form.

    Args:
        pattern: Any pattern.
        where: For the message of a refusal ("precondition X of skill 'y'").
        ontology: The ontology, with the hierarchy of relations.
        holds: False for the negation of the pattern.

    Raises:
        PlanningError: A part of it cannot be expressed in planning; the message names it.
    """
    every, some = (AllOf, AnyOf) if holds else (AnyOf, AllOf)

    def signed(part: Pattern) -> Pattern:
        return part if holds else Not(part)

    match pattern:
        case Not(inner):
            return normal(inner, where, ontology, holds=not holds)
        case AllOf(()) | AnyOf(()) if isinstance(pattern, AnyOf) is holds:
            raise PlanningError(f"{where}: any of no conditions never holds; say what should hold")
        case Related(relation, subject, object_) if _is_computed(relation, ontology):
            return signed(Computed(relation, subject, object_))
        case Related(relation, subject, object_):
            return _flat(some, (signed(Related(r, subject, object_)) for r in storable(relation, ontology)))
        case Nothing(relation, object_) if holds:
            return _flat(AllOf, (Nothing(r, object_) for r in storable(relation, ontology)))
        case Nothing(relation, object_):
            return _flat(AnyOf, (something(r, object_, ontology) for r in storable(relation, ontology)))
        case AllOf(patterns):
            return _flat(every, (normal(p, where, ontology, holds=holds) for p in patterns))
        case AnyOf(patterns):
            return _flat(some, (normal(p, where, ontology, holds=holds) for p in patterns))
        case Exists(variable, class_, inner):
            return signed(Exists(variable, class_, normal(inner, where, ontology)))
        case Has() | Compare() | IsA() | ClassRelated() | Computed():
            return signed(pattern)
        case _:
            raise _refused(pattern, where)


def _refused(pattern: Pattern, where: str) -> PlanningError:
    if isinstance(pattern, Expression):
        advice = "a hold condition or a guard may ask for it, a plan cannot"
        return PlanningError(f"{where}: '{pattern.text}' can only be sensed; {advice}")
    kind = type(pattern).__name__
    if isinstance(pattern, NumberChange):
        return PlanningError(f"{where}: {kind} says what a skill does to a number; ask for the number: Compare(…)")
    return PlanningError(f"{where}: a pattern of kind {kind} cannot be planned with; use the kinds that there are")


def is_stored(relation: str, ontology: Ontology) -> bool:
    """Returns whether a predicate is a stored relation, not a computed one."""
    return relation in ontology.relations and not _is_computed(relation, ontology)


def _is_computed(relation: str, ontology: Ontology) -> bool:
    return ontology.family(relation) is Family.COMPUTED


def storable(relation: str, ontology: Ontology) -> tuple[str, ...]:
    """Returns those of a relation and its sub-relations that can be stored.

    The root of the placement family only groups its sub-relations: nothing is placed by it.
    """
    return tuple(r for r in ontology.sub_relations(relation) if r != PLACEMENT) or (relation,)


def something(relation: str, object_: str, ontology: Ontology) -> Exists:
    """Returns the pattern that says that something has a relation to an element: the opposite of nothing."""
    holder = f"{object_.lstrip('?')} holder"
    return Exists(holder, ontology.relations[relation].domain or ELEMENT, Related(relation, holder, object_))


def _flat(kind: type[AllOf | AnyOf], patterns: Iterable[Pattern]) -> Pattern:
    parts = [p for pattern in patterns for p in (pattern.patterns if isinstance(pattern, kind) else (pattern,))]
    return parts[0] if len(parts) == 1 else kind(tuple(dict.fromkeys(parts)))


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
            return tuple(joined(combination) for combination in combinations)
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


def joined(parts: Iterable[Conjunction]) -> Conjunction:
    """Returns all parts as one."""
    parts = tuple(parts)
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
            own: Asked = replace(pattern, subject="1")
            yield own if holds else Not(own)
        case ClassRelated() | Computed():
            own = replace(pattern, subject="1", object="2")
            yield own if holds else Not(own)
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
