"""Waits until conditions hold."""

from __future__ import annotations

from contextlib import closing
from dataclasses import dataclass
from typing import ClassVar

from skiros_py.behaviours.children import read_conditions
from skiros_py.skills.behaviour import Behaviour, Scope, Uses
from skiros_py.skills.conditions import Condition
from skiros_py.skills.outcome import Execution, Outcome, Success


@dataclass(frozen=True, slots=True)
class WaitUntil(Behaviour):
    """Waits until all conditions hold; :class:`~skiros_py.behaviours.Timeout` around it bounds the time.

    Attributes:
        conditions: Over the skill's parameters; expressions over signals may be texts.
    """

    kind: ClassVar[str] = "wait_until"

    conditions: tuple[Condition, ...]

    def __post_init__(self) -> None:
        object.__setattr__(self, "conditions", read_conditions("wait until", self.conditions))

    @classmethod
    def of(cls, *conditions: Condition | str) -> WaitUntil:
        """Makes one: ``WaitUntil.of("Arm.still and Gripper.force > 2")``."""
        return cls(conditions)  # type: ignore[arg-type]  # texts are read

    @property
    def title(self) -> str:
        """The conditions."""
        return f"wait until {' and '.join(map(str, self.conditions))}"

    def uses(self) -> Uses:
        """Its conditions."""
        return Uses(conditions=self.conditions)

    def run(self, scope: Scope) -> Execution[Outcome]:
        """Waits."""
        with closing(scope.watch(self.conditions)) as watch:
            while watch.broken() is not None:
                yield
        return Success()
