"""Compares the changes of a run with the declarations of its skill."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence

from skiros_py.skills.conditions import Assign, Condition, Effect, Not, Nothing, Relate, Unrelate
from skiros_py.skills.lint.rules.reach import brought_about
from skiros_py.world.change import Edit, ElementEdit, PlacementEdit, PropertyEdit, RelationEdit
from skiros_py.world.element import Placement
from skiros_py.world.index import Index
from skiros_py.world.ontology import Ontology
from skiros_py.world.scene import describe, diff
from skiros_py.world.vocabulary import HAS_A, MISSED_LOOKS, MISSING, POSE, POSE_FRAME

_OF_MOVED = frozenset({POSE, MISSING, MISSED_LOOKS})
"""Properties for the location of an element, which change when it is moved."""


def undeclared(before: Index, after: Index, posts: Sequence[Condition]) -> Iterator[str]:
    """Yields a line for each change between two states that no postcondition declares.

    Implied changes are not reported: a moved element leaves its old place, its pose and the poses of its parts change,
    and the previous object of a functional relation is removed.

    Args:
        before: The world before the run.
        after: The world after it.
        posts: The postconditions, over elements.
    """
    declared = _Declared(after, posts)
    for edit in diff(before, after):
        is_new_or_gone = not isinstance(edit, ElementEdit) and any(
            not (before.has(name) and after.has(name)) for name in edit.marks()
        )
        if not is_new_or_gone and not declared.covers(edit):
            yield from describe(after.ontology, [edit])


class _Declared:
    def __init__(self, world: Index, posts: Sequence[Condition]) -> None:
        self._ontology = world.ontology
        self._effects = [effect for condition in posts for effect in brought_about(condition)]
        moved = {name for effect in self._effects for name in _placed(effect, world.ontology)}
        self._moved = moved | {part for name in moved for part in _parts(world, name)}
        self._emptied = {(p.relation, p.object) for p in (c.pattern for c in posts) if isinstance(p, Nothing)}
        filled = (c.pattern for c in posts)
        self._filled = {
            (p.pattern.relation, p.pattern.object)
            for p in filled
            if isinstance(p, Not) and isinstance(p.pattern, Nothing)
        }

    def covers(self, edit: Edit) -> bool:
        """Returns whether an edit is implied or declared."""
        match edit:
            case PlacementEdit(element, old, new):
                return element in self._moved or _is_at(old, self._emptied) or _is_at(new, self._filled)
            case RelationEdit(subject, relation, object_):
                of_moved = relation == POSE_FRAME and subject in self._moved
                return of_moved or any(self._is_said(e, subject, relation, object_, edit.new) for e in self._effects)
            case PropertyEdit(element, property_):
                if element in self._moved and property_ in _OF_MOVED:
                    return True
                return any(_assigns(effect, element, property_) for effect in self._effects)
            case _:
                return False

    def _is_said(self, effect: Effect, subject: str, relation: str, object_: str, holds: bool) -> bool:
        match effect:
            case Relate(said, start, end) if holds:
                return (start, end) == (subject, object_) and relation in self._ontology.sub_relations(said)
            case Relate(said, start, end) if said == relation:  # replaces the previous object
                declared = self._ontology.relation(said)
                return (declared.functional and start == subject) or (declared.inverse_functional and end == object_)
            case Unrelate(said, start, end) if not holds:
                return (start, end) == (subject, object_) and relation in self._ontology.sub_relations(said)
            case _:
                return False


def _placed(effect: Effect, ontology: Ontology) -> Iterator[str]:
    match effect:
        case Relate(relation, subject, object_) if ontology.is_placement(relation):
            yield ontology.placed(subject, relation, object_)[0]
        case _:
            pass


def _parts(world: Index, element: str) -> Iterator[str]:
    for part in world.objects(element, HAS_A) if world.has(element) else ():
        yield part
        yield from _parts(world, part)


def _is_at(placement: Placement | None, places: Collection[tuple[str, str]]) -> bool:
    return placement is not None and (placement.relation, placement.place) in places


def _assigns(effect: Effect, element: str, property_: str) -> bool:
    return isinstance(effect, Assign) and (effect.subject, effect.property) == (element, property_)
