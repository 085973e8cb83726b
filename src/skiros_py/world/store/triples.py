"""Elements, relations and edits as RDF triples."""

from __future__ import annotations

from collections.abc import Iterator

import pyoxigraph as ox

from skiros_py.world.change import Edit, ElementEdit, GoalsEdit, PlacementEdit, PropertyEdit
from skiros_py.world.element import Element, Placement, Value
from skiros_py.world.literals import format_value, literal_type
from skiros_py.world.names import SCENE
from skiros_py.world.ontology import Ontology
from skiros_py.world.vocabulary import GOAL, LABEL
from skiros_py.world.vocabulary import SCENE as SCENE_CLASS

__all__ = ["Triples"]


class Triples:
    """Writes the things of one ontology's worlds as triples."""

    def __init__(self, ontology: Ontology) -> None:
        self._ontology = ontology

    def goals(self, goals: tuple[str, ...]) -> Iterator[ox.Triple]:
        """Yields the individual that bears the goals."""
        scene = ox.NamedNode(SCENE + "this")
        yield ox.Triple(scene, self._node("rdf:type"), self._node(SCENE_CLASS))
        for goal in goals:
            yield ox.Triple(scene, self._node(GOAL), ox.Literal(goal))

    def element(self, element: Element) -> Iterator[ox.Triple]:
        """Yields what an element is by itself: type, label, own values."""
        yield self.relation(element.id, "rdf:type", element.type)
        yield self.value(element.id, LABEL, element.label)
        for name in sorted(element.properties):
            yield self.value(element.id, name, element.properties[name])

    def relation(self, subject: str, relation: str, object_: str) -> ox.Triple:
        """Returns one relation."""
        return ox.Triple(self._node(subject), self._node(relation), self._node(object_))

    def value(self, element: str, property_: str, value: Value) -> ox.Triple:
        """Returns one property value."""
        range_ = "xsd:string" if property_ == LABEL else self._ontology.properties[property_].range
        literal = ox.Literal(format_value(value, range_), datatype=self._node(literal_type(value, range_)))
        return ox.Triple(self._node(element), self._node(property_), literal)

    def before(self, edit: Edit) -> list[ox.Triple]:
        """Returns the triples that an edit takes away."""
        return self._side(edit, new=False)

    def after(self, edit: Edit) -> list[ox.Triple]:
        """Returns the triples that an edit brings."""
        return self._side(edit, new=True)

    def _side(self, edit: Edit, *, new: bool) -> list[ox.Triple]:
        if isinstance(edit, ElementEdit):
            element = edit.new if new else edit.old
            return [] if element is None else list(self.element(element))
        if isinstance(edit, PlacementEdit):
            return self._placement(edit.element, edit.new if new else edit.old)
        if isinstance(edit, PropertyEdit):
            value = edit.new if new else edit.old
            return [] if value is None else [self.value(edit.element, edit.property, value)]
        if isinstance(edit, GoalsEdit):
            return list(self.goals(edit.new if new else edit.old))
        holds = edit.new if new else edit.old
        return [self.relation(edit.subject, edit.relation, edit.object)] if holds else []

    def _placement(self, element: str, placement: Placement | None) -> list[ox.Triple]:
        if placement is None:
            return []
        subject, object_ = self._ontology.placement_pair(element, placement)
        return [self.relation(subject, placement.relation, object_)]

    def _node(self, name: str) -> ox.NamedNode:
        return ox.NamedNode(self._ontology.names.iri(name))
