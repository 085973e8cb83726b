"""The ontologies behind prefixes."""

from __future__ import annotations

from collections.abc import Collection

from skiros_py.world.names import STANDARD_PREFIXES
from skiros_py.world.ontology import Ontology


def prefix_of(curie: str) -> str:
    """Returns the prefix of a name ("sk:Arm" is of "sk")."""
    return curie.partition(":")[0]


def prefix_table(ontology: Ontology, prefixes: Collection[str]) -> list[tuple[str, str]]:
    """Returns (prefix, IRI) of those prefixes that are not the same in every file, sorted."""
    return [(p, ontology.names.prefixes[p]) for p in sorted(set(prefixes) - set(STANDARD_PREFIXES))]


def declaring(ontology: Ontology, prefixes: Collection[str]) -> list[str]:
    """Returns the IRIs of the files that a file with words of some prefixes must import: the upper ontology first."""
    spaces = {iri for _, iri in prefix_table(ontology, prefixes)}
    own = sorted(file.iri for file in ontology.sources if {f"{file.iri}#", f"{file.iri}/"} & spaces)
    return ["https://w3id.org/skiros-py/core", *own]
