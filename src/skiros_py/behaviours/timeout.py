"""A child with a time limit."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from skiros_py.behaviours.children import Decorator, check_seconds, run_until
from skiros_py.messages import Message
from skiros_py.skills.behaviour import Behaviour, Scope, Uses, check_behaviour, require
from skiros_py.skills.outcome import Execution, Failure, Outcome, tick


@dataclass(frozen=True, slots=True)
class Timeout(Decorator):
    """The child, cancelled with a failure when it takes longer than so many seconds of run time."""

    kind: ClassVar[str] = "timeout"

    child: Behaviour
    seconds: float

    def __post_init__(self) -> None:
        check_behaviour("timeout", self.child)
        check_seconds("timeout", self.seconds)
        require(self.seconds > 0.0, "timeout", "a time above 0 s", self.seconds)

    @property
    def title(self) -> str:
        """The limit."""
        return f"within {self.seconds:g} s"

    def uses(self) -> Uses:
        """Its child runs once."""
        return Uses(in_order=True)

    def run(self, scope: Scope) -> Execution[Outcome]:
        """Runs the child until the time is over."""
        context, end = scope.context, scope.context.now + self.seconds

        def late() -> Failure | None:
            return (
                Failure(Message("took longer than {seconds:g} s", seconds=self.seconds))
                if context.now >= end - 1e-9
                else None
            )

        return run_until(self.child, "0", scope, lambda run: tick(run) or late())
