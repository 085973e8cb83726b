"""Elements of one state of the world, as plain data."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import Any

from skiros_py.api import elements as api
from skiros_py.api.values import Placement, Pose
from skiros_py.errors import UsageError
from skiros_py.station.world.values import plain
from skiros_py.world.element import is_abstract
from skiros_py.world.index import Index
from skiros_py.world.poses import map_pose
from skiros_py.world.taught import lesson_about
from skiros_py.world.terms import Family
from skiros_py.world.vocabulary import POSE, POSE_FRAME

_MOST_RELATIONS = 200
"""Maximum number of relations returned with an element."""


def summary(view: Index, name: str) -> api.ElementSummary:
    """Describes an element for a list.

    Raises:
        UnknownName: There is none with this id.
    """
    element, placement = view.element(name), view.placement(name)
    return api.ElementSummary(
        id=name,
        class_=element.type,
        label=element.label,
        placement=None if placement is None else Placement(relation=placement.relation, place=placement.place),
        abstract=is_abstract(name),
        version=view.stamp(name).change,
    )


def details(view: Index, name: str, computed: Sequence[str] = ()) -> api.ElementDetails:
    """Describes an element.

    Args:
        view: The state.
        name: Its id.
        computed: Computed relations to include; "all" for all.

    Raises:
        UnknownName: There is none with this id, or no such relation.
        UsageError: A relation is stated, not computed.
    """
    stated = relations(view, name)
    pose = map_pose(view, name)
    return api.ElementDetails(
        **dict(summary(view, name)),
        changed_at=view.stamp(name).time,
        properties=dict(_properties(view, name)),
        relations=stated[:_MOST_RELATIONS],
        relations_total=len(stated),
        computed=computed_relations(view, name, computed),
        owner=next(iter(view.owners(name)), None),
        map_pose=None if pose is None else Pose(position=pose.position, orientation=pose.orientation),
    )


def relations(view: Index, name: str) -> list[api.Relation]:
    """Returns the stated relations of an element, in both directions, sorted."""
    return list(_relations(view, view.statements_about(name)))


def _relations(view: Index, statements: Iterable[tuple[str, str, str]]) -> Iterator[api.Relation]:
    for subject, relation, object_ in statements:
        family = view.ontology.family(relation).value
        yield api.Relation(subject=subject, relation=relation, object=object_, family=family)


def computed_relations(view: Index, name: str, wanted: Sequence[str]) -> list[api.Relation]:
    """Computes relations of an element: at most 200 of each, in either direction.

    Args:
        view: The state.
        name: Its id.
        wanted: The relations to compute; "all" for all.

    Raises:
        UnknownName: There is no such element or relation, or no reasoner computes it.
        UsageError: A relation is stated, not computed.
    """
    found: set[tuple[str, str, str]] = set()
    for relation in dict.fromkeys(each for word in wanted for each in _named(view, word)):
        found |= {(name, relation, other) for other in view.objects(name, relation)[:_MOST_RELATIONS]}
        found |= {(other, relation, name) for other in view.subjects(relation, name)[:_MOST_RELATIONS]}
    return list(_relations(view, sorted(found)))


def _named(view: Index, word: str) -> Sequence[str]:
    ontology = view.ontology
    if word == "all":
        return [name for name in ontology.relations if view.reasoners.computes(name)]
    if ontology.family(word) is not Family.COMPUTED:
        raise UsageError(f"{word} is stated, not computed: it is among the relations of the element already")
    return [word]


# ------------------------------------------------------------------ properties


def _properties(view: Index, name: str) -> Iterator[tuple[str, api.Property]]:
    """Yields the properties of the element, of any origin."""
    for property_ in sorted(view.ontology.properties):
        value = view.value(name, property_)
        if value is not None:
            frame = next(iter(view.objects(name, POSE_FRAME)), None) if property_ == POSE else None
            yield property_, _property(view, name, property_, plain(value, frame))


def _property(view: Index, name: str, property_: str, value: Any) -> api.Property:
    element = view.element(name)
    if property_ in element.properties:
        return api.Property(value=value, origin="own")
    lesson = lesson_about(view, element.type, property_)
    if lesson is None:
        return api.Property(value=value, origin="class")
    return api.Property(value=value, origin="taught", taught_by=lesson.id)
