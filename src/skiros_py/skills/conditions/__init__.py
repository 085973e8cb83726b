"""Conditions: patterns over the world, in the words of the domain, with reasons; their effects; watching them."""

from skiros_py.skills.conditions.compound import all_of, any_of, exists, for_all
from skiros_py.skills.conditions.condition import Compare, Condition, ConditionType, Role, judge
from skiros_py.skills.conditions.expression import Expression, holds
from skiros_py.skills.conditions.pattern import (
    AllOf,
    AnyOf,
    Binding,
    ClassRelated,
    Computed,
    Decrease,
    Exists,
    Has,
    Increase,
    IsA,
    Not,
    Nothing,
    Pattern,
    Related,
    Verdict,
)

__all__ = [
    "AllOf",
    "AnyOf",
    "Binding",
    "ClassRelated",
    "Compare",
    "Computed",
    "Condition",
    "ConditionType",
    "Decrease",
    "Exists",
    "Expression",
    "Has",
    "Increase",
    "IsA",
    "Not",
    "Nothing",
    "Pattern",
    "Related",
    "Role",
    "Verdict",
    "all_of",
    "any_of",
    "exists",
    "for_all",
    "holds",
    "judge",
]
