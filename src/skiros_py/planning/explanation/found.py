"""A cause with the findings behind it, from which repairs start."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from skiros_py.planning.domain.model import Atom
from skiros_py.planning.reasons import Cause, CauseKind


@dataclass(frozen=True, slots=True)
class Shortage:
    """More is required than there is.

    Attributes:
        wanted: How many different ones are required.
        there: The existing things or places.
        things: The things that need the places and could be removed; empty if things are short.
    """

    wanted: int
    there: tuple[str, ...]
    things: tuple[str, ...] = ()

    @property
    def excess(self) -> int:
        """How many more are required than there are."""
        return self.wanted - len(self.there)


@dataclass(frozen=True, slots=True)
class Found:
    """A cause with the findings behind it.

    Attributes:
        cause: The cause.
        obstacle: What never holds; None for conditions that exclude each other.
        shortage: What is short; None if the cause is not a shortage.
    """

    cause: Cause
    obstacle: Obstacle | None = None
    shortage: Shortage | None = None


@dataclass(frozen=True, slots=True)
class Obstacle:
    """The reason why a fact never becomes true.

    Attributes:
        kind: The kind of cause.
        text: The chain of reasons in words.
        core: The last link alone: the actual state that prevents the required one.
        skill: The skill that would provide the missing fact; None if there is none.
        precondition: The unreachable precondition of that skill, in words.
        elements: The elements and classes involved.
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
