"""What an ontology declares: classes, relations and properties, as plain values."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import Literal

__all__ = ["Class", "Family", "PlaceEnd", "Property", "Relation"]

PlaceEnd = Literal["subject", "object"]


class Family(StrEnum):
    """What a relation is for; said in the ontology by its superproperty."""

    PLACEMENT = "placement"
    """Where a thing is: one place across the whole family."""
    STRUCTURE = "structure"
    """What a thing is built of: a piece has one owner."""
    COMPUTED = "computed"
    """Worked out on demand, never stored."""
    PLAIN = "plain"
    """Any other."""


@dataclass(frozen=True, slots=True)
class Class:
    """One class.

    Attributes:
        curie: Its name ("kitting:Starter").
        label: What people call it.
        comment: What it means.
        parents: Its direct superclasses, the primary one first.
    """

    curie: str
    label: str
    comment: str
    parents: tuple[str, ...]

    @property
    def primary_parent(self) -> str | None:
        """The superclass whose line is followed first, or None at the top."""
        return self.parents[0] if self.parents else None


@dataclass(frozen=True, slots=True)
class Relation:
    """One relation between elements.

    Attributes:
        curie: Its name ("sk:heldBy").
        label: What people call it.
        comment: What it means.
        parents: Its direct super-relations, sorted.
        domain, range: Class that the subject and the object must be of, or None for anything.
        family: What it is for.
        place_end: For a placement, the end that is the place; None for the others.
        functional: True when a subject has at most one object; relating it anew replaces the old one.
    """

    curie: str
    label: str
    comment: str
    parents: tuple[str, ...]
    domain: str | None
    range: str | None
    family: Family
    place_end: PlaceEnd | None
    functional: bool


@dataclass(frozen=True, slots=True)
class Property:
    """One property of elements.

    Attributes:
        curie: Its name ("sk:mass").
        label: What people call it.
        comment: What it means, with its unit.
        domain: Class that bears it, or None for any.
        range: CURIE of its data type, one of :data:`~skiros_py.world.literals.DATATYPES`.
    """

    curie: str
    label: str
    comment: str
    domain: str | None
    range: str
