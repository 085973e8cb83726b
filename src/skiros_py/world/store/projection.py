"""Ontology, scene and learned concepts as one RDF dataset that follows a world.

There is a graph for each ontology file, for the scene, for the learned concepts and, while a query needs it, for
inferred triples.
"""

from __future__ import annotations

import threading
from collections.abc import Iterable, Iterator
from contextlib import contextmanager

import pyoxigraph as ox

from skiros_py.errors import MissingExtra, WorldError
from skiros_py.world.abstract import abstract_individuals
from skiros_py.world.change import Change, Edit, ElementEdit, GoalsEdit, PlacementEdit, PropertyEdit, SourceEdit
from skiros_py.world.element import Element, Value, is_abstract, is_learned
from skiros_py.world.index import Index
from skiros_py.world.literals import format_value, literal_type
from skiros_py.world.names import LEARNED_GRAPH, SCENE, SCENE_GRAPH
from skiros_py.world.ontology import Ontology
from skiros_py.world.ontology.documents import Document
from skiros_py.world.store.store import INFERRED_GRAPH, QuadStore
from skiros_py.world.vocabulary import GOAL, LABEL
from skiros_py.world.vocabulary import SCENE as SCENE_CLASS
from skiros_py.world.world import World

_SCENE_GRAPH = ox.NamedNode(SCENE_GRAPH)
_LEARNED_GRAPH = ox.NamedNode(LEARNED_GRAPH)


class Triples:
    """Converts worlds of one ontology to triples.

    Triples about learned individuals are in the graph of learned concepts, all others that can change in the scene's.
    """

    def __init__(self, ontology: Ontology) -> None:
        self._ontology = ontology
        self._names: dict[str, ox.NamedNode] = {}

    def state(self, index: Index) -> Iterator[ox.Quad]:
        """Yields the triples of a state, except those of the ontology's files."""
        yield from self.goals(index.goals)
        for name in index.ids():
            if not is_abstract(name) or is_learned(name):
                yield from self.element(index.element(name))
        said_by_files = set(abstract_individuals(index.ontology, index.reasoners).statements())
        for statement in index.statements():
            if statement not in said_by_files:
                yield self.relation(*statement)

    def ontology(self) -> Iterator[ox.Quad]:
        """Yields the triples of the ontology's files, each file in a graph of its own."""
        seen: set[ox.Triple] = set()
        for file in self._ontology.sources:
            graph = ox.NamedNode(file.iri)
            for triple in _terms(file):
                if triple not in seen:  # two files may say the same, and rows are not to come twice
                    seen.add(triple)
                    yield ox.Quad(triple.subject, triple.predicate, triple.object, graph)

    def goals(self, goals: tuple[str, ...]) -> Iterator[ox.Quad]:
        """Yields the individual that has the goals."""
        scene = ox.NamedNode(SCENE + "this")
        yield ox.Quad(scene, self._node("rdf:type"), self._node(SCENE_CLASS), _SCENE_GRAPH)
        for goal in goals:
            yield ox.Quad(scene, self._node(GOAL), ox.Literal(goal), _SCENE_GRAPH)

    def element(self, element: Element) -> Iterator[ox.Quad]:
        """Yields type, label and own values of an element."""
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

    def side(self, edit: Edit, *, new: bool) -> list[ox.Quad]:
        """Returns the triples that an edit adds (``new``) or removes."""
        if isinstance(edit, ElementEdit):
            element = edit.new if new else edit.old
            return [] if element is None else list(self.element(element))
        if isinstance(edit, PlacementEdit):
            where = edit.new if new else edit.old
            statement = where and self._ontology.placement_statement(edit.element, where)
            return [self.relation(*statement)] if statement else []
        if isinstance(edit, PropertyEdit):
            value = edit.new if new else edit.old
            return [] if value is None else [self.value(edit.element, edit.property, value)]
        if isinstance(edit, GoalsEdit):
            return list(self.goals(edit.new if new else edit.old))
        if isinstance(edit, SourceEdit):
            return []
        holds = edit.new if new else edit.old
        return [self.relation(edit.subject, edit.relation, edit.object)] if holds else []

    def _literal(self, property_: str, value: Value) -> ox.Literal:
        range_ = "xsd:string" if property_ == LABEL else self._ontology.properties[property_].range
        return ox.Literal(format_value(value), datatype=self._node(literal_type(value, range_)))

    def _node(self, name: str) -> ox.NamedNode:
        """The IRI of a word of the ontology; cached, since there are few."""
        node = self._names.get(name)
        if node is None:
            node = self._names[name] = ox.NamedNode(self._ontology.names.iri(name))
        return node

    def _element(self, name: str) -> ox.NamedNode:
        return ox.NamedNode(SCENE + name) if ":" not in name else self._node(name)


def _graph(subject: str) -> ox.NamedNode:
    return _LEARNED_GRAPH if is_learned(subject) else _SCENE_GRAPH


def _terms(file: Document) -> Iterator[ox.Triple]:
    """The triples of a file except those about scene individuals, which scenes import themselves."""
    for triple in file.triples:
        if not (isinstance(triple.subject, ox.NamedNode) and triple.subject.value.startswith(SCENE)):
            yield triple


# ---------------------------------------------------------------- the dataset


class Projection:
    """One state of a world in a store, brought to later states change by change.

    Attributes:
        store: The store with its triples.
        version: Number of the last change in it.
    """

    def __init__(self, index: Index) -> None:
        """Writes a state into a new store, in bulk."""
        self.version = index.version
        self._triples = Triples(index.ontology)
        self._entailed: tuple[int, QuadStore] | None = None
        self.store = QuadStore()
        self.store.bulk_load(self._triples.ontology())
        self.store.bulk_load(self._triples.state(index))

    def follow(self, changes: Iterable[Change]) -> None:
        """Applies the changes after its version, in order."""
        for change in changes:
            for edit in change.edits:
                self.store.remove(self._triples.side(edit, new=False))
                self.store.extend(self._triples.side(edit, new=True))
            self.version = change.number

    def entailed(self) -> QuadStore:
        """Returns a separate store that also contains entailed triples; the same one until the version changes."""
        if self._entailed is None or self._entailed[0] != self.version:
            self._entailed = None  # the old one need not be in memory while the new one is made
            self._entailed = (self.version, entailed_store(self.store))
        return self._entailed[1]


def entailed_store(stated: QuadStore) -> QuadStore:
    """Returns a new store with the stated triples, and the entailed ones in the graph of inferred triples."""
    quads = stated.quads()
    store = QuadStore()
    store.bulk_load(quads)
    store.bulk_load(_entailed(quads))
    return store


def _entailed(quads: Iterable[ox.Quad]) -> Iterator[ox.Quad]:
    """Yields the triples that OWL 2 RL entails: inverses, symmetry, transitivity, equivalence, sub-terms."""
    try:
        from reasonable import PyReasoner  # with rdflib, which most queries do without
    except ModuleNotFoundError:
        raise MissingExtra("ontology", "entailment") from None
    from skiros_py.world.store.store import to_rdflib, triple_of

    stated = {(to_rdflib(q.subject), to_rdflib(q.predicate), to_rdflib(q.object)) for q in quads}
    reasoner = PyReasoner()
    reasoner.from_graph(list(stated))
    for triple in reasoner.reason():
        if triple not in stated and triple[0] != triple[2]:  # "everything is the same as itself" is left out
            found = triple_of(triple)
            yield ox.Quad(found.subject, found.predicate, found.object, INFERRED_GRAPH)


class TripleStore:
    """The projection of a live world; it follows the world's changes whenever it is opened."""

    def __init__(self, world: World) -> None:
        self._world = world
        self._lock = threading.Lock()
        self._projection = Projection(world.snapshot())

    @property
    def version(self) -> int:
        """Number of the last change in it."""
        return self._projection.version

    @contextmanager
    def opened(self, *, entailed: bool = False) -> Iterator[tuple[QuadStore, Index]]:
        """Lends the up-to-date store together with the state that it contains, to one reader at a time.

        Args:
            entailed: Whether to lend the store that also contains entailed triples.
        """
        with self._lock:
            index = self._world.snapshot()
            try:
                changes = self._world.changes_since(self.version)
                self._projection.follow(change for change in changes if change.number <= index.version)
            except WorldError:  # they are no longer kept
                self._projection = Projection(index)
            yield (self._projection.entailed() if entailed else self._projection.store), index
