"""What takes time: a generator that is ticked once per control cycle, and how it ended."""

from __future__ import annotations

from collections.abc import Generator, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any, TypeVar

_NO_VALUES: Mapping[str, Any] = MappingProxyType({})

BROKEN = -3
"""Code of a failure that is a mistake in a module's code: the log has the traceback."""
OBSTRUCTED = -4
"""Code of a failure because other robots block the path, ``values["blocked_by"]``: not the target's fault."""
DEVICE_FAILED = -5
"""Code of a failure because a device does not answer, was switched off, or says nothing usable."""
CANCELLED = -2
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
        values: Why, as plain data for programs: ``cause`` is the kind of reason ("reach", "collision", "limits",
            "singularity", "contact", "not grasped", "device", …); ``blocked_by`` are the ids of robots, and
            ``out_of_reach`` those of what no attempt can reach.
    """

    reason: str
    code: int = -1
    values: Mapping[str, Any] = field(default_factory=lambda: _NO_VALUES, hash=False, repr=False)

    @property
    def is_out_of_reach(self) -> bool:
        """True if nothing but another place of the robot can change it."""
        return self.values.get("cause") == "reach"

    @property
    def is_final(self) -> bool:
        """True if the same attempt from the same place would end in the same way."""
        return self.code == DEVICE_FAILED or self.is_out_of_reach


Outcome = Success | Failure


T = TypeVar("T")

Execution = Generator[None, None, T]
"""A generator that yields once per control cycle while it still runs and returns its result."""


def tick(run: Execution[T]) -> T | None:
    """Runs up to the next ``yield``; returns the result, which must not be None, or None while it goes on."""
    try:
        next(run)
    except StopIteration as end:
        result: T = end.value
        return result
    return None
