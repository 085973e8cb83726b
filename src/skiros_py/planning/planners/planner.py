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
        starts: Start time of each step [s]; empty if the planner has no notion of time.
        durations: Duration of each step [s]; empty if the planner has no notion of time.
    """

    steps: tuple[tuple[str, ...], ...]
    starts: tuple[float, ...] = ()
    durations: tuple[float, ...] = ()


@dataclass(frozen=True, slots=True)
class Unsolvable:
    """The planner says that no plan exists.

    Attributes:
        reason: The reason it gives, if any.
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
        """The PDDL requirements it supports: ":strips", ":typing", ":durative-actions", …."""
        ...

    def solve(self, domain: str, problem: str) -> Pending[Answer]:
        """Starts solving; several calls may be under way at once.

        The pending answer's ``result`` raises PlanningError when the planner fails. It may have a method ``cancel()``,
        which is called when it is no longer needed and kills the running program.
        """
        ...

    def close(self) -> None:
        """Kills running calls and waits for them."""
        ...


def abandon(pending: Pending[Answer]) -> None:
    """Cancels a pending answer that is no longer needed; does nothing if it is available or cannot be cancelled."""
    cancel = getattr(pending, "cancel", None)
    if cancel is not None:
        cancel()
