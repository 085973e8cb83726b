"""Everything needs a help text, and numbers a unit."""

from __future__ import annotations

import inspect
from collections.abc import Iterator

from skiros_py.skills.conditions import ConditionType
from skiros_py.skills.lint.rule import Problem, Rule, Severity
from skiros_py.skills.lint.rules.words import own_params
from skiros_py.skills.lint.subject import Known, Source, Subject
from skiros_py.skills.skill import Skill, SkillDescription

_SHORTEST = 3
"""Shorter help texts are no help."""


def _unexplained(subject: Subject, known: Known) -> Iterator[Problem]:  # noqa: ARG001 - a check's signature
    match subject:
        case Skill() | Source():
            return
        case SkillDescription(help=help_) | ConditionType(help=help_):
            said = help_
        case _:
            said = _docstring(subject)
    if len(said.strip()) < _SHORTEST:
        yield Problem("say in one sentence what it is for")
    for param in own_params(subject):
        if len(param.help.strip()) < _SHORTEST:
            yield Problem(f"say in one sentence what parameter {param.key} is for")


def _docstring(class_: type) -> str:
    """Returns a class's own docstring, without the one that a dataclass writes by itself."""
    text = inspect.cleandoc(class_.__dict__.get("__doc__") or "")
    return "" if text.startswith(f"{class_.__name__}(") else text


def _without_unit(subject: Subject, known: Known) -> Iterator[Problem]:  # noqa: ARG001 - a check's signature
    for param in own_params(subject):
        if param.type in ("number", "vector") and not param.unit:
            yield Problem(
                f"say the unit of parameter {param.key}; a mere ratio has the unit '1', a count is an integer"
            )


MISSING_HELP = Rule("missing-help", Severity.ERROR, "Nothing says what it is for.", _unexplained)
MISSING_UNIT = Rule("missing-unit", Severity.ERROR, "A number whose unit nothing says.", _without_unit)
