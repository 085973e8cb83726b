"""What one ontology file declares, counted."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import pyoxigraph as ox

from skiros_py.world.names import STANDARD_PREFIXES
from skiros_py.world.ontology.documents import Document

__all__ = ["Inventory", "inventory"]

_TYPE = STANDARD_PREFIXES["rdf"] + "type"
_COUNTED = {
    "classes": STANDARD_PREFIXES["owl"] + "Class",
    "relations": STANDARD_PREFIXES["owl"] + "ObjectProperty",
    "properties": STANDARD_PREFIXES["owl"] + "DatatypeProperty",
}


@dataclass(frozen=True, slots=True)
class Inventory:
    """One file.

    Attributes:
        path: Where it is.
        iri: IRI of its ontology.
        counts: How many terms and individuals it declares, and how many statements it makes.
    """

    path: Path
    iri: str
    counts: Mapping[str, int]


def inventory(document: Document) -> Inventory:
    """Counts what a file declares; individuals are named things of a class that is no standard one."""
    types: dict[str, set[str]] = {}
    for triple in document.triples:
        subject, type_ = triple.subject, triple.object
        if triple.predicate.value == _TYPE and isinstance(subject, ox.NamedNode) and isinstance(type_, ox.NamedNode):
            types.setdefault(type_.value, set()).add(subject.value)
    counts = {name: len(types.get(iri, ())) for name, iri in _COUNTED.items()}
    standard = tuple(STANDARD_PREFIXES[name] for name in ("rdf", "rdfs", "owl"))
    individuals = {s for iri, subjects in types.items() if not iri.startswith(standard) for s in subjects}
    return Inventory(
        document.path, document.iri, {**counts, "individuals": len(individuals), "statements": len(document.triples)}
    )
