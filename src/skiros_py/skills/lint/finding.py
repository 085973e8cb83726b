"""What a rule found."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import Any


class Severity(StrEnum):
    """How bad it is to break a rule."""

    ERROR = "error"
    """It cannot work, or not as its author means it."""
    WARNING = "warning"
    """It may work, and will surprise somebody."""


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
