"""The subject of a check: all files read together and indexed; and its findings, one per fault."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from functools import cached_property
from pathlib import Path

import pyoxigraph as ox

from skiros_py.errors import FileError
from skiros_py.world.names import Names
from skiros_py.world.ontology.documents import Document, common_names, rdf_files, read_document
from skiros_py.world.ontology.imports import with_imports
from skiros_py.world.ontology.statements import Statement, Statements, is_standard
from skiros_py.world.terms import Kind, closure


class Severity(StrEnum):
    """Severity of a finding."""

    ERROR = "error"
    """The ontology cannot be used, or contradicts itself."""
    WARNING = "warning"
    """It can be used, but a person should look at it."""


class FindingKind(StrEnum):
    """Kinds of findings."""

    UNREADABLE = "unreadable"
    """A file, or a declaration in it, cannot be understood."""
    UNDECLARED = "undeclared"
    """A term is used that no file declares."""
    WRONG_KIND = "wrong-kind"
    """A term is used as another kind than declared, or declared as two kinds."""
    DOMAIN = "domain"
    """A domain is no class, or a subject does not fit it."""
    RANGE = "range"
    """A range is no class or data type, or an object or value does not fit it."""
    CYCLE = "cycle"
    """Something is above, part of or placed in itself, directly or indirectly."""
    DEPTH = "depth"
    """A term has too many above it."""
    PLACEMENT = "placement"
    """A placement relation does not declare which end is the place."""
    PARENT = "parent"
    """The primary parent of a class is none of its superclasses."""
    UNSATISFIABLE = "unsatisfiable"
    """A class cannot have individuals."""
    INCONSISTENT = "inconsistent"
    """Statements that cannot all be true."""
    IMPORT = "import"
    """An imported ontology is missing."""
    UNEXPLAINED = "unexplained"
    """A term has no label or no comment."""
    REASONER = "reasoner"
    """A reasoner found no answer."""


@dataclass(frozen=True, slots=True)
class Finding:
    """One fault, or something that a person should look at.

    Attributes:
        severity: Its severity.
        kind: Its kind.
        term: The term in question, as CURIE, or the IRI of a file's ontology.
        text: The fault and how to fix it.
        file: The file with the fault, or None if it is in no single file.
        line: 1-based line in it, or None if unknown.
        explanation: The statements that together cause it, as sentences, each with its file and line.
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
        """True if it is an error."""
        return self.severity is Severity.ERROR


def finding_of(
    fault: FileError, kind: FindingKind, term: str, *, severity: Severity = Severity.ERROR, why: tuple[str, ...] = ()
) -> Finding:
    """Makes a finding of an error."""
    return Finding(severity, kind, term, fault.reason, fault.path, fault.line, why)


def in_order(findings: list[Finding]) -> tuple[Finding, ...]:
    """Returns the findings without duplicates: errors first, then by file and line."""
    return tuple(
        sorted(set(findings), key=lambda f: (not f.is_error, str(f.file or ""), f.line or 0, f.kind, f.term, f.text))
    )


ANNOTATIONS = frozenset(
    {"rdfs:label", "rdfs:comment", "rdfs:seeAlso", "rdfs:isDefinedBy"}
    | {"owl:versionInfo", "owl:deprecated", "owl:backwardCompatibleWith", "owl:incompatibleWith", "owl:priorVersion"}
)
"""Standard predicates without meaning for a reasoner."""

HEADER = frozenset({"owl:imports", "owl:versionIRI"})
"""Predicates of an ontology's own header."""


# ---------------------------------------------------------------- the files of a check


class Material(Statements):
    """The files of one check that could be read.

    Attributes:
        sought: The terms that no file declares, and a missing import may.
    """

    def __init__(self, documents: Sequence[Document], names: Names) -> None:
        super().__init__(documents, names)
        self.sought: set[str] = set()

    def is_sought(self, name: str) -> bool:
        """Returns whether a missing import may declare a name, which is noted."""
        sought = bool(self.absent) and not self.kinds(name) and not is_standard(name)
        self.sought |= {name} if sought else set()
        return sought

    @cached_property
    def parents(self) -> Mapping[str, Sequence[str]]:
        """The named classes directly above each class: superclasses, equivalents, and the parts of intersections."""
        found: dict[str, list[str]] = defaultdict(list)
        for word in "rdfs:subClassOf", "owl:equivalentClass":
            for statement in self.of(word):
                if statement.subject is not None:
                    parts = self.conjuncts(statement.triple.object)
                    found[statement.subject] += [self.key(part) for part in parts if isinstance(part, ox.NamedNode)]
        for one, other in self.pairs("owl:equivalentClass"):
            found[other].append(one)
        return found

    @cached_property
    def types(self) -> Mapping[str, Sequence[str]]:
        """The declared classes of each named individual."""
        found: dict[str, list[str]] = defaultdict(list)
        for one, type_ in self.pairs("rdf:type"):
            if type_ in self.declared[Kind.CLASS]:
                found[one].append(type_)
        return found

    def ancestors(self, class_: str) -> frozenset[str]:
        """Returns a class and all named classes above it."""
        return frozenset(closure(self.parents, class_))

    def at_declaration(self, term: str, reason: str, at: str | None = None) -> FileError:
        """Makes the error for a fault of a term as a whole, where it is declared first."""
        return self.declared[self.kinds(term)[0]][term].fault(reason, self.iri(term), self.iri(at))

    def finding(
        self,
        statement: Statement,
        kind: FindingKind,
        term: str,
        text: str,
        at: str | None = None,
        *,
        severity: Severity = Severity.ERROR,
    ) -> Finding:
        """Makes a finding about a term, located in a statement at a name in it (by default, its predicate)."""
        return finding_of(self.fault_in(statement, text, at), kind, term, severity=severity)


def read_material(paths: Iterable[Path]) -> tuple[Material, list[Finding]]:
    """Reads all files (of a folder: all below it) and those they import; which cannot be read become findings."""
    documents: list[Document] = []
    findings: list[Finding] = []
    for path in rdf_files(paths):
        try:
            documents.append(read_document(path))
        except FileError as fault:
            findings.append(finding_of(fault, FindingKind.UNREADABLE, path.name))
    try:
        documents = with_imports(documents)
        names = common_names(documents)
    except FileError as fault:
        findings.append(finding_of(fault, FindingKind.UNREADABLE, fault.path.name))
        names = Names({p: iri for one in documents[::-1] for p, iri in one.prefixes.items() if p})  # the first counts
    return Material(documents, names), [*findings, *_twins(documents)]


def _twins(documents: Sequence[Document]) -> Iterator[Finding]:
    by_iri: dict[str, Document] = {}
    for document in documents:
        first = by_iri.setdefault(document.iri, document)
        if first is not document:
            fault = document.fault(f"declares ontology <{document.iri}>, as {first.path} does", document.iri)
            yield finding_of(fault, FindingKind.UNREADABLE, document.iri)
