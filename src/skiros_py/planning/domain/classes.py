"""Classes as PDDL types: a tree along primary parents; every other class becomes a static predicate."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from skiros_py.planning.domain.model import Action, Atom, NoneSuch, Variable
from skiros_py.world.ontology import Ontology

IS = "is "
"""Prefix of the predicate stating that an object is of a class."""


def primary_line(ontology: Ontology, class_: str) -> tuple[str, ...]:
    """Returns the ancestors of a class along primary parents only, nearest first."""
    parent = ontology.classes[class_].primary_parent
    return (parent, *primary_line(ontology, parent)) if parent is not None and parent in ontology.classes else ()


def common_class(one: str, other: str, ontology: Ontology) -> str:
    """Returns the nearest class on both primary lines, or "object"; an empty class counts as any."""
    if not one or not other:
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
