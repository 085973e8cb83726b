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
from skiros_py.world.ontology.check.owl_reasoner import HermiT, NoAnswer, NotStarted, OwlReasoner, OwlRlProcess, java
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
    name, note = None, "no reasoning was asked for"
    if any(finding.kind in _NO_REASONING for finding in findings) and reasoner != "none":
        note = "the structure has errors"
        findings.append(_silence("no reasoner was asked: fix the cycles and depths of the hierarchies first"))
    elif reasoner != "none" and not has_extra("ontology"):
        note = "no reasoner is installed"
        findings.append(_silence(str(MissingExtra("ontology", "reasoning"))))
    elif reasoner != "none":
        name, note, found = _first_answer(material, reasoner, program, time_limit, progress)
        findings += found
    seconds = time.monotonic() - start
    findings += _refusal(paths, findings)
    files = tuple(document.path for document in material.documents)
    return CheckReport(files, in_order(findings), name, note, seconds)


def _java(asked: ReasonerChoice) -> str | None:
    """Returns the path of ``java`` if it may be used."""
    if asked in ("hermit", "owl-rl"):
        require_extra("ontology", f"--reasoner {asked}")
    program = java()
    if asked == "hermit" and program is None:
        raise UsageError("--reasoner hermit needs Java, and there is no 'java' on PATH; 'owl-rl' needs none")
    return program if asked in ("auto", "hermit") else None


def _silence(text: str, severity: Severity = Severity.WARNING) -> Finding:
    return Finding(severity, FindingKind.REASONER, "", text)


def _first_answer(
    material: Material, asked: ReasonerChoice, program: str | None, time_limit: float, progress: Callable[[str], None]
) -> tuple[str | None, str, list[Finding]]:
    """Asks the reasoners in order until one answers; returns its name, why it was chosen, and the findings."""
    if asked != "auto":
        note = "as asked for"
    else:
        note = "Java is there" if program is not None else "no Java: contradictions that need a choice are not seen"
    silences: list[Finding] = []
    with OwlRlProcess(time_limit) as owl_rl:
        for choice in _choices(asked, program, time_limit, owl_rl):
            progress(f"reasoning with {choice.name}")
            try:
                found = logical_findings(material, choice, [owl_rl] if choice.is_complete else [])
            except NoAnswer as answer:
                # A user who requests only the complete reasoner wants certainty, which the other cannot give.
                silences.append(_silence(str(answer), Severity.ERROR if asked == "hermit" else Severity.WARNING))
                note = f"{choice.name} {'does not start' if isinstance(answer, NotStarted) else 'gave no answer'}"
            else:
                return choice.name, note, [*silences, *found]
    return None, "; ".join(finding.text for finding in silences), silences


def _choices(
    asked: ReasonerChoice, program: str | None, time_limit: float, owl_rl: OwlReasoner
) -> Iterator[OwlReasoner]:
    """The reasoners to try, in order; the time of each starts with its turn."""
    if program is not None:
        yield HermiT(program, time.monotonic() + time_limit)
    if asked != "hermit":
        yield owl_rl


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
