"""Ontologies of plug-ins may only add: statements about terms of others are refused.

A term belongs to the file that declares it: to the one whose ontology is the term's namespace, else to the first.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

import pyoxigraph as ox

from skiros_py.errors import FileError
from skiros_py.world.names import STANDARD_PREFIXES, Names, split_iri
from skiros_py.world.ontology.documents import Document

_RDF, _RDFS, _OWL = (STANDARD_PREFIXES[prefix] for prefix in ("rdf", "rdfs", "owl"))
_MEANINGFUL = (_RDF, _RDFS, _OWL, STANDARD_PREFIXES["sk"])
_NEUTRAL = frozenset(ox.NamedNode(_RDFS + name) for name in ("seeAlso", "isDefinedBy"))
_TEXTS = frozenset(ox.NamedNode(_RDFS + name) for name in ("label", "comment"))
_BOTH_WAYS = frozenset(
    ox.NamedNode(_OWL + name)
    for name in (
        "equivalentClass", "equivalentProperty", "disjointWith", "propertyDisjointWith", "sameAs", "differentFrom",
    )
)  # fmt: skip
_GROUPS = frozenset(ox.NamedNode(_OWL + name) for name in ("AllDisjointClasses", "AllDisjointProperties"))
_TYPE, _FIRST, _REST = (ox.NamedNode(_RDF + name) for name in ("type", "first", "rest"))
_ANNOTATION, _MEMBERS = ox.NamedNode(_OWL + "AnnotationProperty"), ox.NamedNode(_OWL + "members")


class Owners:
    """The file that each term and individual belongs to.

    Args:
        files: All files; those of the installation first.
    """

    def __init__(self, files: Sequence[Document]) -> None:
        self._owners: dict[ox.NamedNode, Document] = {}
        self._annotations: set[object] = set()
        for file in files:
            own = file.iri.rstrip("#/")
            for triple in file.triples:
                if triple.predicate == _TYPE and isinstance(triple.subject, ox.NamedNode):
                    if split_iri(triple.subject.value)[0].rstrip("#/") == own:
                        self._owners[triple.subject] = file
                    self._owners.setdefault(triple.subject, file)
                    if triple.object == _ANNOTATION:
                        self._annotations.add(triple.subject)

    def fault(self, files: Sequence[Document]) -> FileError | None:
        """Returns what is wrong with the files of one plug-in: the first statement about a term of others, or None."""
        foreign = {term: owner for term, owner in self._owners.items() if owner not in files}
        for file in files:
            for triple, term in self._about_terms(file):
                if (owner := foreign.get(term)) is not None and triple not in owner.triples:
                    return _refused(file, triple, term, owner)
        return None

    def _about_terms(self, file: Document) -> Iterator[tuple[ox.Triple, ox.NamedNode]]:
        """Yields the statements that change the meaning of a term, each with the term."""
        for triple in file.triples:
            if isinstance(triple.subject, ox.NamedNode) and not self._is_note(triple):
                yield triple, triple.subject
            if triple.predicate in _BOTH_WAYS and isinstance(triple.object, ox.NamedNode):
                yield triple, triple.object
        groups = {t.subject for t in file.triples if t.predicate == _TYPE and t.object in _GROUPS}
        if groups:
            yield from _members(file.triples, groups)

    def _is_note(self, triple: ox.Triple) -> bool:
        """Tells whether a statement is for people only: a translation, a link, an annotation of the plug-in's own."""
        if triple.predicate in _TEXTS:
            return isinstance(triple.object, ox.Literal) and triple.object.language not in (None, "en")
        if triple.predicate.value.startswith(_MEANINGFUL):
            return triple.predicate in _NEUTRAL
        return triple.predicate in self._annotations or triple.predicate not in self._owners


def _members(triples: Iterable[ox.Triple], groups: Iterable[object]) -> Iterator[tuple[ox.Triple, ox.NamedNode]]:
    """Yields the members of groups of disjoint terms, each with the statement that names its group."""
    links: dict[tuple[object, object], ox.Triple] = {
        (t.subject, t.predicate): t for t in triples if t.predicate in (_FIRST, _REST, _MEMBERS)
    }
    for group in groups:
        stated = link = links.get((group, _MEMBERS))
        while stated is not None and link is not None:
            first = links.get((link.object, _FIRST))
            if first is not None and isinstance(first.object, ox.NamedNode):
                yield stated, first.object
            link = links.get((link.object, _REST))


def _refused(file: Document, triple: ox.Triple, term: ox.NamedNode, owner: Document) -> FileError:
    names = Names(file.prefixes)
    match triple.object:
        case ox.NamedNode(value=iri):
            object_ = names.name(iri)
        case ox.Literal(value=text):
            object_ = text
        case _:
            object_ = "…"
    return file.fault(
        f"it states '{names.name(triple.predicate.value)} {object_}' about {names.name(term.value)}, which belongs to"
        f" {owner.path.name}: the ontology of a plug-in may add terms, not change those of others",
        triple.subject.value if isinstance(triple.subject, ox.NamedNode) else None,
        triple.predicate.value,
    )
