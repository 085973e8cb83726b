"""A child that runs only while conditions hold."""

from __future__ import annotations

from contextlib import closing
from dataclasses import dataclass
from typing import ClassVar

from skiros_py.behaviours.children import Decorator, lost, read_conditions, run_until
from skiros_py.skills.behaviour import Behaviour, Scope, Uses, check_behaviour
from skiros_py.skills.conditions import Condition
from skiros_py.skills.outcome import Execution, Outcome, tick


@dataclass(frozen=True, slots=True)
class Guard(Decorator):
    """The child, as long as the conditions hold; cancelled with a failure as soon as one does not.

    Attributes:
        child: What is guarded.
        conditions: Over the skill's parameters, like those of its description; expressions over signals, also as texts,
            are evaluated in each cycle.
    """

    kind: ClassVar[str] = "guard"

    child: Behaviour
    conditions: tuple[Condition, ...]

    def __post_init__(self) -> None:
        check_behaviour("guard", self.child)
        object.__setattr__(self, "conditions", read_conditions("guard", self.conditions))

    @classmethod
    def of(cls, child: Behaviour, *conditions: Condition | str) -> Guard:
        """Makes one: ``Guard.of(Do.of("press"), "Gripper.force < limit")``."""
        return cls(child, conditions)  # type: ignore[arg-type]  # texts are read

    @property
    def title(self) -> str:
        """The conditions."""
        return f"while {' and '.join(map(str, self.conditions))}"

    def uses(self) -> Uses:
        """Its conditions."""
        return Uses(conditions=self.conditions, in_order=True)

    def run(self, scope: Scope) -> Execution[Outcome]:
        """Runs the child while the conditions hold."""
        with closing(scope.watch(self.conditions)) as watch:
            return (yield from run_until(self.child, "0", scope, lambda run: lost(watch, "no longer") or tick(run)))
