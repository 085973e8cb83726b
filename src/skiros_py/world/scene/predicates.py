"""What the predicates of a file mean to an ontology."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum, auto

import pyoxigraph as ox

from skiros_py.world.element import Value
from skiros_py.world.literals import parse_value
from skiros_py.world.ontology import Ontology
from skiros_py.world.vocabulary import LABEL

__all__ = ["Kind", "Predicate", "Predicates"]


class Kind(Enum):
    """What a predicate says of an individual."""

    TYPE = auto()
    VALUE = auto()
    RELATION = auto()
    UNKNOWN = auto()


@dataclass(frozen=True, slots=True)
class Predicate:
    """One predicate.

    Attributes:
        name: Its CURIE.
        kind: What it says.
        range: CURIE of the data type of its values; "" where it has none.
    """

    name: str
    kind: Kind
    range: str = ""


class Predicates:
    """Predicates by IRI; each is looked up once, since files say the same few words again and again."""

    def __init__(self, ontology: Ontology) -> None:
        self._ontology = ontology
        self._by_iri: dict[str, Predicate] = {}
        self._types: dict[str, str] = {}

    def of(self, iri: str) -> Predicate:
        """Returns what a predicate means."""
        return self._by_iri.get(iri) or self._by_iri.setdefault(iri, self._look_up(iri))

    def value(self, predicate: Predicate, literal: ox.Literal) -> Value:
        """Reads a value of a predicate that has values.

        Raises:
            ValueError: The literal does not fit; the text says what would.
        """
        iri = literal.datatype.value
        type_ = self._types.get(iri) or self._types.setdefault(iri, self._ontology.names.name(iri))
        return parse_value(literal.value, type_, predicate.range)

    def _look_up(self, iri: str) -> Predicate:
        name = self._ontology.names.name(iri)
        if name == "rdf:type":
            return Predicate(name, Kind.TYPE)
        if name == LABEL:
            return Predicate(name, Kind.VALUE, "xsd:string")
        if name in self._ontology.properties:
            return Predicate(name, Kind.VALUE, self._ontology.properties[name].range)
        return Predicate(name, Kind.RELATION if name in self._ontology.relations else Kind.UNKNOWN)
