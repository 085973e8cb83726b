"""Lets time pass."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from skiros_py.behaviours.children import check_seconds
from skiros_py.skills.behaviour import Behaviour, Scope
from skiros_py.skills.outcome import Execution, Outcome, Success


@dataclass(frozen=True, slots=True)
class Wait(Behaviour):
    """Lets so many seconds of run time pass."""

    kind: ClassVar[str] = "wait"

    seconds: float

    def __post_init__(self) -> None:
        check_seconds("wait", self.seconds)

    @property
    def title(self) -> str:
        """How long."""
        return f"wait {self.seconds:g} s"

    def run(self, scope: Scope) -> Execution[Outcome]:
        """Waits."""
        yield from scope.context.sleep(self.seconds)
        return Success()
