"""Implicit deletes (paper §6.2): whatever gets a new place loses its old one, over the whole placement family.

The same applies to functional relations that get another object. Works for relations in general: the ontology defines
which of them move something, and which end moves.
"""

from __future__ import annotations

from dataclasses import replace

from skiros_py.planning.domain.model import Action, Atom, NoneSuch, Variable
from skiros_py.planning.domain.normal import storable
from skiros_py.world.ontology import Ontology
from skiros_py.world.terms import End
from skiros_py.world.vocabulary import ELEMENT, PLACEMENT


def moved_and_place(atom: Atom, ontology: Ontology) -> tuple[str, str]:
    """Returns the argument that moves and the one that is its place, of an atom of the placement family."""
    subject, object_ = atom.arguments
    at_object = ontology.relations[atom.predicate].place_end == "object"
    return (subject, object_) if at_object else (object_, subject)


def is_placement(atom: Atom, ontology: Ontology) -> bool:
    """Returns whether an atom says where something is."""
    return atom.predicate in ontology.relations and ontology.is_placement(atom.predicate)


def with_implicit_deletes(action: Action, ontology: Ontology) -> tuple[Action, ...]:
    """Makes moved things leave their old place: named by a precondition, else by an additional parameter.

    Returns:
        The action; if no precondition gives the relation to the old place, a variant for each possible relation, the
        one to the new place first.
    """
    variants: tuple[Action, ...] = (action,)
    for added in action.add:
        if is_placement(added, ontology):
            variants = tuple(v for variant in variants for v in _leaving(variant, added, ontology))
        elif added.predicate in ontology.relations and ontology.relations[added.predicate].functional:
            variants = tuple(v for variant in variants for v in _replacing(variant, added, ontology))
    return variants


def _replacing(action: Action, added: Atom, ontology: Ontology) -> tuple[Action, ...]:
    """Creates the variant in which the relation had another object before, and the one in which it had none."""
    subject, new = added.arguments
    old = tuple(a for a in action.pre if a.predicate == added.predicate and a.arguments[0] == subject)
    if old:
        return (_without(action, old, f"{subject} has one such thing only"),)
    variable = Variable(_unused(f"{new}_before", action), ontology.relations[added.predicate].range or "")
    fact = Atom(added.predicate, (subject, variable.name))
    note = f"parameter {variable.name}, precondition {shown(fact)}: what {subject} has had until then"
    had = replace(action, parameters=(*action.parameters, variable), pre=(*action.pre, fact))
    none = NoneSuch((replace(variable, type=variable.type or ELEMENT),), (fact,))
    note_none = f"precondition no {shown(fact)}: the other variant is for when there is one"
    return (
        _without(replace(had, notes=(*action.notes, note)), (fact,), f"{subject} has one such thing only"),
        replace(action, none=(*action.none, none), notes=(*action.notes, note_none)),
    )


def _leaving(action: Action, added: Atom, ontology: Ontology) -> tuple[Action, ...]:
    moved, _ = moved_and_place(added, ontology)
    old = tuple(a for a in action.pre if is_placement(a, ontology) and moved_and_place(a, ontology)[0] == moved)
    if old:
        return (_without(action, old, f"{moved} has one place only"),)
    relations = _possible(action.types[moved], added.predicate, ontology)
    variants = (_with_old_place(action, relation, moved, ontology) for relation in relations)
    return tuple(_without(variant, variant.pre[-1:], f"{moved} has one place only") for variant in variants)


def _without(action: Action, old: tuple[Atom, ...], why: str) -> Action:
    missing = tuple(atom for atom in old if atom not in action.delete)
    if not missing:
        return action
    note = f"effect not {', not '.join(map(shown, missing))}: {why}"
    return replace(action, delete=action.delete + missing, notes=(*action.notes, note))


def _possible(class_: str, first: str, ontology: Ontology) -> tuple[str, ...]:
    """Returns the placement relations that something of a class can have, a given one first."""
    relations = (r for r in storable(PLACEMENT, ontology) if r != first and _can_be_moved(class_, r, ontology))
    return (first, *relations)


def _can_be_moved(class_: str, relation: str, ontology: Ontology) -> bool:
    words = ontology.relations[relation]
    end = words.domains if words.place_end == "object" else words.ranges
    return class_ not in ontology.classes or _may_fit(class_, end, ontology)


def _may_fit(class_: str, end: End, ontology: Ontology) -> bool:
    return any(not ontology.missed_end(below, end) for below in ontology.subclasses(class_))


def _with_old_place(action: Action, relation: str, moved: str, ontology: Ontology) -> Action:
    words = ontology.relations[relation]
    at_object = words.place_end == "object"
    variable = Variable(_unused(f"{moved}_from", action), (words.range if at_object else words.domain) or "")
    fact = Atom(relation, (moved, variable.name) if at_object else (variable.name, moved))
    note = f"parameter {variable.name}, precondition {shown(fact)}: the place that {moved} leaves"
    parameters = (*action.parameters, variable)
    return replace(action, parameters=parameters, pre=(*action.pre, fact), notes=(*action.notes, note))


def _unused(name: str, action: Action) -> str:
    """Returns a name that no parameter has, as close to the given one as possible."""
    while name in action.types:
        name += "'"
    return name


def shown(atom: Atom) -> str:
    """Returns an atom in readable form: "in(Ball, Box)"."""
    words = atom.predicate.split(" ")
    named = " ".join(word.partition(":")[2] or word for word in words)
    return f"{named}({', '.join(argument.lstrip('?') for argument in atom.arguments)})"
