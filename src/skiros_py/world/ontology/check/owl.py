"""The words of OWL, RDFS and RDF that the check speaks of, as IRIs."""

from __future__ import annotations

import rdflib

from skiros_py.world.names import CORE, STANDARD_PREFIXES
from skiros_py.world.ontology.kinds import DECLARES as KIND_BY_TYPE

__all__ = ["ANNOTATIONS", "DECLARES", "HEADER", "is_standard", "is_standard_word", "owl", "rdf", "rdfs", "sk"]

_STANDARD = {name: STANDARD_PREFIXES[name] for name in ("rdf", "rdfs", "owl", "xsd")}
_WORDS = {"rdf": rdflib.RDF, "rdfs": rdflib.RDFS, "owl": rdflib.OWL, "xsd": rdflib.XSD}


def owl(word: str) -> str:
    """Returns the IRI of a word of OWL."""
    return _STANDARD["owl"] + word


def rdf(word: str) -> str:
    """Returns the IRI of a word of RDF."""
    return _STANDARD["rdf"] + word


def rdfs(word: str) -> str:
    """Returns the IRI of a word of RDFS."""
    return _STANDARD["rdfs"] + word


def sk(word: str) -> str:
    """Returns the IRI of a word of the upper ontology."""
    return CORE + word


DECLARES = {_STANDARD[name.partition(":")[0]] + name.partition(":")[2]: kind for name, kind in KIND_BY_TYPE.items()}
"""What a type makes of a term."""

ANNOTATIONS = frozenset(
    {rdfs(w) for w in ("label", "comment", "seeAlso", "isDefinedBy")}
    | {owl(w) for w in ("versionInfo", "deprecated", "backwardCompatibleWith", "incompatibleWith", "priorVersion")}
)
"""Standard predicates that say nothing to a reasoner."""

HEADER = frozenset({owl("imports"), owl("versionIRI")})
"""Predicates of an ontology's own header."""


def is_standard(iri: str) -> bool:
    """Returns True for anything in a namespace of RDF, RDFS, OWL or XML Schema."""
    return any(iri.startswith(namespace) for namespace in _STANDARD.values())


def is_standard_word(iri: str) -> bool:
    """Returns True when the standard of its namespace knows the word."""
    for name, namespace in _STANDARD.items():
        if iri.startswith(namespace):
            word = iri.removeprefix(namespace)
            return word in _WORDS[name] or (name == "rdf" and word.startswith("_"))
    return False
