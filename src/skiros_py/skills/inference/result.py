"""The answer of inference: values with reasons, or what stays open and why."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from skiros_py.skills.conditions import Verdict


@dataclass(frozen=True, slots=True)
class Inferred:
    """Every required parameter is specified.

    Attributes:
        values: Value by key of every parameter; None for optional ones that stay unspecified.
        reasons: Why this one, by key, of what was inferred ("of 3 that fit, the first by id").
    """

    values: Mapping[str, Any]
    reasons: Mapping[str, str]

    def lines(self) -> list[str]:
        """Returns what was inferred, one parameter a line ("Box = box_a: of 3 that fit, the first by id")."""
        return [f"{key} = {self.values[key]}: {reason}" for key, reason in self.reasons.items()]


@dataclass(frozen=True, slots=True)
class Missing:
    """Required parameters stay open: the module does not run.

    Attributes:
        verdicts: Why nothing was found, by key of each parameter that is missing.
        values: What is specified or was found of the others, by key.
    """

    verdicts: Mapping[str, Verdict]
    values: Mapping[str, Any]

    @property
    def keys(self) -> tuple[str, ...]:
        """The parameters that are missing, in the order in which they are described."""
        return tuple(self.verdicts)

    def __str__(self) -> str:
        which = f"parameter{'s' if len(self.keys) > 1 else ''} {', '.join(self.keys)}"
        reasons = "; ".join(line.strip() for line in self.lines())
        return f"{which} not specified: {reasons}"

    def lines(self) -> list[str]:
        """Returns the reasons as indented lines."""
        return [line for verdict in self.verdicts.values() for line in verdict.lines()]
