"""Comparing what is there with a constant: numbers, texts (names of classes and states are texts), true and false."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from operator import eq, ge, gt, le, lt, ne
from types import MappingProxyType
from typing import Literal

from skiros_py.errors import DescriptionError
from skiros_py.skills.conditions.verdict import Verdict
from skiros_py.world.element import Value
from skiros_py.world.literals import shown

Operator = Literal["=", "!=", "<", "<=", ">", ">="]
"""How two values are compared; numbers all ways, texts and truth values by the first two."""

Constant = str | bool | int | float
"""What something may be compared with."""

_OPERATORS: Mapping[str, Callable[[float, float], bool]] = MappingProxyType(
    {"=": eq, "!=": ne, "<": lt, "<=": le, ">": gt, ">=": ge}
)
_WORDS: Mapping[str, str] = MappingProxyType(
    {"=": "", "!=": "other than ", "<": "less than ", "<=": "at most ", ">": "more than ", ">=": "at least "}
)


@dataclass(frozen=True, slots=True)
class Comparison:
    """Something held against a constant; ``"{op} {value}"`` of the patterns that compare.

    Attributes:
        op: How.
        value: With what.
    """

    op: Operator
    value: Constant

    def __post_init__(self) -> None:
        kind = _kind(self.value)
        if kind is None or (isinstance(self.value, float) and not math.isfinite(self.value)):
            raise DescriptionError(f"compare with a text, a finite number, true or false, not with {shown(self.value)}")
        if self.op not in _OPERATORS:
            raise DescriptionError(f"'{self.op}' does not compare: use one of {' '.join(_OPERATORS)}")
        if kind != "number" and self.op not in ("=", "!="):
            raise DescriptionError(f"'{self.op}' compares numbers, and {_said(self.value)} is a {kind}: use = or !=")

    def __str__(self) -> str:
        return f"{_WORDS[self.op]}{_said(self.value)}"

    def judge(self, what: str, present: Value | None, missing: str) -> Verdict:
        """Compares a value that is there with the constant.

        Nothing can be said of what is missing or of another kind: it is neither equal, nor other, nor less.

        Args:
            what: What has the value, for the reason ("the mass of ball_1").
            present: The value; None for none.
            missing: The reason where there is none.
        """
        if present is None:
            return Verdict(False, missing)
        if _kind(present) != _kind(self.value):
            kind = _kind(present) or "no text, number or truth value"
            return Verdict(
                False, f"{what} is {_said(present)} ({kind}): it cannot be compared with {_said(self.value)}"
            )
        holds = self.allows(present)
        return Verdict(holds, f"{what} is {_said(present)}{'' if holds else f', not {self}'}")

    def allows(self, present: Value | None) -> bool:
        """Tells whether a value that is there, or None, compares as wanted."""
        if present is None or _kind(present) != _kind(self.value):
            return False
        return _OPERATORS[self.op](present, self.value)  # type: ignore[arg-type]  # both of one kind


def _kind(value: object) -> str | None:
    if isinstance(value, bool):  # before int, of which it is a subclass
        return "truth value"
    if isinstance(value, int | float):
        return "number"
    return "text" if isinstance(value, str) else None


def _said(value: Value) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    return shown(value).removesuffix(".0") if isinstance(value, float) else shown(value)
