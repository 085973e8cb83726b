"""The port to planners: any program or library that takes PDDL texts."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from skiros_py.ports.pending import Pending


@dataclass(frozen=True, slots=True)
class Solved:
    """A plan as the planner wrote it.

    Attributes:
        steps: For each step the action and its objects, in PDDL names, in the order in which they start.
        starts: When each step starts [s]; empty if the planner knows no time.
        durations: How long each takes [s]; empty if the planner knows no time.
    """

    steps: tuple[tuple[str, ...], ...]
    starts: tuple[float, ...] = ()
    durations: tuple[float, ...] = ()


@dataclass(frozen=True, slots=True)
class Unsolvable:
    """The planner says that no plan exists.

    Attributes:
        reason: What it says of why, if anything.
        proven: False if it gave up searching without a proof.
    """

    reason: str = ""
    proven: bool = True


Answer = Solved | Unsolvable


class Planner(Protocol):
    """Solves PDDL tasks."""

    @property
    def name(self) -> str:
        """Its display name."""
        ...

    @property
    def supports(self) -> frozenset[str]:
        """The PDDL requirements it can take: ":strips", ":typing", ":durative-actions", …."""
        ...

    def solve(self, domain: str, problem: str) -> Pending[Answer]:
        """Starts solving; several calls may be under way at once.

        The pending answer's ``result`` raises PlanningError when the planner breaks. It may have a method ``cancel()``,
        which is called when nobody wants it any more: it kills what still runs for it.
        """
        ...

    def close(self) -> None:
        """Kills what still runs and waits for it."""
        ...


def abandon(pending: Pending[Answer]) -> None:
    """Says that nobody wants an answer any more; does nothing if it is there, or cannot be cancelled."""
    cancel = getattr(pending, "cancel", None)
    if cancel is not None:
        cancel()
