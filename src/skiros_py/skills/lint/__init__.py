"""Rules for plug-ins: what is wrong with a skill, a primitive or a condition, before it is offered to anybody."""

from skiros_py.skills.lint.checking import (
    DOES_NOT_LOAD,
    EFFECT_MISSING,
    NEVER_TRIED,
    RULES,
    UNDECLARED_CHANGE,
    check,
    problems_of,
    rule,
)
from skiros_py.skills.lint.rule import (
    Check,
    Finding,
    Known,
    PrimitiveClass,
    Problem,
    Rule,
    Severity,
    Source,
    Spot,
    Subject,
    title,
)

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
