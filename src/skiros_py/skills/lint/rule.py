"""Rules for plug-ins, and what they find."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import Any

from skiros_py.skills.lint.subject import Known, Subject


class Severity(StrEnum):
    """How bad it is to break a rule."""

    ERROR = "error"
    """It cannot work, or not as its author means it."""
    WARNING = "warning"
    """It may work, but is likely to surprise."""


@dataclass(frozen=True, slots=True)
class Spot:
    """A place in source code.

    Attributes:
        file: The file.
        line: 1-based line.
    """

    file: Path
    line: int

    def __str__(self) -> str:
        return f"{self.file}:{self.line}"


@dataclass(frozen=True, slots=True)
class Problem:
    """What is wrong with one thing that a rule looked at.

    Attributes:
        text: What is wrong, and what would be right.
        spot: Where; None for where the thing is defined.
    """

    text: str
    spot: Spot | None = None


@dataclass(frozen=True, slots=True)
class Finding:
    """A rule that something breaks.

    Attributes:
        rule: Name of the rule.
        severity: How bad that is.
        subject: What breaks it ("skill pick").
        text: What is wrong, and what would be right.
        spot: Where in the source, or None where that is not known.
    """

    rule: str
    severity: Severity
    subject: str
    text: str
    spot: Spot | None = None

    def __str__(self) -> str:
        where = f"{self.spot}: " if self.spot is not None else ""
        return f"{where}{self.rule}: {self.subject}: {self.text}"

    def as_json(self) -> dict[str, Any]:
        """Returns plain data."""
        return {
            "rule": self.rule,
            "severity": self.severity.value,
            "subject": self.subject,
            "text": self.text,
            "file": str(self.spot.file) if self.spot else None,
            "line": self.spot.line if self.spot else None,
        }


Check = Callable[[Subject, Known], Iterator[Problem]]
"""Yields what is wrong with a thing; nothing for things that the rule is not about."""

_PAGES = Path(__file__).parent / "pages"


@dataclass(frozen=True, slots=True)
class Rule:
    """One rule for plug-ins.

    Attributes:
        name: Its name ("unknown-word").
        severity: How bad it is to break it.
        summary: One line for people.
        check: What finds it; None where it shows only when a plug-in is loaded or run.
        disables: Whether a skill that breaks it is left out: it could only fail.
    """

    name: str
    severity: Severity
    summary: str
    check: Check | None = None
    disables: bool = False

    @property
    def page(self) -> str:
        """What there is to say about it, as Markdown, with an example that breaks it and one that does not."""
        return (_PAGES / f"{self.name}.md").read_text(encoding="utf-8")
