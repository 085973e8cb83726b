"""A property's value compared with a constant: charged enough, scanned, a door that is open."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from operator import eq, ge, gt, le, lt, ne
from types import MappingProxyType
from typing import Literal

from skiros_py.errors import DescriptionError
from skiros_py.skills.conditions.pattern import Binding
from skiros_py.skills.conditions.verdict import Verdict
from skiros_py.world.element import Value
from skiros_py.world.literals import shown
from skiros_py.world.names import local_name
from skiros_py.world.view import WorldView


@dataclass(frozen=True, slots=True)
class Compare:
    """A property of an element (or of its class) compares as wanted with a constant.

    Of an element without a value none of the comparisons holds, "!=" neither; ask that by ``Not(Has(...))``.

    Attributes:
        property: CURIE of the property.
        op: ``=``, ``!=``, and for numbers ``<``, ``<=``, ``>``, ``>=``.
        subject: Variable.
        value: A number, a text (also the name of a class or of a state), or true or false.

    Raises:
        DescriptionError: There is no such comparison, or not of such a value.
    """

    property: str
    op: Operator
    subject: str
    value: Constant

    def __post_init__(self) -> None:
        Comparison(self.op, self.value)

    def allows(self, value: Value | None) -> bool:
        """Tells whether it would hold of an element with this value, or with none."""
        return Comparison(self.op, self.value).allows(value)

    def evaluate(self, view: WorldView, binding: Binding) -> Verdict:
        """Compares."""
        subject = binding[self.subject]
        name = local_name(self.property)
        value = view.value(subject, self.property)
        return Comparison(self.op, self.value).judge(f"the {name} of {subject}", value, f"{subject} has no {name}")

    def rename(self, names: Mapping[str, str]) -> Compare:
        """Returns the same pattern with other variable names."""
        return Compare(self.property, self.op, names.get(self.subject, self.subject), self.value)


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
