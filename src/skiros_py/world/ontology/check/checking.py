"""The whole check: read, look at the structure, let a reasoner judge, and try whether the world model takes it."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from skiros_py.errors import FileError, UsageError
from skiros_py.world.ontology.check.findings import Finding, FindingKind, Severity, finding_of, in_order
from skiros_py.world.ontology.check.hermit import HermiT, java
from skiros_py.world.ontology.check.logic import NoAnswer, Reasoner
from skiros_py.world.ontology.check.material import Material, read_material
from skiros_py.world.ontology.check.structure import structural_findings
from skiros_py.world.ontology.documents import rdf_files
from skiros_py.world.ontology.ontology import Ontology

__all__ = ["CheckReport", "ReasonerChoice", "check_ontology"]

ReasonerChoice = Literal["auto", "hermit", "owl-rl", "none"]


@dataclass(frozen=True, slots=True)
class CheckReport:
    """What a check found.

    Attributes:
        files: The files that were read.
        findings: What is wrong: errors first, then by file and line.
        reasoner: Name of the reasoner that judged the files, or None where none did.
        note: Why it was this one.
        seconds: How long reasoning took [s].
    """

    files: tuple[Path, ...]
    findings: tuple[Finding, ...]
    reasoner: str | None
    note: str
    seconds: float

    @property
    def errors(self) -> int:
        """How many findings say that the ontology is wrong."""
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
        reasoner: ``hermit`` needs Java; ``auto`` takes it where there is Java, else (or where it gives no answer)
            the OWL-RL reasoner, which sees less.
        time_limit: Time for each reasoner [s]; what the OWL-RL one has begun, it ends.
        progress: Told what is being done.

    Raises:
        UsageError: There is no file, or HermiT was asked for and there is no Java.
    """
    if not rdf_files(paths):
        raise UsageError(f"there is no ontology file below {', '.join(map(str, paths)) or 'nothing'}")
    choices = _choices(reasoner, time_limit)
    progress("reading")
    material, findings = read_material(paths)
    findings += structural_findings(material)
    judged = _Judged(None, "no reasoning was asked for", [])
    start = time.monotonic()
    for number, choice in enumerate(choices):
        progress(f"reasoning with {choice.name}")
        judged = _judge(material, choice, _helpers(choice, time_limit), is_last=number == len(choices) - 1)
        findings += judged.findings
        if judged.reasoner is not None:
            break
    seconds = time.monotonic() - start
    findings += _refusal(paths, findings)
    note = judged.note or _why(reasoner, choices, judged)
    files = tuple(document.path for document in material.documents)
    return CheckReport(files, in_order(findings), judged.reasoner, note, seconds)


@dataclass(frozen=True, slots=True)
class _Judged:
    reasoner: str | None
    note: str
    findings: list[Finding]


def _choices(asked: ReasonerChoice, time_limit: float) -> list[Reasoner]:
    """The reasoners to try, in order."""
    program = java()
    if asked == "hermit" and program is None:
        raise UsageError("--reasoner hermit needs Java, and there is no 'java' on PATH; 'owl-rl' needs none")
    deadline = time.monotonic() + time_limit
    chosen: list[Reasoner] = []
    if asked in ("auto", "hermit") and program is not None:
        chosen.append(HermiT(program, deadline))
    if asked in ("auto", "owl-rl"):
        chosen.append(_owl_rl(time_limit))
    return chosen


def _helpers(choice: Reasoner, time_limit: float) -> list[Reasoner]:
    return [_owl_rl(time_limit)] if choice.is_complete else []


def _owl_rl(time_limit: float) -> Reasoner:
    from skiros_py.world.ontology.check.owl_rl import OwlRl  # rdflib takes its time

    return OwlRl(time.monotonic() + time_limit)


def _judge(material: Material, reasoner: Reasoner, helpers: Sequence[Reasoner], *, is_last: bool) -> _Judged:
    from skiros_py.world.ontology.check.reasoning import logical_findings

    try:
        return _Judged(reasoner.name, "", logical_findings(material, reasoner, helpers))
    except NoAnswer as answer:
        severity = Severity.ERROR if is_last else Severity.WARNING
        return _Judged(None, str(answer), [Finding(severity, FindingKind.REASONER, "", str(answer))])


def _why(asked: ReasonerChoice, choices: Sequence[Reasoner], judged: _Judged) -> str:
    if asked != "auto":
        return "as asked for"
    if judged.reasoner == choices[0].name and choices[0].is_complete:
        return "Java is there"
    return (
        "HermiT gave no answer" if choices[0].is_complete else "no Java: contradictions that need a choice are not seen"
    )


def _refusal(paths: Sequence[Path], findings: Sequence[Finding]) -> Iterator[Finding]:
    """What the world model would say when it loads the files, unless it was said already."""
    if any(finding.is_error for finding in findings):
        return
    try:
        Ontology.load(paths)
    except FileError as fault:
        yield finding_of(fault, FindingKind.UNREADABLE, fault.path.name)
