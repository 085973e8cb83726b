"""Complement predicates: state that a relation does not hold, updated by every action that adds or deletes it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

from skiros_py.errors import PlanningError
from skiros_py.planning.domain.actions import is_placement, numbered, shown
from skiros_py.planning.domain.literals import NOT, is_stored, negated
from skiros_py.planning.domain.model import Action, Atom
from skiros_py.world.ontology import Ontology


def with_complements(actions: Iterable[Action], goal: Iterable[Atom], ontology: Ontology) -> tuple[Action, ...]:
    """Makes actions update the complements that some precondition, or the goal, requires.

    An action that ends a relation and makes it hold again, perhaps between the same two, becomes two variants: the
    added relation held before, or it did not.

    Raises:
        PlanningError: It is undecidable whether an action deletes a relation it adds.
    """
    drafts = tuple(actions)
    wanted = _wanted((*(atom for action in drafts for atom in action.pre), *goal), ontology)
    if not wanted:
        return drafts
    return numbered(variant for action in drafts for variant in _maintained(action, wanted, ontology))


def _wanted(atoms: Iterable[Atom], ontology: Ontology) -> frozenset[str]:
    """Returns the relations that some atom requires not to hold."""
    denied = (atom.predicate.removeprefix(NOT) for atom in atoms if atom.predicate.startswith(NOT))
    return frozenset(predicate for predicate in denied if is_stored(predicate, ontology))


def _maintained(action: Action, wanted: frozenset[str], ontology: Ontology) -> tuple[Action, ...]:
    for new in (atom for atom in action.add if atom.predicate in wanted and negated(atom) not in action.pre):
        ended = [old for old in action.delete if old != new and _may_be_one(new, old, action.types, ontology)]
        if ended:
            _check_unique(action, new, ended, ontology)
            variants = _starting(action, new, ended), _continuing(action, new, ended)
            return tuple(one for variant in variants for one in _maintained(variant, wanted, ontology))
    return (_with_effects(action, wanted),)


def _check_unique(action: Action, new: Atom, ended: Sequence[Atom], ontology: Ontology) -> None:
    """Refuses actions that may delete one relation and add another when there may be several."""
    functional = ontology.relations[new.predicate].functional
    unique = is_placement(new, ontology) or (functional and all(o.arguments[0] == new.arguments[0] for o in ended))
    if not unique or any(old not in action.pre for old in ended):
        raise PlanningError(
            f"skill '{action.skill}' ends {shown(ended[0])} and brings about {shown(new)}, which may be the same, and "
            "others ask that it is not so: make two skills of it"
        )


def _starting(action: Action, new: Atom, ended: Sequence[Atom]) -> Action:
    note = f"variant: {shown(new)} does not hold before, so it is not {' or '.join(map(shown, ended))}, which ends"
    return replace(action, pre=(*action.pre, negated(new)), notes=(*action.notes, note))


def _continuing(action: Action, new: Atom, ended: Sequence[Atom]) -> Action:
    """Returns the variant in which the added relation held before: everything has one place, so nothing is deleted."""
    return replace(
        action,
        pre=(*action.pre, new),
        add=tuple(atom for atom in action.add if atom != new),
        delete=tuple(atom for atom in action.delete if atom not in ended),
        notes=(*action.notes, f"variant: {shown(new)} holds before, and goes on to hold"),
    )


def _with_effects(action: Action, wanted: frozenset[str]) -> Action:
    added = [atom for atom in action.add if atom.predicate in wanted]
    deleted = [atom for atom in action.delete if atom.predicate in wanted and atom not in added]
    if not (added or deleted):
        return action
    starts, ends = tuple(map(negated, deleted)), tuple(map(negated, added))
    said = [*map(shown, starts), *(f"not {shown(atom)}" for atom in ends)]
    note = f"effect {', '.join(said)}: others ask that something is not so"
    return replace(action, add=action.add + starts, delete=action.delete + ends, notes=(*action.notes, note))


def _may_be_one(new: Atom, old: Atom, types: Mapping[str, str], ontology: Ontology) -> bool:
    """Returns whether two atoms of an action may refer to the same things."""
    return new.predicate == old.predicate and all(
        one == other or ontology.overlap(types.get(one, ""), types.get(other, ""))
        for one, other in zip(new.arguments, old.arguments, strict=True)
    )
