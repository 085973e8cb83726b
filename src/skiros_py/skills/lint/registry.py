"""All rules, in the order in which they are asked."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from skiros_py.errors import UnknownName
from skiros_py.skills.lint.finding import Severity
from skiros_py.skills.lint.rule import Rule
from skiros_py.skills.lint.rules.calls import MISSING_ARGUMENT, MISSING_PARAMETER, UNKNOWN_MODULE
from skiros_py.skills.lint.rules.code import BLOCKING_CALL, MOTION_IN_FINALLY, YIELD_NEVER
from skiros_py.skills.lint.rules.devices import NO_MIX_RULE, SAME_DEVICE
from skiros_py.skills.lint.rules.documented import MISSING_HELP, MISSING_UNIT
from skiros_py.skills.lint.rules.imports import PRIVATE_IMPORT
from skiros_py.skills.lint.rules.places import MOVES_BY_STRUCTURE, UNPLACED
from skiros_py.skills.lint.rules.pretending import PRETENDS
from skiros_py.skills.lint.rules.ranges import WRONG_RANGE
from skiros_py.skills.lint.rules.reach import IMPOSSIBLE_EFFECT, UNREACHABLE_PRECONDITION
from skiros_py.skills.lint.rules.recursion import RECURSIVE_SKILL
from skiros_py.skills.lint.rules.words import NOT_COMPUTED, UNKNOWN_WORD

DOES_NOT_LOAD = Rule("does-not-load", Severity.ERROR, "A plug-in that cannot be loaded.")
EFFECT_MISSING = Rule("effect-missing", Severity.ERROR, "A skill ran, and an effect it declares did not happen.")
UNDECLARED_CHANGE = Rule("undeclared-change", Severity.ERROR, "A skill ran, and changed what it does not declare.")
NEVER_TRIED = Rule("never-tried", Severity.WARNING, "A skill for which no world to try it in was found.")

_ALL = (
    DOES_NOT_LOAD,
    UNKNOWN_WORD,
    NOT_COMPUTED,
    UNPLACED,
    UNKNOWN_MODULE,
    MISSING_ARGUMENT,
    MISSING_PARAMETER,
    WRONG_RANGE,
    IMPOSSIBLE_EFFECT,
    UNREACHABLE_PRECONDITION,
    RECURSIVE_SKILL,
    SAME_DEVICE,
    NO_MIX_RULE,
    PRETENDS,
    MOVES_BY_STRUCTURE,
    MISSING_HELP,
    MISSING_UNIT,
    YIELD_NEVER,
    MOTION_IN_FINALLY,
    BLOCKING_CALL,
    PRIVATE_IMPORT,
    EFFECT_MISSING,
    UNDECLARED_CHANGE,
    NEVER_TRIED,
)

RULES: Mapping[str, Rule] = MappingProxyType({one.name: one for one in _ALL})
"""Every rule, by name."""


def rule(name: str) -> Rule:
    """Returns the rule of that name.

    Raises:
        UnknownName: There is none.
    """
    if name not in RULES:
        raise UnknownName("rule", name, RULES)
    return RULES[name]
