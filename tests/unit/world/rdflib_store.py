"""Triples in rdflib, in memory: the naive store that the one that serves is compared with."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any

import pyoxigraph as ox
import rdflib
from pyparsing import ParseException
from rdflib.plugins.sparql.operators import register_custom_function, unregister_custom_function
from rdflib.plugins.sparql.sparql import SPARQLError

from skiros_py.errors import UsageError
from skiros_py.world.queries.computed import RDFLIB_SPARQL
from skiros_py.world.store.store import (
    NO_FUNCTIONS,
    UNLIMITED,
    Answer,
    AnswerLimits,
    Functions,
    Node,
    Rows,
    Term,
    for_rdflib,
    from_rdflib,
    to_rdflib,
    triple_of,
)


class RdflibStore:
    """A :class:`~skiros_py.world.store.store.QuadStore` of rdflib."""

    def __init__(self) -> None:
        self._dataset = rdflib.Dataset(default_union=True)

    def add(self, quad: ox.Quad) -> None:
        """Adds one."""
        graph, triple = self._parts(quad)
        graph.add(triple)

    def extend(self, quads: Iterable[ox.Quad]) -> None:
        """Adds some."""
        for quad in quads:
            self.add(quad)

    def remove(self, quads: Iterable[ox.Quad]) -> None:
        """Takes some out."""
        for quad in quads:
            graph, triple = self._parts(quad)
            graph.remove(triple)

    def bulk_load(self, quads: Iterable[ox.Quad]) -> None:
        """Adds very many."""
        self.extend(quads)

    def clear(self, graph: ox.NamedNode) -> None:
        """Takes a graph out."""
        self._dataset.remove_graph(rdflib.URIRef(graph.value))

    def graphs(self) -> tuple[str, ...]:
        """Returns the IRIs of the graphs that hold something, sorted."""
        return tuple(sorted(str(graph.identifier) for graph in self._dataset.graphs() if len(graph)))

    def quads(self, graph: ox.NamedNode | None = None) -> list[ox.Quad]:
        """Returns what is in a graph, or in all, in no order."""
        names = self.graphs() if graph is None else (graph.value,)
        return [
            ox.Quad(triple.subject, triple.predicate, triple.object, ox.NamedNode(name))
            for name in names
            for triple in map(triple_of, self._dataset.graph(rdflib.URIRef(name)))
        ]

    def __len__(self) -> int:
        return sum(len(graph) for graph in self._dataset.graphs())

    def query(self, text: str, *, functions: Functions = NO_FUNCTIONS, limits: AnswerLimits = UNLIMITED) -> Answer:
        """Answers a query; see the protocol."""
        with RDFLIB_SPARQL, _registered(functions), warnings.catch_warnings():
            warnings.simplefilter("ignore", DeprecationWarning)  # rdflib uses parts of itself that it is about to drop
            try:
                return _materialised(self._dataset.query(for_rdflib(text)), limits)
            except (ParseException, RecursionError) as error:
                raise UsageError(f"the query does not parse: {error}") from None
            except UsageError:
                raise
            except Exception as error:  # noqa: BLE001  rdflib raises Exception itself
                raise UsageError(f"the query cannot be answered: {error}") from None

    def _parts(self, quad: ox.Quad) -> tuple[rdflib.Graph, tuple[Node, Node, Node]]:
        assert isinstance(quad.graph_name, ox.NamedNode)
        triple = (to_rdflib(quad.subject), to_rdflib(quad.predicate), to_rdflib(quad.object))
        return self._dataset.graph(rdflib.URIRef(quad.graph_name.value)), triple


def _materialised(result: Any, limits: AnswerLimits) -> Answer:
    if result.type == "ASK":
        return bool(result.askAnswer)
    if result.type == "SELECT":
        rows = (tuple(None if node is None else from_rdflib(node) for node in row) for row in result)
        return Rows(tuple(str(variable) for variable in result.vars), tuple(limits.checked(rows)))
    return tuple(limits.checked(map(triple_of, result.graph)))


@contextmanager
def _registered(functions: Functions) -> Iterator[None]:
    """To rdflib, functions are known for the whole process only."""
    own: Mapping[rdflib.URIRef, Callable[..., Node]] = {
        rdflib.URIRef(iri): _as_rdflib(function) for iri, function in functions.items()
    }
    for iri, function in own.items():
        register_custom_function(iri, function, override=True)
    try:
        yield
    finally:
        for iri in own:
            unregister_custom_function(iri)


def _as_rdflib(function: Callable[..., Term | None]) -> Callable[..., Node]:
    def call(*arguments: object) -> Node:
        answer = function(*(from_rdflib(argument) for argument in arguments))
        if answer is None:
            raise SPARQLError("no answer")
        return to_rdflib(answer)

    return call
