"""The triple store: pyoxigraph in memory, with limits on answers and readable syntax errors."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from itertools import islice
from types import MappingProxyType
from typing import Any, TypeVar

import pyoxigraph as ox
import rdflib

from skiros_py.errors import UsageError

_FAULT = re.compile(r"error at (\d+):(\d+): expected (?:one of )?(.*)", re.DOTALL)
_LISTED = re.compile(r'"(?:\\.|[^"\\])*"|\[[^\]]*\]', re.DOTALL)
"""Parts of a message that are not words: quoted signs, and sets of signs."""
_SIGN = re.compile(r'"((?:\\.|[^"\\])+)"|\[(.)[^\]]*\]')
_WORD = re.compile(r"<[^>\s]*>|[?$]?\w+|\S")
_BEFORE, _AFTER = 3, 2
"""Number of words shown around the location."""
_KINDS = {
    "a variable": ("?", "$"),
    "a name": (":", "<", "_:"),
    "a value": ('\\"', "'", "+", "true"),
    "a number": ("[0",),
}
"""Kinds of tokens, each with signs that it begins with."""
_BRACKETS = ("{", "}", "(", ")", "=", ",", ";", "*", "/", "|", "^")
_LONGEST = 60


def parse_fault(text: str, message: str) -> str:
    """Returns where parsing a query stops and what could follow; the message itself if it is of another kind.

    Column numbers are omitted: names have been expanded since the query was written.

    Args:
        text: The query as the engine has read it.
        message: The message of the engine.
    """
    found = _FAULT.fullmatch(message)
    if found is None:
        return message
    line, column = int(found[1]), int(found[2])
    reason = _reason(found[3])
    if reason:
        return f"line {line}: {reason}"
    lines = text.split("\n")
    before = "\n".join([*lines[: line - 1], lines[line - 1][: column - 1]])
    after = "\n".join([lines[line - 1][column - 1 :], *lines[line:]])
    expected = _expected(found[3])
    ends = bool(expected) and not after.strip()
    what = "the query ends too early" if ends else f"something is wrong near {_near(before, after)}"
    return f"line {line}: {what}" + (f"; expected {expected}" if expected else "")


def _reason(signs: str) -> str:
    """Returns the words of a message ("Prefix not found"); empty if it only lists signs."""
    said = (each.strip() for each in _LISTED.sub("", signs).split(","))
    return next((each for each in said if each[:1].isalpha() and " " in each), "")


def _near(before: str, after: str) -> str:
    """Returns the words around a location: the engine looks ahead, so the fault may be just before or after it."""
    words = [*_WORD.findall(before)[-_BEFORE:], *_WORD.findall(after)[:_AFTER]]
    said = (re.split("[#/]", word.strip("<>"))[-1] if word.startswith("<") else word for word in words)
    return f"'{' '.join(said)[:_LONGEST]}'"


def _expected(signs: str) -> str:
    """Names the expected kinds of tokens, without keywords: the engine lists too many."""
    known = {match[1] or f"[{match[2]}" for match in _SIGN.finditer(signs.replace("['", "["))}
    kinds = [kind for kind, begins in _KINDS.items() if known.intersection(begins)]
    if "a value" in kinds:
        kinds = [kind for kind in kinds if kind != "a number"]
    kinds += [f"'{sign}'" for sign in _BRACKETS if sign in known]
    return " or ".join(filter(None, [", ".join(kinds[:-1]), *kinds[-1:]]))


# ---------------------------------------------------------------- the triple store


INFERRED_GRAPH = ox.NamedNode("https://w3id.org/skiros-py/inferred")
"""The graph of triples entailed by OWL, for queries that request them."""

COMPUTED_GRAPH = ox.NamedNode("https://w3id.org/skiros-py/computed")
"""The graph of the computed relations of a query; empty as soon as it is answered."""

Term = ox.NamedNode | ox.BlankNode | ox.Literal
"""A term of a triple."""

Functions = Mapping[str, Callable[..., Term | None]]
"""Functions that a query may call, by IRI; they return None if there is no answer."""

NO_FUNCTIONS: Functions = MappingProxyType({})


@dataclass(frozen=True, slots=True)
class Rows:
    """The answer to a SELECT: a term or None for each variable of each row."""

    variables: tuple[str, ...]
    rows: tuple[tuple[Term | None, ...], ...]


_Row = TypeVar("_Row", bound=Iterable[object])

Answer = Rows | bool | tuple[ox.Triple, ...]
"""The answers to SELECT, ASK and CONSTRUCT."""


@dataclass(frozen=True, slots=True)
class AnswerLimits:
    """Maximum size of an answer; a store stops reading when it is exceeded.

    Attributes:
        rows: Rows or triples; None for no limit.
        bytes: Characters of all terms together; None for no limit.
    """

    rows: int | None = None
    bytes: int | None = None

    def checked(self, rows: Iterable[_Row]) -> Iterator[_Row]:
        """Yields the rows or triples of an answer.

        Raises:
            UsageError: There are too many; raised before the first of them is stored.
        """
        if self.rows is None and self.bytes is None:
            yield from rows
            return
        size = 0
        for number, row in enumerate(rows):
            size += sum(len(str(term)) for term in row)
            if self.rows is not None and number >= self.rows:
                raise UsageError(f"the answer has more than {self.rows} rows: ask for less, or end with LIMIT")
            if self.bytes is not None and size > self.bytes:
                raise UsageError(f"the answer has more than {self.bytes} bytes: ask for less, or end with LIMIT")
            yield row


UNLIMITED = AnswerLimits()

_LONGEST_FAULT = 200

_PIECE = 100_000
"""Quads loaded at once: the loader sorts them in memory, twice as much of it for all at once."""


class QuadStore:
    """Triples in named graphs, in memory, and SPARQL over all of them as one.

    Each triple belongs to one graph at most. For one thread at a time. All results are returned complete: an iterator
    of results that is finished by another thread kills the process, so none leaves a method.
    """

    def __init__(self) -> None:
        self._store = ox.Store()

    def add(self, quad: ox.Quad) -> None:
        """Adds a quad."""
        self._store.add(quad)

    def extend(self, quads: Iterable[ox.Quad]) -> None:
        """Adds several quads: all or, if that fails, none."""
        self._store.extend(quads)

    def remove(self, quads: Iterable[ox.Quad]) -> None:
        """Removes quads."""
        for quad in quads:
            self._store.remove(quad)

    def bulk_load(self, quads: Iterable[ox.Quad]) -> None:
        """Adds very many quads."""
        waiting = iter(quads)
        while piece := list(islice(waiting, _PIECE)):
            self._store.bulk_extend(piece)

    def clear(self, graph: ox.NamedNode) -> None:
        """Removes a graph."""
        self._store.remove_graph(graph)

    def graphs(self) -> tuple[str, ...]:
        """Returns the IRIs of the graphs that are not empty, sorted."""
        named = [graph for graph in self._store.named_graphs() if isinstance(graph, ox.NamedNode)]
        return tuple(sorted(g.value for g in named if any(self._store.quads_for_pattern(None, None, None, g))))

    def quads(self, graph: ox.NamedNode | None = None) -> list[ox.Quad]:
        """Returns the quads of a graph, or of all, in no order."""
        return list(self._store.quads_for_pattern(None, None, None, graph))

    def __len__(self) -> int:
        return len(self._store)

    def query(self, text: str, *, functions: Functions = NO_FUNCTIONS, limits: AnswerLimits = UNLIMITED) -> Answer:
        """Answers SELECT, ASK or CONSTRUCT over the union of all graphs; IRIs must be written in full.

        Raises:
            UsageError: It does not parse, calls an unknown function, or the answer is too large.
        """
        own: Any = {ox.NamedNode(iri): function for iri, function in functions.items()}
        try:
            result = self._store.query(text, use_default_graph_as_union=True, custom_functions=own or None)
            return _materialised(result, limits)
        except SyntaxError as error:
            raise UsageError(f"the query does not parse: {parse_fault(text, error.msg)[:_LONGEST_FAULT]}") from None
        except (RuntimeError, ValueError, OSError) as error:
            raise UsageError(f"the query cannot be answered: {error}") from None


def _materialised(result: ox.QuerySolutions | ox.QueryBoolean | ox.QueryTriples, limits: AnswerLimits) -> Answer:
    if isinstance(result, ox.QueryBoolean):
        return bool(result)
    if isinstance(result, ox.QuerySolutions):
        rows: Iterable[tuple[Term | None, ...]] = map(tuple, result)
        return Rows(tuple(variable.value for variable in result.variables), tuple(limits.checked(rows)))
    return tuple(limits.checked(result))


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
