"""Conditions: patterns over the world, in the words of the domain, with reasons; their effects; watching them."""

from skiros_py.skills.conditions.compare import Compare
from skiros_py.skills.conditions.compound import Junction, Quantified, all_of, any_of, exists, for_all
from skiros_py.skills.conditions.condition import Condition, ConditionType, Role, judge
from skiros_py.skills.conditions.effects import (
    Assign,
    Effect,
    Relate,
    Unrelate,
    effects_of,
    suppose_effects,
    write_effects,
)
from skiros_py.skills.conditions.expression import Expression, ExpressionCondition, holds, is_sensed
from skiros_py.skills.conditions.pattern import (
    AllOf,
    AnyOf,
    Binding,
    ClassRelated,
    Computed,
    Exists,
    Has,
    IsA,
    Not,
    Nothing,
    Pattern,
    Related,
)
from skiros_py.skills.conditions.verdict import Verdict
from skiros_py.skills.conditions.watch import Watch, Watches

__all__ = [
    "AllOf",
    "AnyOf",
    "Assign",
    "Binding",
    "ClassRelated",
    "Compare",
    "Computed",
    "Condition",
    "ConditionType",
    "Effect",
    "Exists",
    "Expression",
    "ExpressionCondition",
    "Has",
    "IsA",
    "Junction",
    "Not",
    "Nothing",
    "Pattern",
    "Quantified",
    "Relate",
    "Related",
    "Role",
    "Unrelate",
    "Verdict",
    "Watch",
    "Watches",
    "all_of",
    "any_of",
    "effects_of",
    "exists",
    "for_all",
    "holds",
    "is_sensed",
    "judge",
    "suppose_effects",
    "write_effects",
]
