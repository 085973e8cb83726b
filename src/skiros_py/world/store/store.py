"""What a store of triples is: a small face with two implementations, one fast and one naive to compare it with."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Protocol, TypeVar

import pyoxigraph as ox

from skiros_py.errors import UsageError

__all__ = [
    "COMPUTED_GRAPH",
    "INFERRED_GRAPH",
    "NO_FUNCTIONS",
    "UNLIMITED",
    "Answer",
    "Functions",
    "Most",
    "QuadStore",
    "Rows",
    "Term",
]

INFERRED_GRAPH = ox.NamedNode("https://w3id.org/skiros-py/inferred")
"""The graph of what OWL entails, for queries that ask for that."""

COMPUTED_GRAPH = ox.NamedNode("https://w3id.org/skiros-py/computed")
"""The graph of what reasoners worked out for a query; empty as soon as that is answered."""

Term = ox.NamedNode | ox.BlankNode | ox.Literal
"""pyoxigraph's terms are plain values and serve as such for every store."""

Functions = Mapping[str, Callable[..., Term | None]]
"""Functions that a query may call, by IRI; None is no answer."""

NO_FUNCTIONS: Functions = MappingProxyType({})


@dataclass(frozen=True, slots=True)
class Rows:
    """What a SELECT answers: a term or None for each variable of each row."""

    variables: tuple[str, ...]
    rows: tuple[tuple[Term | None, ...], ...]


_Row = TypeVar("_Row", bound=Iterable[object])

Answer = Rows | bool | tuple[ox.Triple, ...]
"""What SELECT, ASK and CONSTRUCT answer."""


@dataclass(frozen=True, slots=True)
class Most:
    """How large an answer may get; a store stops reading where it gets larger.

    Attributes:
        rows: Rows or triples; None for any number.
        bytes: Characters of all terms together; None for any number.
    """

    rows: int | None = None
    bytes: int | None = None

    def checked(self, rows: Iterable[_Row]) -> Iterator[_Row]:
        """Yields the rows or triples of an answer.

        Raises:
            UsageError: There are too many; said before the first one too many is kept.
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


UNLIMITED = Most()


class QuadStore(Protocol):
    """Triples in named graphs, and SPARQL over all of them as one.

    Each triple is in one graph at most: stores need not notice that a triple is in two, and may show it twice.
    One thread at a time. Whatever is returned is complete: nothing is read from the store later.
    """

    def add(self, quad: ox.Quad) -> None:
        """Adds one; nothing happens where it is there already."""
        ...

    def extend(self, quads: Iterable[ox.Quad]) -> None:
        """Adds some."""
        ...

    def remove(self, quads: Iterable[ox.Quad]) -> None:
        """Takes some out; nothing happens for those that are not there."""
        ...

    def bulk_load(self, quads: Iterable[ox.Quad]) -> None:
        """Adds very many, as fast as may be; if that breaks off, some are there."""
        ...

    def clear(self, graph: ox.NamedNode) -> None:
        """Takes everything out of a graph."""
        ...

    def graphs(self) -> tuple[str, ...]:
        """Returns the IRIs of the graphs that hold something, sorted."""
        ...

    def quads(self, graph: ox.NamedNode | None = None) -> list[ox.Quad]:
        """Returns what is in a graph, or in all, in no order."""
        ...

    def __len__(self) -> int:
        """How many there are."""
        ...

    def query(self, text: str, *, functions: Functions = NO_FUNCTIONS, most: Most = UNLIMITED) -> Answer:
        """Answers SELECT, ASK or CONSTRUCT over all graphs as one; IRIs are written in full.

        Raises:
            UsageError: It does not parse, calls a function that there is not, or the answer gets too large.
        """
        ...
