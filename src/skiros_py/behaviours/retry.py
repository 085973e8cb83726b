"""A child that is tried again when it fails."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from skiros_py.behaviours.children import Decorator, check_times, in_turn
from skiros_py.skills.behaviour import Behaviour, Scope, check_behaviour
from skiros_py.skills.outcome import Execution, Outcome, Success


@dataclass(frozen=True, slots=True)
class Retry(Decorator):
    """The child again, until it succeeds or was tried so many times."""

    kind: ClassVar[str] = "retry"

    child: Behaviour
    times: int

    def __post_init__(self) -> None:
        check_behaviour("retry", self.child)
        check_times("retry", self.times)

    @property
    def title(self) -> str:
        """Its kind, and how often."""
        return f"retry, at most {self.times} times"

    def run(self, scope: Scope) -> Execution[Outcome]:
        """Runs the child until it succeeds."""
        return in_turn((self.child,) * self.times, scope, ends_with=Success, same=True)
