"""A child that runs at a lower rate."""

from __future__ import annotations

from contextlib import closing
from dataclasses import dataclass
from typing import ClassVar

from skiros_py.behaviours.children import Decorator, check_seconds
from skiros_py.skills.behaviour import Behaviour, Scope, Uses, check_behaviour, require
from skiros_py.skills.outcome import Execution, Outcome, tick


@dataclass(frozen=True, slots=True)
class Every(Decorator):
    """The child, ticked once in so many seconds of run time instead of in each cycle.

    For what watches or computes: a device that is not commanded in a cycle brakes, so motion needs every cycle.
    """

    kind: ClassVar[str] = "every"

    seconds: float
    child: Behaviour

    def __post_init__(self) -> None:
        check_seconds("every", self.seconds)
        require(self.seconds > 0.0, "every", "a time above 0 s", self.seconds)
        check_behaviour("every", self.child)

    @property
    def title(self) -> str:
        """The period."""
        return f"every {self.seconds:g} s"

    def uses(self) -> Uses:
        """Its child runs once."""
        return Uses(in_order=True)

    def run(self, scope: Scope) -> Execution[Outcome]:
        """Ticks the child whenever its time has come; missed ticks are skipped."""
        due = scope.context.now
        with closing(scope.run(self.child, "0")) as run:
            while True:
                now = scope.context.now
                if now >= due - 1e-9:
                    due = max(due + self.seconds, now)
                    outcome = tick(run)
                    if outcome is not None:
                        return outcome
                yield
