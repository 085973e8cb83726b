"""What the check looks at, all files read together and indexed; and its findings, one per fault."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from functools import cached_property
from pathlib import Path

import pyoxigraph as ox
import rdflib

from skiros_py.errors import FileError
from skiros_py.world.names import CORE, STANDARD_PREFIXES, Names, split_iri
from skiros_py.world.ontology.documents import Document, common_names, rdf_files, read_document
from skiros_py.world.terms import DECLARES as KIND_BY_TYPE
from skiros_py.world.terms import Kind, closure, reached


class Severity(StrEnum):
    """How bad a finding is."""

    ERROR = "error"
    """The ontology is wrong: it cannot be used, or says something that cannot be."""
    WARNING = "warning"
    """It can be used; a person should look."""


class FindingKind(StrEnum):
    """What a finding is about."""

    UNREADABLE = "unreadable"
    """A file, or a declaration in it, cannot be understood."""
    UNDECLARED = "undeclared"
    """A term is used that no file declares."""
    WRONG_KIND = "wrong-kind"
    """A term is used, or declared twice, as something else than it is."""
    DOMAIN = "domain"
    """A domain is no class, or a subject is not of it."""
    RANGE = "range"
    """A range is no class or data type, or an object or value is not of it."""
    CYCLE = "cycle"
    """Something is above, part of or placed in itself."""
    DEPTH = "depth"
    """A term has too many above it."""
    PLACEMENT = "placement"
    """A placement relation does not say which end is the place."""
    PARENT = "parent"
    """A class names a primary parent that is none of its superclasses."""
    UNSATISFIABLE = "unsatisfiable"
    """A class that nothing can ever be of."""
    INCONSISTENT = "inconsistent"
    """Statements that cannot all be true."""
    IMPORT = "import"
    """An imported ontology is not at hand."""
    UNEXPLAINED = "unexplained"
    """A term has no label or no comment."""
    REASONER = "reasoner"
    """A reasoner could not answer."""


@dataclass(frozen=True, slots=True)
class Finding:
    """One thing that is wrong, or that a person should look at.

    Attributes:
        severity: How bad it is.
        kind: What it is about.
        term: The term it is about, as CURIE, or the IRI of a file's ontology.
        text: What is wrong and what would be right.
        file: The file that says it, or None if none says it alone.
        line: 1-based line in it, or None if it has none.
        explanation: The statements that together make it so, in words, each with its file and line.
    """

    severity: Severity
    kind: FindingKind
    term: str
    text: str
    file: Path | None = None
    line: int | None = None
    explanation: tuple[str, ...] = ()

    @property
    def is_error(self) -> bool:
        """True when the ontology is wrong."""
        return self.severity is Severity.ERROR


def finding_of(
    fault: FileError, kind: FindingKind, term: str, *, severity: Severity = Severity.ERROR, why: tuple[str, ...] = ()
) -> Finding:
    """Makes a finding of a fault that was or could have been raised."""
    return Finding(severity, kind, term, fault.reason, fault.path, fault.line, why)


def in_order(findings: list[Finding]) -> tuple[Finding, ...]:
    """Returns the findings each once: errors first, then by file and line."""
    return tuple(sorted(set(findings), key=_order))


def _order(finding: Finding) -> tuple[object, ...]:
    return (not finding.is_error, str(finding.file or ""), finding.line or 0, finding.kind, finding.term, finding.text)


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
    """Returns True when the standard of its namespace defines the word."""
    for name, namespace in _STANDARD.items():
        if iri.startswith(namespace):
            word = iri.removeprefix(namespace)
            return word in _WORDS[name] or (name == "rdf" and word.startswith("_"))
    return False


# ---------------------------------------------------------------- the files of a check


@dataclass(frozen=True, slots=True)
class Statement:
    """One triple and the file that says it."""

    document: Document
    triple: ox.Triple

    @property
    def subject(self) -> str | None:
        """IRI of the subject, or None if it is anonymous."""
        return iri_of(self.triple.subject)

    @property
    def predicate(self) -> str:
        """IRI of the predicate."""
        return str(self.triple.predicate.value)

    @property
    def object(self) -> str | None:
        """IRI of the object, or None if it is anonymous or a literal."""
        return iri_of(self.triple.object)

    def fault(self, reason: str, at: str | None = None) -> FileError:
        """Makes the fault of this statement, at an IRI in it (else at its predicate)."""
        return self.document.fault(reason, self.subject or at, at or self.predicate)


@dataclass(frozen=True)
class Material:
    """The files of one check.

    Attributes:
        documents: Those that could be read.
        names: Their prefixes.
    """

    documents: Sequence[Document]
    names: Names

    @cached_property
    def statements(self) -> tuple[Statement, ...]:
        """Every statement, in file order."""
        return tuple(Statement(document, triple) for document in self.documents for triple in document.triples)

    @cached_property
    def by_predicate(self) -> Mapping[str, Sequence[Statement]]:
        """The statements of a predicate (IRI), in file order."""
        found: dict[str, list[Statement]] = defaultdict(list)
        for statement in self.statements:
            found[statement.predicate].append(statement)
        return found

    @cached_property
    def _by_subject(self) -> Mapping[tuple[str | None, str], Sequence[Statement]]:
        found: dict[tuple[str | None, str], list[Statement]] = defaultdict(list)
        for statement in self.statements:
            found[statement.subject, statement.predicate].append(statement)
        return found

    @cached_property
    def declared(self) -> Mapping[Kind, Mapping[str, Document]]:
        """Terms (IRIs) of each kind, with the file that declares each first."""
        found: dict[Kind, dict[str, Document]] = {kind: {} for kind in Kind}
        for statement in self.about(rdf("type")):
            kind = DECLARES.get(statement.object or "")
            if kind is not None and statement.subject is not None:
                found[kind].setdefault(statement.subject, statement.document)
        return found

    @cached_property
    def vocabularies(self) -> frozenset[str]:
        """Namespaces of which some file declares something."""
        return frozenset(split_iri(term)[0] for terms in self.declared.values() for term in terms)

    @cached_property
    def parents(self) -> Mapping[str, Sequence[str]]:
        """The named classes directly above each class: superclasses, equivalents, and the parts of intersections."""
        found: dict[str, list[str]] = defaultdict(list)
        for word in rdfs("subClassOf"), owl("equivalentClass"):
            for statement in self.about(word):
                if statement.subject is not None:
                    found[statement.subject].extend(self._parts(statement.triple.object))
        for one, other in self.pairs(owl("equivalentClass")):
            found[other].append(one)
        return found

    @cached_property
    def types(self) -> Mapping[str, Sequence[str]]:
        """The declared classes of each named individual."""
        found: dict[str, list[str]] = defaultdict(list)
        for one, type_ in self.pairs(rdf("type")):
            if type_ in self.declared[Kind.CLASS]:
                found[one].append(type_)
        return found

    def about(self, predicate: str) -> Sequence[Statement]:
        """Returns the statements of a predicate (IRI)."""
        return self.by_predicate.get(predicate, ())

    def said(self, subject: str, predicate: str) -> Sequence[Statement]:
        """Returns the statements of a predicate about a subject (IRIs)."""
        return self._by_subject.get((subject, predicate), ())

    def pairs(self, predicate: str) -> Iterator[tuple[str, str]]:
        """Yields subject and object of a predicate where both have names."""
        for statement in self.about(predicate):
            if statement.subject is not None and statement.object is not None:
                yield statement.subject, statement.object

    def kinds_of(self, iri: str) -> tuple[Kind, ...]:
        """Returns all that a term is declared as."""
        return tuple(kind for kind in Kind if iri in self.declared[kind])

    def declared_at(self, iri: str) -> Document:
        """Returns the file that declares a term first."""
        return next(terms[iri] for terms in self.declared.values() if iri in terms)

    def is_term(self, iri: str) -> bool:
        """Returns True for what is declared as a class, relation, property or data type."""
        return any(iri in terms for terms in self.declared.values())

    def ancestors(self, class_: str) -> frozenset[str]:
        """Returns a class and all named classes above it."""
        return frozenset(closure(self.parents, class_))

    def _parts(self, node: object) -> list[str]:
        """The named classes that all of a class expression are of."""
        parts = reached([node], lambda part: self.members(self._intersections.get(part)))
        return [part.value for part in parts if isinstance(part, ox.NamedNode)]

    @cached_property
    def _intersections(self) -> Mapping[object, object]:
        """The list of each anonymous intersection."""
        return self._objects(owl("intersectionOf"))

    def members(self, node: object) -> tuple[object, ...]:
        """Returns the members of an RDF list."""
        cells = reached([node], lambda cell: filter(None, [self._rest.get(cell)]))
        return tuple(self._first[cell] for cell in cells if cell in self._first)

    @cached_property
    def _first(self) -> Mapping[object, object]:
        return self._objects(rdf("first"))

    @cached_property
    def _rest(self) -> Mapping[object, object]:
        return self._objects(rdf("rest"))

    def _objects(self, predicate: str) -> dict[object, object]:
        """The object by subject; no two files share an anonymous node."""
        return {statement.triple.subject: statement.triple.object for statement in self.about(predicate)}


def read_material(paths: Iterable[Path]) -> tuple[Material, list[Finding]]:
    """Reads all files (of a folder: all below it) and says which could not be read."""
    documents: list[Document] = []
    findings: list[Finding] = []
    for path in rdf_files(paths):
        try:
            documents.append(read_document(path))
        except FileError as fault:
            findings.append(finding_of(fault, FindingKind.UNREADABLE, path.name))
    try:
        names = common_names(documents)
    except FileError as fault:
        findings.append(finding_of(fault, FindingKind.UNREADABLE, fault.path.name))
        names = _first_wins(documents)
    return Material(documents, names), [*findings, *_twins(documents), *_absent_imports(documents)]


def iri_of(node: object) -> str | None:
    """Returns the IRI of a named node, else None."""
    return node.value if isinstance(node, ox.NamedNode) else None


def _first_wins(documents: Sequence[Document]) -> Names:
    prefixes: dict[str, str] = {}
    for document in documents:
        for prefix, iri in document.prefixes.items():
            if prefix:
                prefixes.setdefault(prefix, iri)
    return Names(prefixes)


def _twins(documents: Sequence[Document]) -> Iterator[Finding]:
    by_iri: dict[str, Document] = {}
    for document in documents:
        first = by_iri.setdefault(document.iri, document)
        if first is not document:
            fault = document.fault(f"declares ontology <{document.iri}>, as {first.path} does", document.iri)
            yield finding_of(fault, FindingKind.UNREADABLE, document.iri)


def _absent_imports(documents: Sequence[Document]) -> Iterator[Finding]:
    at_hand = {document.iri for document in documents}
    for document in documents:
        for iri in document.imports():
            if iri not in at_hand:
                reason = f"imports <{iri}>, which none of the files at hand is; nothing is fetched from the network"
                fault = document.fault(reason, document.iri, iri)
                yield finding_of(fault, FindingKind.IMPORT, document.iri, severity=Severity.WARNING)
