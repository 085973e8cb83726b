"""Triples in pyoxigraph, in memory: the store that serves."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import islice
from typing import Any

import pyoxigraph as ox

from skiros_py.errors import UsageError
from skiros_py.world.store.parse_faults import parse_fault
from skiros_py.world.store.store import NO_FUNCTIONS, UNLIMITED, Answer, Functions, Most, Rows, Term

__all__ = ["OxigraphStore"]

_LONGEST_FAULT = 200

_PIECE = 100_000
"""Quads loaded at once: the loader sorts them in memory, twice as much of it for all at once."""


class OxigraphStore:
    """A :class:`~skiros_py.world.store.store.QuadStore` of pyoxigraph.

    An iterator of its results that another thread finishes kills the process, so none ever leaves a method.
    """

    def __init__(self) -> None:
        self._store = ox.Store()

    def add(self, quad: ox.Quad) -> None:
        """Adds one."""
        self._store.add(quad)

    def extend(self, quads: Iterable[ox.Quad]) -> None:
        """Adds some: all, or, if that breaks off, none."""
        self._store.extend(quads)

    def remove(self, quads: Iterable[ox.Quad]) -> None:
        """Takes some out."""
        for quad in quads:
            self._store.remove(quad)

    def bulk_load(self, quads: Iterable[ox.Quad]) -> None:
        """Adds very many."""
        waiting = iter(quads)
        while piece := list(islice(waiting, _PIECE)):
            self._store.bulk_extend(piece)

    def clear(self, graph: ox.NamedNode) -> None:
        """Takes a graph out."""
        self._store.remove_graph(graph)

    def graphs(self) -> tuple[str, ...]:
        """Returns the IRIs of the graphs that hold something, sorted."""
        named = [graph for graph in self._store.named_graphs() if isinstance(graph, ox.NamedNode)]
        return tuple(sorted(g.value for g in named if any(self._store.quads_for_pattern(None, None, None, g))))

    def quads(self, graph: ox.NamedNode | None = None) -> list[ox.Quad]:
        """Returns what is in a graph, or in all, in no order."""
        return list(self._store.quads_for_pattern(None, None, None, graph))

    def __len__(self) -> int:
        return len(self._store)

    def query(self, text: str, *, functions: Functions = NO_FUNCTIONS, most: Most = UNLIMITED) -> Answer:
        """Answers a query; see the protocol."""
        own: Any = {ox.NamedNode(iri): function for iri, function in functions.items()}
        try:
            result = self._store.query(text, use_default_graph_as_union=True, custom_functions=own or None)
            return _materialised(result, most)
        except SyntaxError as error:
            raise UsageError(f"the query does not parse: {parse_fault(text, error.msg)[:_LONGEST_FAULT]}") from None
        except (RuntimeError, ValueError, OSError) as error:
            raise UsageError(f"the query cannot be answered: {error}") from None


def _materialised(result: ox.QuerySolutions | ox.QueryBoolean | ox.QueryTriples, most: Most) -> Answer:
    if isinstance(result, ox.QueryBoolean):
        return bool(result)
    if isinstance(result, ox.QuerySolutions):
        rows: Iterable[tuple[Term | None, ...]] = map(tuple, result)
        return Rows(tuple(variable.value for variable in result.variables), tuple(most.checked(rows)))
    return tuple(most.checked(result))
