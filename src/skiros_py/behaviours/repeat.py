"""A child that is done again and again."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from skiros_py.behaviours.children import Decorator, check_times
from skiros_py.skills.behaviour import Behaviour, Scope, check_behaviour
from skiros_py.skills.outcome import Execution, Failure, Outcome


@dataclass(frozen=True, slots=True)
class Repeat(Decorator):
    """The child again and again, so many times, until it fails.

    Attributes:
        child: What is repeated.
        times: How often; None for until it fails or is cancelled.
    """

    kind: ClassVar[str] = "repeat"

    child: Behaviour
    times: int | None = None

    def __post_init__(self) -> None:
        check_behaviour("repeat", self.child)
        if self.times is not None:
            check_times("repeat", self.times)

    @property
    def title(self) -> str:
        """Its kind, and how often."""
        return "repeat until it fails" if self.times is None else f"repeat {self.times} times"

    def run(self, scope: Scope) -> Execution[Outcome]:
        """Runs the child until it fails, or so many times."""
        done = 0
        while True:
            outcome = yield from scope.run(self.child, "0")
            done += 1
            if isinstance(outcome, Failure) or done == self.times:
                return outcome
            yield
