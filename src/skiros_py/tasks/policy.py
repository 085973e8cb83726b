"""What a task does when part of its goal turns out to be unreachable."""

from __future__ import annotations

from dataclasses import dataclass

from skiros_py.errors import UsageError


@dataclass(frozen=True, slots=True)
class Policy:
    """How to go on when things go wrong.

    Attributes:
        rest: True to pursue the rest of the goal when a condition is given up; False to stop.
        ask: True to ask the user before a condition is given up.
        attempts: How often a skill may fail on one target before that target is left out of further plans.
        partial: True to start even if part of the goal is unreachable from the outset; False to do nothing then.
    """

    rest: bool = True
    ask: bool = False
    attempts: int = 3
    partial: bool = False

    def __post_init__(self) -> None:
        if isinstance(self.attempts, bool) or not isinstance(self.attempts, int) or self.attempts < 1:
            raise UsageError(f"attempts: a whole number from 1, not {self.attempts!r}")
