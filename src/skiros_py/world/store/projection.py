"""Ontology and scene as one RDF dataset in named graphs: one graph per ontology file, and the scene."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

import pyoxigraph as ox

from skiros_py.world.names import SCENE, SCENE_GRAPH
from skiros_py.world.ontology.documents import Document
from skiros_py.world.store.triples import Triples

if TYPE_CHECKING:
    from skiros_py.world.world import World

__all__ = ["TripleStore"]


class TripleStore:
    """A projection of a world's changes; it follows them whenever it is opened.

    Attributes:
        version: Number of the last change that it shows.
    """

    def __init__(self, world: World) -> None:
        self.version = 0
        self._world = world
        self._triples = Triples(world.ontology)
        self._graph = ox.NamedNode(SCENE_GRAPH)
        self._lock = threading.Lock()
        self._store = ox.Store()
        for file in world.ontology.sources:
            self._store.extend(_terms(file))
        self._store.extend(self._in_scene(self._triples.goals(world.goals)))

    @contextmanager
    def opened(self) -> Iterator[ox.Store]:
        """Lends the store, up to date, to one reader at a time; what is read must be read before the block ends.

        An iterator of results that another thread finishes kills the process, so none may leave the block.
        """
        with self._lock:
            self._catch_up()
            yield self._store

    def _catch_up(self) -> None:
        for change in self._world.changes_since(self.version):
            for edit in change.edits:
                for quad in self._in_scene(self._triples.before(edit)):
                    self._store.remove(quad)
                self._store.extend(self._in_scene(self._triples.after(edit)))
            self.version = change.number

    def _in_scene(self, triples: Iterator[ox.Triple] | list[ox.Triple]) -> list[ox.Quad]:
        return [ox.Quad(t.subject, t.predicate, t.object, self._graph) for t in triples]


def _terms(file: Document) -> list[ox.Quad]:
    """What a file says of the ontology; its scene individuals would be there twice once a scene imports them."""
    graph = ox.NamedNode(file.iri)
    return [
        ox.Quad(t.subject, t.predicate, t.object, graph)
        for t in file.triples
        if not (isinstance(t.subject, ox.NamedNode) and t.subject.value.startswith(SCENE))
    ]
