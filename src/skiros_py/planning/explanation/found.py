"""A cause with what it was found by: what repairs start from."""

from __future__ import annotations

from dataclasses import dataclass

from skiros_py.planning.explanation.obstacle import Obstacle
from skiros_py.planning.reasons import Cause


@dataclass(frozen=True, slots=True)
class Shortage:
    """More is wanted than there is.

    Attributes:
        wanted: How many different ones are wanted.
        there: The things or places that there are.
        things: What wants the places, where it could be left out; empty where things are short.
    """

    wanted: int
    there: tuple[str, ...]
    things: tuple[str, ...] = ()

    @property
    def excess(self) -> int:
        """How many more are wanted than there are."""
        return self.wanted - len(self.there)


@dataclass(frozen=True, slots=True)
class Found:
    """A cause with what it was found by.

    Attributes:
        cause: The cause.
        obstacle: What never holds; None for conditions that exclude each other.
        shortage: What there is too little of; None where that is not it.
    """

    cause: Cause
    obstacle: Obstacle | None = None
    shortage: Shortage | None = None
