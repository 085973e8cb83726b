"""The one place where IRIs are spelt: prefix table, CURIE <-> IRI, and the bare names of scene individuals."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import NewType

from skiros_py.errors import UnknownName

CORE = "https://w3id.org/skiros-py/core#"
"""Namespace of the upper ontology (prefix ``sk:``)."""

SCENE = "https://w3id.org/skiros-py/scene#"
"""Namespace of scene individuals, which Python names by their bare local name ("starter_1")."""

SCENE_GRAPH = "https://w3id.org/skiros-py/scene"
"""Name of the graph that holds the scene."""

LEARNED = "https://w3id.org/skiros-py/learned#"
"""Namespace of what robots were taught (prefix ``learned:``)."""

LEARNED_GRAPH = "https://w3id.org/skiros-py/learned"
"""Name of the graph that holds it."""

STANDARD_PREFIXES: Mapping[str, str] = MappingProxyType(
    {
        "rdf": "http://www.w3.org/1999/02/22-rdf-syntax-ns#",
        "rdfs": "http://www.w3.org/2000/01/rdf-schema#",
        "owl": "http://www.w3.org/2002/07/owl#",
        "xsd": "http://www.w3.org/2001/XMLSchema#",
        "sk": CORE,
        "scene": SCENE,
        "learned": LEARNED,
    }
)
"""Prefixes that mean the same in every file."""


def local_name(curie: str) -> str:
    """Returns a CURIE without its prefix ("kitting:Starter" -> "Starter")."""
    return curie.rpartition(":")[2]


def split_iri(iri: str) -> tuple[str, str]:
    """Returns an IRI's namespace, up to its last ``#`` or ``/`` (where it has none, ``:``), and what follows."""
    cut = max(iri.rfind("#"), iri.rfind("/")) + 1 or iri.rfind(":") + 1
    return iri[:cut], iri[cut:]


class Names:
    """A fixed prefix table and the translations it allows.

    Attributes:
        prefixes: IRI by prefix.
    """

    def __init__(self, prefixes: Mapping[str, str]) -> None:
        self.prefixes = MappingProxyType({**STANDARD_PREFIXES, **prefixes})
        # Reversed, so that the prefix declared first wins where one IRI has two.
        self._by_namespace = {iri: prefix for prefix, iri in reversed(list(self.prefixes.items()))}

    def iri(self, name: str) -> str:
        """Returns the IRI of a CURIE or of a bare scene name.

        Raises:
            UnknownName: No file declares the prefix.
        """
        prefix, colon, local = name.partition(":")
        if not colon:
            return SCENE + name
        if prefix not in self.prefixes:
            raise UnknownName("prefix", prefix, self.prefixes, where=f"in '{name}'")
        return self.prefixes[prefix] + local

    def name(self, iri: str) -> str:
        """Returns the bare name of a scene individual, the CURIE of anything else, or the IRI where no prefix fits."""
        namespace, local = split_iri(iri)
        if namespace == SCENE:
            return local
        prefix = self._by_namespace.get(namespace)
        return f"{prefix}:{local}" if prefix is not None and local else iri

    def __reduce__(self) -> tuple[type[Names], tuple[dict[str, str]]]:
        return Names, (dict(self.prefixes),)


# ---------------------------------------------------------------- types of ontology terms


ClassName = NewType("ClassName", str)
"""CURIE of a class ("kitting:Starter")."""

RelationName = NewType("RelationName", str)
"""CURIE of a relation between elements ("sk:heldBy")."""

PropertyName = NewType("PropertyName", str)
"""CURIE of a property of elements ("sk:mass")."""

IndividualName = NewType("IndividualName", str)
"""CURIE of an individual that an ontology describes."""
