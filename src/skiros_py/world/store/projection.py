"""Ontology, scene and what was learned as one RDF dataset that follows a world.

There is a graph for each ontology file, for the scene, for what was learned and, while a query needs it, for what was
inferred.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from skiros_py.errors import WorldError
from skiros_py.world.change import Change
from skiros_py.world.index import Index
from skiros_py.world.store.entailments import entailed_store
from skiros_py.world.store.oxigraph import OxigraphStore
from skiros_py.world.store.store import QuadStore
from skiros_py.world.store.triples import Triples

if TYPE_CHECKING:
    from skiros_py.world.world import World

__all__ = ["Projection", "TripleStore"]


class Projection:
    """One state of a world in a store, brought to later states change by change.

    Attributes:
        store: What holds it.
        version: Number of the last change that it shows.
    """

    def __init__(self, version: int, index: Index, store: Callable[[], QuadStore] = OxigraphStore) -> None:
        """Writes a state into a new store, in bulk.

        Args:
            version: The number of the last change that led to the state.
            index: The state.
            store: Makes an empty store.
        """
        self.version = version
        self._new = store
        self._triples = Triples(index.ontology)
        self._entailed: tuple[int, QuadStore] | None = None
        self.store = store()
        self.store.bulk_load(self._triples.ontology())
        self.store.bulk_load(self._triples.state(index))

    def follow(self, changes: Iterable[Change]) -> None:
        """Does the changes that come after its version, in order."""
        for change in changes:
            for edit in change.edits:
                self.store.remove(self._triples.before(edit))
                self.store.extend(self._triples.after(edit))
            self.version = change.number

    def entailed(self) -> QuadStore:
        """Returns a store of its own that also holds what OWL entails; the same until the version is another."""
        if self._entailed is None or self._entailed[0] != self.version:
            self._entailed = None  # the old one need not be in memory while the new one is made
            self._entailed = (self.version, entailed_store(self.store, self._new))
        return self._entailed[1]


class TripleStore:
    """The projection of a live world; it follows the world's changes whenever it is opened.

    Args:
        world: What it shows.
        store: Makes an empty store.
    """

    def __init__(self, world: World, store: Callable[[], QuadStore] = OxigraphStore) -> None:
        self._world = world
        self._new = store
        self._lock = threading.Lock()
        self._projection = Projection(*world.state(), store)

    @property
    def version(self) -> int:
        """Number of the last change that it shows."""
        return self._projection.version

    @contextmanager
    def opened(self) -> Iterator[QuadStore]:
        """Lends the store, up to date, to one reader at a time."""
        while True:
            with self._lock:
                if self._caught_up(self._world.version):
                    yield self._projection.store
                    return
            self._begin_anew()

    @contextmanager
    def opened_with_state(self, *, entailed: bool = False) -> Iterator[tuple[QuadStore, Index]]:
        """Lends the store together with the state that it shows, to one reader at a time.

        Args:
            entailed: Whether to lend the store that also holds what OWL entails.
        """
        while True:
            # The state comes before the lock: whoever holds the state back, writing, may be waiting for the store.
            version, index = self._world.state()
            with self._lock:
                remembered = self._caught_up(version)
                if self.version == version:  # else another reader has gone on already
                    yield (self._projection.entailed() if entailed else self._projection.store), index
                    return
            if not remembered:
                self._begin_anew()

    def _caught_up(self, version: int) -> bool:
        """Brings the store to a version or leaves it at a later one; False where the changes are forgotten."""
        if self.version >= version:
            return True
        try:
            changes = self._world.changes_since(self.version)
        except WorldError:
            return False
        self._projection.follow(change for change in changes if change.number <= version)
        return True

    def _begin_anew(self) -> None:
        projection = Projection(*self._world.state(), self._new)
        with self._lock:
            if projection.version > self.version:
                self._projection = projection
