"""How often failed steps are repeated, and what happens to a condition that cannot be reached."""

from __future__ import annotations

from dataclasses import dataclass

from skiros_py.errors import UsageError


@dataclass(frozen=True, slots=True)
class Policy:
    """How a task proceeds when steps fail or a part of its goal cannot be reached.

    Attributes:
        rest: True to pursue the rest of the goal when a condition is given up; False to stop.
        ask: True to ask the user before a condition is given up.
        attempts: How often a skill may fail on one target before that target is left out of further plans; a
            sequence ends after as many failures of one step. It also bounds the plans and retries of a goal, with its
            number of conditions.
        partial: True to start even if part of the goal is unreachable from the outset; False to do nothing then.
        rehearse: True to carry out the plan in a second physics world first, and to do nothing if it fails there;
            with ``partial``, what can be reached without what fails there.
    """

    rest: bool = True
    ask: bool = False
    attempts: int = 3
    partial: bool = False
    rehearse: bool = False

    def __post_init__(self) -> None:
        if isinstance(self.attempts, bool) or not isinstance(self.attempts, int) or self.attempts < 1:
            raise UsageError(f"attempts: a whole number from 1, not {self.attempts!r}")
