"""A cause with what it was found by: what repairs start from."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from skiros_py.planning.domain.model import Atom
from skiros_py.planning.reasons import Cause, CauseKind


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
        shortage: What there is too little of; None if that is not it.
    """

    cause: Cause
    obstacle: Obstacle | None = None
    shortage: Shortage | None = None


@dataclass(frozen=True, slots=True)
class Obstacle:
    """The first thing in the way.

    Attributes:
        kind: What kind of thing.
        text: The way down to it in words.
        core: The last of that by itself: what is the case instead of what would be needed.
        skill: The skill that would give what is lacking; None if there is none.
        precondition: What that skill needs and never gets, in words.
        elements: Elements and classes it is about.
        missing: The fact that never holds, perhaps with variables left; None if it is not one fact.
        types: Classes of the variables of that fact.
    """

    kind: CauseKind
    text: str
    skill: str | None = None
    precondition: str = ""
    elements: tuple[str, ...] = ()
    missing: Atom | None = None
    types: Mapping[str, str] = field(default_factory=dict)
    core: str = ""
