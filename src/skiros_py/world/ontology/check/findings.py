"""What the check says: one finding per fault, with where it stands and why it is one."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path

from skiros_py.errors import FileError


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
