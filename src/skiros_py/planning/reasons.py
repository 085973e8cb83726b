"""Why there is no plan, as data: causes, and the smallest changes that would make one."""

from __future__ import annotations

import enum
from dataclasses import dataclass
from typing import Protocol

from skiros_py.skills.conditions import Condition
from skiros_py.world.overlay import Overlay
from skiros_py.world.world import World

__all__ = ["Cause", "CauseKind", "Edit", "Repair"]


class CauseKind(enum.StrEnum):
    """What kind of thing stands in the way."""

    NO_SKILL = "no skill"
    """No robot that is there has a skill that brings it about."""
    MISSING_FACT = "missing fact"
    """Something that no skill changes does not hold."""
    MISSING_ELEMENT = "missing element"
    """There is no thing of the class that is needed."""
    TOO_FEW = "too few"
    """There are such things, but fewer than are wanted."""
    FULL = "full"
    """The place is taken, and nothing takes away what is there."""
    DOES_NOT_FIT = "does not fit"
    """What is wanted there fits into no place there is."""
    CONTRADICTION = "contradiction"
    """Conditions of the goal exclude each other."""
    CONFLICT = "conflict"
    """Each condition could be reached alone, but not all of these together."""


@dataclass(frozen=True, slots=True)
class Cause:
    """One reason.

    Attributes:
        kind: What kind of reason.
        text: The whole of it in the operator's words.
        conditions: The conditions of the goal that it keeps from being reached.
        skill: The skill that would bring it about; None where there is none.
        precondition: What that skill needs and never gets, in words; empty where that is not it.
        elements: The elements and classes it is about, ids or CURIEs.
    """

    kind: CauseKind
    text: str
    conditions: tuple[Condition, ...] = ()
    skill: str | None = None
    precondition: str = ""
    elements: tuple[str, ...] = ()


class Edit(Protocol):
    """One change to scene, goal or robots."""

    def __str__(self) -> str:
        """Says it as an instruction: "remove starter_2 from kit_3_a"."""
        ...

    def suppose(self, view: Overlay) -> None:
        """Makes it in imagination."""
        ...

    def apply(self, world: World) -> None:
        """Makes it for good, as one transaction."""
        ...


@dataclass(frozen=True, slots=True)
class Repair:
    """A smallest change after which there is a plan; it was tried out.

    Attributes:
        text: What to do, in the operator's words.
        edits: The changes to the world.
        without: Conditions to take out of the goal.
    """

    text: str
    edits: tuple[Edit, ...] = ()
    without: tuple[Condition, ...] = ()
