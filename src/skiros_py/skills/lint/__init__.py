"""Rules for plug-ins: what is wrong with a skill, a primitive or a condition, before it is offered to anybody."""

from skiros_py.skills.lint.checking import check, problems_of
from skiros_py.skills.lint.finding import Finding, Problem, Severity, Spot
from skiros_py.skills.lint.registry import (
    DOES_NOT_LOAD,
    EFFECT_MISSING,
    NEVER_TRIED,
    RULES,
    UNDECLARED_CHANGE,
    rule,
)
from skiros_py.skills.lint.rule import Check, Rule
from skiros_py.skills.lint.subject import Known, PrimitiveClass, Source, Subject, title

__all__ = [
    "DOES_NOT_LOAD",
    "EFFECT_MISSING",
    "NEVER_TRIED",
    "RULES",
    "UNDECLARED_CHANGE",
    "Check",
    "Finding",
    "Known",
    "PrimitiveClass",
    "Problem",
    "Rule",
    "Severity",
    "Source",
    "Spot",
    "Subject",
    "check",
    "problems_of",
    "rule",
    "title",
]
