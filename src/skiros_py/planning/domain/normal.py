"""Patterns brought into one form for planning: negations at the leaves, general relations as their narrower ones."""

from __future__ import annotations

from collections.abc import Iterable

from skiros_py.errors import PlanningError
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
from skiros_py.world.ontology import Ontology
from skiros_py.world.terms import Family
from skiros_py.world.vocabulary import ELEMENT, PLACEMENT


def normal(pattern: Pattern, where: str, ontology: Ontology) -> Pattern:
    """Returns an equivalent pattern of AllOf, AnyOf, Exists, Not(Exists), literals and negated literals.

    A literal is about one relation, property or class; the body of a quantifier has the same form.

    Args:
        pattern: Any pattern.
        where: For the message of a refusal ("precondition X of skill 'y'").
        ontology: The ontology, with the hierarchy of relations.

    Raises:
        PlanningError: A part of it cannot be expressed in planning; the message names it.
    """
    match pattern:
        case Not(inner):
            return _denied(inner, where, ontology)
        case AnyOf(()):
            raise PlanningError(f"{where}: any of no conditions never holds; say what should hold")
        case Related(relation, subject, object_) if _is_computed(relation, ontology):
            return Computed(relation, subject, object_)
        case Related(relation, subject, object_):
            return _any_of(Related(r, subject, object_) for r in storable(relation, ontology))
        case Nothing(relation, object_):
            return _all_of(Nothing(r, object_) for r in storable(relation, ontology))
        case AllOf(patterns):
            return _all_of(normal(p, where, ontology) for p in patterns)
        case AnyOf(patterns):
            return _any_of(normal(p, where, ontology) for p in patterns)
        case Exists(variable, class_, inner):
            return Exists(variable, class_, normal(inner, where, ontology))
        case Has() | Compare() | IsA() | ClassRelated() | Computed():
            return pattern
        case _:
            raise _refused(pattern, where)


def _denied(pattern: Pattern, where: str, ontology: Ontology) -> Pattern:
    """Returns the normal form of a pattern's negation."""
    match pattern:
        case Not(inner):
            return normal(inner, where, ontology)
        case Related(relation, subject, object_) if _is_computed(relation, ontology):
            return Not(Computed(relation, subject, object_))
        case Related(relation, subject, object_):
            return _all_of(Not(Related(r, subject, object_)) for r in storable(relation, ontology))
        case Nothing(relation, object_):
            return _any_of(_something(r, object_, ontology) for r in storable(relation, ontology))
        case AllOf(patterns):
            return normal(AnyOf(tuple(Not(p) for p in patterns)), where, ontology)
        case AnyOf(patterns):
            return normal(AllOf(tuple(Not(p) for p in patterns)), where, ontology)
        case Exists(variable, class_, inner):
            return Not(Exists(variable, class_, normal(inner, where, ontology)))
        case Has() | Compare() | IsA() | ClassRelated() | Computed():
            return Not(pattern)
        case _:
            raise _refused(pattern, where)


def _refused(pattern: Pattern, where: str) -> PlanningError:
    if isinstance(pattern, Expression):
        advice = "a hold condition or a guard may ask for it, a plan cannot"
        return PlanningError(f"{where}: '{pattern.text}' can only be sensed; {advice}")
    kind = type(pattern).__name__
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


def _something(relation: str, object_: str, ontology: Ontology) -> Pattern:
    holder = f"{object_} holder"
    return Exists(holder, ontology.relations[relation].domain or ELEMENT, Related(relation, holder, object_))


def _all_of(patterns: Iterable[Pattern]) -> Pattern:
    parts = [p for pattern in patterns for p in (pattern.patterns if isinstance(pattern, AllOf) else (pattern,))]
    return parts[0] if len(parts) == 1 else AllOf(tuple(dict.fromkeys(parts)))


def _any_of(patterns: Iterable[Pattern]) -> Pattern:
    parts = [p for pattern in patterns for p in (pattern.patterns if isinstance(pattern, AnyOf) else (pattern,))]
    return parts[0] if len(parts) == 1 else AnyOf(tuple(dict.fromkeys(parts)))
