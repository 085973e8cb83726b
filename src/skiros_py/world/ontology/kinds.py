"""What a term may be declared as."""

from __future__ import annotations

from collections.abc import Mapping
from enum import StrEnum
from types import MappingProxyType

__all__ = ["DECLARES", "Kind"]


class Kind(StrEnum):
    """What a term may be declared as; the value is what people call it."""

    CLASS = "class"
    RELATION = "relation"
    PROPERTY = "property"
    ANNOTATION = "annotation property"
    DATATYPE = "data type"


DECLARES: Mapping[str, Kind] = MappingProxyType(
    {
        "owl:Class": Kind.CLASS,
        "rdfs:Class": Kind.CLASS,
        "owl:ObjectProperty": Kind.RELATION,
        # These can be of object properties only, and older tools write nothing else.
        "owl:InverseFunctionalProperty": Kind.RELATION,
        "owl:TransitiveProperty": Kind.RELATION,
        "owl:SymmetricProperty": Kind.RELATION,
        "owl:AsymmetricProperty": Kind.RELATION,
        "owl:ReflexiveProperty": Kind.RELATION,
        "owl:IrreflexiveProperty": Kind.RELATION,
        "owl:DatatypeProperty": Kind.PROPERTY,
        "owl:AnnotationProperty": Kind.ANNOTATION,
        "owl:OntologyProperty": Kind.ANNOTATION,
        "rdf:Property": Kind.ANNOTATION,
        "rdfs:Datatype": Kind.DATATYPE,
    }
)
"""What a type (CURIE) makes of a term."""
