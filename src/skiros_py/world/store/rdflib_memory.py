"""Triples in rdflib, in memory: the naive store that the one that serves is compared with."""

from __future__ import annotations

import threading
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
from skiros_py.world.store.store import NO_FUNCTIONS, UNLIMITED, Answer, Functions, Most, Rows, Term

__all__ = ["RDFLIB_SPARQL", "RdflibStore", "for_rdflib", "from_rdflib", "to_rdflib", "triple_of"]

RDFLIB_SPARQL = threading.RLock()
"""rdflib's parser and its table of functions are for one thread at a time."""

_Node = rdflib.URIRef | rdflib.BNode | rdflib.Literal


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

    def query(self, text: str, *, functions: Functions = NO_FUNCTIONS, most: Most = UNLIMITED) -> Answer:
        """Answers a query; see the protocol."""
        with RDFLIB_SPARQL, _registered(functions), warnings.catch_warnings():
            warnings.simplefilter("ignore", DeprecationWarning)  # rdflib uses parts of itself that it is about to drop
            try:
                return _materialised(self._dataset.query(for_rdflib(text)), most)
            except (ParseException, RecursionError) as error:
                raise UsageError(f"the query does not parse: {error}") from None
            except UsageError:
                raise
            except Exception as error:  # noqa: BLE001  rdflib raises Exception itself
                raise UsageError(f"the query cannot be answered: {error}") from None

    def _parts(self, quad: ox.Quad) -> tuple[rdflib.Graph, tuple[_Node, _Node, _Node]]:
        assert isinstance(quad.graph_name, ox.NamedNode)
        triple = (to_rdflib(quad.subject), to_rdflib(quad.predicate), to_rdflib(quad.object))
        return self._dataset.graph(rdflib.URIRef(quad.graph_name.value)), triple


def to_rdflib(term: object) -> _Node:
    """Returns the term as rdflib has it."""
    if isinstance(term, ox.NamedNode):
        return rdflib.URIRef(term.value)
    if isinstance(term, ox.BlankNode):
        return rdflib.BNode(term.value)
    assert isinstance(term, ox.Literal)
    if term.language:
        return rdflib.Literal(term.value, lang=term.language)
    return rdflib.Literal(term.value, datatype=rdflib.URIRef(term.datatype.value), normalize=False)


def from_rdflib(node: object) -> Term:
    """Returns rdflib's term as ours."""
    if isinstance(node, rdflib.URIRef):
        return ox.NamedNode(str(node))
    if isinstance(node, rdflib.BNode):
        return ox.BlankNode(str(node))
    assert isinstance(node, rdflib.Literal)
    if node.language:
        return ox.Literal(str(node), language=node.language)
    return ox.Literal(str(node), datatype=ox.NamedNode(str(node.datatype)) if node.datatype else None)


def for_rdflib(text: str) -> str:
    r"""Returns the query with each ``\\`` spelt so that rdflib, which reads ``\u`` twice, reads it once."""
    return text.replace("\\\\", "\\u005C\\u005C")


def _materialised(result: Any, most: Most) -> Answer:
    if result.type == "ASK":
        return bool(result.askAnswer)
    if result.type == "SELECT":
        rows = (tuple(None if node is None else from_rdflib(node) for node in row) for row in result)
        return Rows(tuple(str(variable) for variable in result.vars), tuple(most.checked(rows)))
    return tuple(most.checked(map(triple_of, result.graph)))


def triple_of(nodes: Iterable[object]) -> ox.Triple:
    """Returns rdflib's triple as ours."""
    subject, predicate, object_ = map(from_rdflib, nodes)
    assert isinstance(subject, ox.NamedNode | ox.BlankNode)
    assert isinstance(predicate, ox.NamedNode)
    return ox.Triple(subject, predicate, object_)


@contextmanager
def _registered(functions: Functions) -> Iterator[None]:
    """To rdflib, functions are known for the whole process only."""
    own: Mapping[rdflib.URIRef, Callable[..., _Node]] = {
        rdflib.URIRef(iri): _as_rdflib(function) for iri, function in functions.items()
    }
    for iri, function in own.items():
        register_custom_function(iri, function, override=True)
    try:
        yield
    finally:
        for iri in own:
            unregister_custom_function(iri)


def _as_rdflib(function: Callable[..., Term | None]) -> Callable[..., _Node]:
    def call(*arguments: object) -> _Node:
        answer = function(*(from_rdflib(argument) for argument in arguments))
        if answer is None:
            raise SPARQLError("no answer")
        return to_rdflib(answer)

    return call
