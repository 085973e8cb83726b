"""The port to planners: any program or library that takes PDDL texts."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from skiros_py.robot.pending import Pending

__all__ = ["Answer", "Planner", "Solved", "Unsolvable"]


@dataclass(frozen=True, slots=True)
class Solved:
    """A plan as the planner wrote it: for each step the action and its objects, in PDDL names."""

    steps: tuple[tuple[str, ...], ...]


@dataclass(frozen=True, slots=True)
class Unsolvable:
    """The planner says that no plan exists."""


Answer = Solved | Unsolvable


class Planner(Protocol):
    """Solves PDDL tasks."""

    @property
    def name(self) -> str:
        """What people call it."""
        ...

    def solve(self, domain: str, problem: str) -> Pending[Answer]:
        """Starts solving; several calls may be under way at once.

        The pending answer's ``result`` raises PlanningError when the planner breaks.
        """
        ...

    def close(self) -> None:
        """Kills what still runs and waits for it."""
        ...
