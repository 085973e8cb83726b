"""Terms of pyoxigraph as terms of rdflib and back."""

from __future__ import annotations

from collections.abc import Iterable

import pyoxigraph as ox
import rdflib

from skiros_py.world.store.store import Term

Node = rdflib.URIRef | rdflib.BNode | rdflib.Literal


def to_rdflib(term: object) -> Node:
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


def triple_of(nodes: Iterable[object]) -> ox.Triple:
    """Returns rdflib's triple as ours."""
    subject, predicate, object_ = map(from_rdflib, nodes)
    assert isinstance(subject, ox.NamedNode | ox.BlankNode)
    assert isinstance(predicate, ox.NamedNode)
    return ox.Triple(subject, predicate, object_)
