"""How something that takes time ended. Failing is an expected outcome, so it is a value with a reason."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any

_NO_VALUES: Mapping[str, Any] = MappingProxyType({})

BROKEN = -3
"""Code of a failure that is a mistake in a module's code: the log has the traceback."""
BROKEN_OFF = -2
"""Code of a failure that is not the skill's own: it was ended because the world changed."""


@dataclass(frozen=True, slots=True)
class Success:
    """It worked.

    Attributes:
        message: One line for a person.
        values: What it found out, by name: a call writes them with :class:`skiros_py.behaviours.Out`.
    """

    message: str = ""
    values: Mapping[str, Any] = field(default_factory=lambda: _NO_VALUES, hash=False, repr=False)


@dataclass(frozen=True, slots=True)
class Failure:
    """It did not work.

    Attributes:
        reason: What happened, in the operator's words.
        code: Negative progress code (paper §4.1).
    """

    reason: str
    code: int = -1


Outcome = Success | Failure
