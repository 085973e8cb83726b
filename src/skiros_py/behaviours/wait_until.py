"""Waits until conditions hold."""

from __future__ import annotations

from contextlib import closing
from dataclasses import dataclass
from typing import ClassVar

from skiros_py.behaviours.children import ConditionNode
from skiros_py.skills.behaviour import Scope
from skiros_py.skills.outcome import Execution, Outcome, Success


@dataclass(frozen=True, slots=True)
class WaitUntil(ConditionNode):
    """Waits until all conditions hold; :class:`~skiros_py.behaviours.Timeout` around it bounds the time."""

    kind: ClassVar[str] = "wait_until"

    def run(self, scope: Scope) -> Execution[Outcome]:
        """Waits."""
        with closing(scope.watch(self.conditions)) as watch:
            while watch.broken() is not None:
                yield
        return Success()
