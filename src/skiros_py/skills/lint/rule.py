"""A rule: its name, how bad it is to break it, what finds that, and a page about it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

from skiros_py.skills.lint.finding import Problem, Severity
from skiros_py.skills.lint.subject import Known, Subject

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
