"""Elements, relations and edits as RDF triples in their graphs."""

from __future__ import annotations

from collections.abc import Iterator

import pyoxigraph as ox

from skiros_py.world.abstract import abstract_individuals
from skiros_py.world.change import Edit, ElementEdit, GoalsEdit, PlacementEdit, PropertyEdit
from skiros_py.world.element import Element, Placement, Value, is_abstract, is_learned
from skiros_py.world.index import Index
from skiros_py.world.literals import format_value, literal_type
from skiros_py.world.names import LEARNED_GRAPH, SCENE, SCENE_GRAPH
from skiros_py.world.ontology import Ontology
from skiros_py.world.ontology.documents import Document
from skiros_py.world.vocabulary import GOAL, LABEL
from skiros_py.world.vocabulary import SCENE as SCENE_CLASS

__all__ = ["Triples"]

_SCENE_GRAPH = ox.NamedNode(SCENE_GRAPH)
_LEARNED_GRAPH = ox.NamedNode(LEARNED_GRAPH)


class Triples:
    """Writes the things of one ontology's worlds as triples.

    What is said of a learned individual is in the graph of what was learned, all else that can change in the scene's.
    """

    def __init__(self, ontology: Ontology) -> None:
        self._ontology = ontology
        self._names: dict[str, ox.NamedNode] = {}

    def state(self, index: Index) -> Iterator[ox.Quad]:
        """Yields all there is in a state, without what its ontology's files say."""
        yield from self.goals(index.goals)
        for name in index.ids():
            if not is_abstract(name) or is_learned(name):
                yield from self.element(index.element(name))
        said_by_files = set(abstract_individuals(index.ontology, index.reasoners).statements())
        for statement in index.statements():
            if statement not in said_by_files:
                yield self.relation(*statement)

    def ontology(self) -> Iterator[ox.Quad]:
        """Yields what the ontology's files say, each in a graph of its own."""
        seen: set[ox.Triple] = set()
        for file in self._ontology.sources:
            graph = ox.NamedNode(file.iri)
            for triple in _terms(file):
                if triple not in seen:  # two files may say the same, and rows are not to come twice
                    seen.add(triple)
                    yield ox.Quad(triple.subject, triple.predicate, triple.object, graph)

    def goals(self, goals: tuple[str, ...]) -> Iterator[ox.Quad]:
        """Yields the individual that bears the goals."""
        scene = ox.NamedNode(SCENE + "this")
        yield ox.Quad(scene, self._node("rdf:type"), self._node(SCENE_CLASS), _SCENE_GRAPH)
        for goal in goals:
            yield ox.Quad(scene, self._node(GOAL), ox.Literal(goal), _SCENE_GRAPH)

    def element(self, element: Element) -> Iterator[ox.Quad]:
        """Yields what an element is by itself: type, label, own values."""
        subject, graph = self._element(element.id), _graph(element.id)
        yield ox.Quad(subject, self._node("rdf:type"), self._node(element.type), graph)
        yield ox.Quad(subject, self._node(LABEL), ox.Literal(element.label), graph)
        for name, value in element.properties.items():
            yield ox.Quad(subject, self._node(name), self._literal(name, value), graph)

    def relation(self, subject: str, relation: str, object_: str) -> ox.Quad:
        """Returns one relation."""
        return ox.Quad(self._element(subject), self._node(relation), self._element(object_), _graph(subject))

    def value(self, element: str, property_: str, value: Value) -> ox.Quad:
        """Returns one property value."""
        return ox.Quad(self._element(element), self._node(property_), self._literal(property_, value), _graph(element))

    def before(self, edit: Edit) -> list[ox.Quad]:
        """Returns the triples that an edit takes away."""
        return self._side(edit, new=False)

    def after(self, edit: Edit) -> list[ox.Quad]:
        """Returns the triples that an edit brings."""
        return self._side(edit, new=True)

    def _side(self, edit: Edit, *, new: bool) -> list[ox.Quad]:
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

    def _placement(self, element: str, placement: Placement | None) -> list[ox.Quad]:
        if placement is None:
            return []
        subject, object_ = self._ontology.placement_pair(element, placement)
        return [self.relation(subject, placement.relation, object_)]

    def _literal(self, property_: str, value: Value) -> ox.Literal:
        range_ = "xsd:string" if property_ == LABEL else self._ontology.properties[property_].range
        return ox.Literal(format_value(value, range_), datatype=self._node(literal_type(value, range_)))

    def _node(self, name: str) -> ox.NamedNode:
        """The IRI of a word of the ontology: there are few, and they come again and again."""
        node = self._names.get(name)
        if node is None:
            node = self._names[name] = ox.NamedNode(self._ontology.names.iri(name))
        return node

    def _element(self, name: str) -> ox.NamedNode:
        return ox.NamedNode(SCENE + name) if ":" not in name else self._node(name)


def _graph(subject: str) -> ox.NamedNode:
    return _LEARNED_GRAPH if is_learned(subject) else _SCENE_GRAPH


def _terms(file: Document) -> Iterator[ox.Triple]:
    """What a file says of the ontology; its scene individuals would be there twice once a scene imports them."""
    for triple in file.triples:
        if not (isinstance(triple.subject, ox.NamedNode) and triple.subject.value.startswith(SCENE)):
            yield triple
