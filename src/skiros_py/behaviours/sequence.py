"""Children one after the other, until one fails."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from skiros_py.behaviours.children import Composite, in_turn
from skiros_py.skills.behaviour import Scope, Uses
from skiros_py.skills.outcome import Execution, Failure, Outcome


@dataclass(frozen=True, slots=True)
class Sequence(Composite):
    """One after the other; the first failure ends it."""

    kind: ClassVar[str] = "sequence"

    def uses(self) -> Uses:
        """Its children run in order."""
        return Uses(in_order=True)

    def run(self, scope: Scope) -> Execution[Outcome]:
        """Runs the children in turn."""
        return in_turn(self.children, scope, ends_with=Failure)
