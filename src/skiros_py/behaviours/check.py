"""Looks whether conditions hold now."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from skiros_py.behaviours.children import ConditionNode
from skiros_py.skills.behaviour import Scope
from skiros_py.skills.inference.inferring import applying
from skiros_py.skills.outcome import Execution, Failure, Outcome, Success


@dataclass(frozen=True, slots=True)
class Check(ConditionNode):
    """Succeeds where the conditions hold, else fails with the reason; takes no time."""

    kind: ClassVar[str] = "check"

    def run(self, scope: Scope) -> Execution[Outcome]:
        """Evaluates the conditions."""
        yield from ()
        for condition in applying(self.conditions, scope.arguments):
            verdict = condition.evaluate(scope.context.world, scope.arguments)
            if not verdict:
                return Failure(verdict.sentence)
        return Success()
