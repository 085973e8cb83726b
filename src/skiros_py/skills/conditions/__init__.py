"""Conditions: patterns over the world, in the words of the domain, with reasons."""

from skiros_py.skills.conditions.condition import Condition, ConditionType, Role, any_of
from skiros_py.skills.conditions.pattern import (
    AllOf,
    AnyOf,
    Binding,
    Computed,
    Exists,
    Has,
    Not,
    Nothing,
    Pattern,
    Related,
)
from skiros_py.skills.conditions.verdict import Verdict

__all__ = [
    "AllOf",
    "AnyOf",
    "Binding",
    "Computed",
    "Condition",
    "ConditionType",
    "Exists",
    "Has",
    "Not",
    "Nothing",
    "Pattern",
    "Related",
    "Role",
    "Verdict",
    "any_of",
]
