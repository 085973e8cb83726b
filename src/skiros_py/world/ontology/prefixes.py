"""One prefix table for all files, in which every namespace with terms has a prefix."""

from __future__ import annotations

import re
from collections.abc import Container, Iterable, Sequence

import pyoxigraph as ox

from skiros_py.errors import FileError
from skiros_py.world.names import STANDARD_PREFIXES, Names, split_iri
from skiros_py.world.ontology.documents import Document

__all__ = ["common_names"]

_TYPE = ox.NamedNode(STANDARD_PREFIXES["rdf"] + "type")
_ONTOLOGY = ox.NamedNode(STANDARD_PREFIXES["owl"] + "Ontology")
_PREFIX = re.compile(r"[A-Za-z]([\w.-]*[\w-])?")
_MEANINGLESS = re.compile(r"v?\d[\d._-]*|ontolog(y|ies)|ontos?|owl|rdf|ns|schemas?|terms", re.IGNORECASE)


def common_names(files: Sequence[Document]) -> Names:
    """Returns the prefix table of all files together.

    - The empty prefix is private to its file.
    - Turtle is written by hand: two Turtle files that mean different things by one prefix are refused.
    - XML is written by tools, which number prefixes or call every ontology alike: what a Turtle file or an earlier XML
      file means by a prefix holds, and another namespace called so goes without.
    - A namespace with terms or individuals that goes without is called after the last word of its IRI that means
      something, in lower case, with a number if that is taken ("http://example.org/2024/Tools.owl#" -> ``tools:``).

    Raises:
        FileError: A prefix stands for two IRIs in Turtle files.
    """
    prefixes = dict(STANDARD_PREFIXES)
    for file in sorted(files, key=lambda file: not file.is_turtle):
        for prefix, iri in file.prefixes.items():
            if not _PREFIX.fullmatch(prefix) or not (file.is_turtle or iri.endswith(("#", "/", ":"))):
                continue
            if prefixes.setdefault(prefix, iri) != iri and file.is_turtle:
                said = f"prefix '{prefix}:' stands for <{iri}> here and for <{prefixes[prefix]}> elsewhere"
                raise FileError(file.path, said)
    for namespace in sorted(_namespaces(files) - set(prefixes.values())):
        prefixes[_made(namespace, prefixes)] = namespace
    return Names(prefixes)


def _namespaces(files: Iterable[Document]) -> set[str]:
    """The namespaces of everything that files give a type."""
    subjects = {
        triple.subject.value
        for file in files
        for triple in file.triples
        if triple.predicate == _TYPE and triple.object != _ONTOLOGY and isinstance(triple.subject, ox.NamedNode)
    }
    return {namespace for namespace, local in map(split_iri, subjects) if namespace and local}


def _made(namespace: str, taken: Container[str]) -> str:
    words = [re.sub(r"\.(owl|rdf|ttl|xml|owx)$", "", word) for word in re.split(r"[/#:]+", namespace) if word]
    word = next((word for word in reversed(words) if not _MEANINGLESS.fullmatch(word)), "")
    name = re.sub(r"[^a-z0-9]+", "_", word.lower()).strip("_")
    name = name if name[:1].isalpha() else f"ns{name}"
    number = 2
    unique = name
    while unique in taken:
        unique, number = f"{name}{number}", number + 1
    return unique
