"""The whole check: parsing, structure, reasoning, and a trial of loading the files into the world model."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from skiros_py.errors import FileError, MissingExtra, UsageError
from skiros_py.system import has_extra, require_extra
from skiros_py.world.abstract import abstract_individuals
from skiros_py.world.ontology.check.material import (
    Finding,
    FindingKind,
    Material,
    Severity,
    finding_of,
    in_order,
    read_material,
)
from skiros_py.world.ontology.check.reasoner import HermiT, NoAnswer, NotStarted, OwlRlProcess, Reasoner, java
from skiros_py.world.ontology.check.reasoning import logical_findings
from skiros_py.world.ontology.check.structure import structural_findings
from skiros_py.world.ontology.documents import rdf_files
from skiros_py.world.ontology.ontology import Ontology
from skiros_py.world.reasoners.registry import NO_REASONERS
from skiros_py.world.vocabulary import ELEMENT

ReasonerChoice = Literal["auto", "hermit", "owl-rl", "none"]

_NO_REASONING = frozenset({FindingKind.CYCLE, FindingKind.DEPTH})
"""Findings that make reasoners run out of time and memory, and their answers useless."""


@dataclass(frozen=True, slots=True)
class CheckReport:
    """The result of a check.

    Attributes:
        files: The files that were read.
        findings: The findings: errors first, then by file and line.
        reasoner: Name of the reasoner that checked the files, or None.
        note: Why it was chosen.
        seconds: How long reasoning took [s].
    """

    files: tuple[Path, ...]
    findings: tuple[Finding, ...]
    reasoner: str | None
    note: str
    seconds: float

    @property
    def errors(self) -> int:
        """Number of findings that are errors."""
        return sum(finding.is_error for finding in self.findings)


def check_ontology(
    paths: Sequence[Path],
    reasoner: ReasonerChoice = "auto",
    time_limit: float = 60.0,
    progress: Callable[[str], None] = lambda _: None,
) -> CheckReport:
    """Checks ontology files (of a folder: all below it) together.

    Args:
        paths: Files and folders.
        reasoner: ``hermit`` needs Java; ``auto`` uses it if there is Java, else (or if it gives no answer) the OWL-RL
            reasoner, which is incomplete.
        time_limit: Time limit of each reasoner [s].
        progress: Called with a description of each step.

    Raises:
        UsageError: There is no file, or HermiT was requested and there is no Java.
    """
    if not rdf_files(paths):
        raise UsageError(f"there is no ontology file below {', '.join(map(str, paths)) or 'nothing'}")
    program = _java(reasoner)
    progress("reading")
    material, findings = read_material(paths)
    findings += structural_findings(material)
    start = time.monotonic()
    judged = _reasoned(material, findings, _Asked(reasoner, program, time_limit, progress))
    seconds = time.monotonic() - start
    findings += judged.findings
    findings += _refusal(paths, findings)
    files = tuple(document.path for document in material.documents)
    return CheckReport(files, in_order(findings), judged.reasoner, judged.note, seconds)


@dataclass(frozen=True, slots=True)
class _Asked:
    """The requested reasoning; the path of ``java`` if it may be used."""

    choice: ReasonerChoice
    java: str | None
    time_limit: float
    progress: Callable[[str], None]


@dataclass(frozen=True, slots=True)
class _Judged:
    reasoner: str | None
    note: str
    findings: list[Finding]


def _java(asked: ReasonerChoice) -> str | None:
    if asked in ("hermit", "owl-rl"):
        require_extra("ontology", f"--reasoner {asked}")
    program = java()
    if asked == "hermit" and program is None:
        raise UsageError("--reasoner hermit needs Java, and there is no 'java' on PATH; 'owl-rl' needs none")
    return program if asked in ("auto", "hermit") else None


def _reasoned(material: Material, findings: Sequence[Finding], asked: _Asked) -> _Judged:
    """Tries the reasoners in order until one gives an answer; none if the structure has errors."""
    if asked.choice == "none":
        return _Judged(None, "no reasoning was asked for", [])
    if any(finding.kind in _NO_REASONING for finding in findings):
        text = "no reasoner was asked: fix the cycles and depths of the hierarchies first"
        return _Judged(None, "the structure has errors", [_silence(text)])
    if not has_extra("ontology"):
        return _Judged(None, "no reasoner is installed", [_silence(str(MissingExtra("ontology", "reasoning")))])
    with OwlRlProcess(asked.time_limit) as owl_rl:
        return _first_answer(material, _choices(asked, owl_rl), owl_rl, asked)


def _silence(text: str) -> Finding:
    return Finding(Severity.WARNING, FindingKind.REASONER, "", text)


def _choices(asked: _Asked, owl_rl: Reasoner) -> Iterator[Reasoner]:
    """The reasoners to try, in order; the time of each starts with its turn."""
    if asked.java is not None:
        yield HermiT(asked.java, time.monotonic() + asked.time_limit)
    if asked.choice != "hermit":
        yield owl_rl


def _first_answer(material: Material, choices: Iterator[Reasoner], owl_rl: Reasoner, asked: _Asked) -> _Judged:
    silences: list[Finding] = []
    note = _why(asked)
    for choice in choices:
        asked.progress(f"reasoning with {choice.name}")
        try:
            found = logical_findings(material, choice, [owl_rl] if choice.is_complete else [])
        except NoAnswer as answer:
            # A user who requests only the complete reasoner wants certainty, which the other cannot give.
            severity = Severity.ERROR if asked.choice == "hermit" else Severity.WARNING
            silences.append(Finding(severity, FindingKind.REASONER, "", str(answer)))
            note = f"{choice.name} {'does not start' if isinstance(answer, NotStarted) else 'gave no answer'}"
        else:
            return _Judged(choice.name, note, [*silences, *found])
    return _Judged(None, "; ".join(finding.text for finding in silences), silences)


def _why(asked: _Asked) -> str:
    """Returns why the first reasoner is chosen."""
    if asked.choice != "auto":
        return "as asked for"
    return "Java is there" if asked.java is not None else "no Java: contradictions that need a choice are not seen"


def _refusal(paths: Sequence[Path], findings: Sequence[Finding]) -> Iterator[Finding]:
    """The error of the world model when it loads the files, if no error was found before."""
    if any(finding.is_error for finding in findings):
        return
    try:
        ontology = Ontology.load(paths)
        if ELEMENT in ontology.classes:
            abstract_individuals(ontology, NO_REASONERS)
    except FileError as fault:
        yield finding_of(fault, FindingKind.UNREADABLE, fault.path.name)
