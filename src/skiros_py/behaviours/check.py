"""Looks whether conditions hold now."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from skiros_py.behaviours.children import read_conditions
from skiros_py.skills.behaviour import Behaviour, Scope, Uses
from skiros_py.skills.conditions import Condition
from skiros_py.skills.inference import applying
from skiros_py.skills.outcome import Execution, Failure, Outcome, Success


@dataclass(frozen=True, slots=True)
class Check(Behaviour):
    """Succeeds where the conditions hold, else fails with the reason; takes no time."""

    kind: ClassVar[str] = "check"

    conditions: tuple[Condition, ...]

    def __post_init__(self) -> None:
        object.__setattr__(self, "conditions", read_conditions("check", self.conditions))

    @classmethod
    def of(cls, *conditions: Condition | str) -> Check:
        """Makes one: ``Check.of("Gripper.gap > 0.01")``."""
        return cls(conditions)  # type: ignore[arg-type]  # texts are read

    @property
    def title(self) -> str:
        """The conditions."""
        return f"check {' and '.join(map(str, self.conditions))}"

    def uses(self) -> Uses:
        """Its conditions."""
        return Uses(conditions=self.conditions)

    def run(self, scope: Scope) -> Execution[Outcome]:
        """Evaluates the conditions."""
        yield from ()
        for condition in applying(self.conditions, scope.arguments):
            verdict = condition.evaluate(scope.context.world, scope.arguments)
            if not verdict:
                return Failure(verdict.sentence)
        return Success()
