"""The whole answer where there is no plan."""

from __future__ import annotations

from dataclasses import dataclass

from skiros_py.planning.reasons import Cause, Repair

__all__ = ["Explanation"]


@dataclass(frozen=True, slots=True)
class Explanation:
    """Why there is no plan, and what would help.

    Attributes:
        causes: Why; empty where nothing was found.
        repairs: Smallest changes after which there is a plan, smallest first.
    """

    causes: tuple[Cause, ...]
    repairs: tuple[Repair, ...] = ()

    @property
    def reasons(self) -> tuple[str, ...]:
        """The causes in the operator's words."""
        return tuple(cause.text for cause in self.causes)
