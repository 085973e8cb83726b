"""Children one after the other, until one succeeds."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from skiros_py.behaviours.children import Composite, in_turn
from skiros_py.skills.behaviour import Scope, Uses
from skiros_py.skills.outcome import Execution, Outcome, Success


@dataclass(frozen=True, slots=True)
class Fallback(Composite):
    """One after the other until one succeeds."""

    kind: ClassVar[str] = "fallback"

    def uses(self) -> Uses:
        """One child has to succeed."""
        return Uses(needs="any", in_order=True)

    def run(self, scope: Scope) -> Execution[Outcome]:
        """Runs the children in turn."""
        return in_turn(self.children, scope, ends_with=Success)
