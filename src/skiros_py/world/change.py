"""What one transaction changed: who, why, when, and every old and new value."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import Any

from skiros_py.geometry import Pose
from skiros_py.world.element import Element, Placement, Value

__all__ = ["Change", "Edit", "ElementEdit", "GoalsEdit", "PlacementEdit", "PropertyEdit", "RelationEdit", "Writer"]


_Json = dict[str, Any]


class Writer(StrEnum):
    """What kind of author wrote: locks keep people and jobs out, only what people wrote can be undone."""

    SKILL = "skill"
    """A running skill or primitive reports what it sensed or did: nothing may keep it from that."""
    PERSON = "person"
    """Somebody edits what is believed."""
    JOB = "job"
    """An order from outside."""
    SYSTEM = "system"
    """The platform itself: a scene is loaded, a skill manager registers."""


@dataclass(frozen=True, slots=True)
class ElementEdit:
    """An element came (``old`` is None, ``new`` has its first properties) or went (``new`` is None)."""

    element: str
    old: Element | None
    new: Element | None

    def marks(self) -> tuple[str, ...]:
        """Returns the elements that it changes."""
        return (self.element,)

    def concerns(self) -> tuple[str, ...]:
        """Returns the elements that it changes or where it puts them."""
        return (self.element,)

    def inverse(self) -> ElementEdit:
        """Returns the edit that takes it back."""
        return ElementEdit(self.element, self.new, self.old)

    def as_json(self) -> _Json:
        """Returns plain data."""
        return {"edit": "element", "element": self.element, "old": _element(self.old), "new": _element(self.new)}


@dataclass(frozen=True, slots=True)
class PlacementEdit:
    """An element moved; ``old`` is None for one that has just come, ``new`` for one that goes."""

    element: str
    old: Placement | None
    new: Placement | None

    def marks(self) -> tuple[str, ...]:
        """Returns the elements that it changes."""
        return (self.element,)

    def concerns(self) -> tuple[str, ...]:
        """Returns the elements that it changes or where it puts them."""
        return (self.element, *(placement.place for placement in (self.old, self.new) if placement))

    def inverse(self) -> PlacementEdit:
        """Returns the edit that takes it back."""
        return PlacementEdit(self.element, self.new, self.old)

    def as_json(self) -> _Json:
        """Returns plain data."""
        return {"edit": "placement", "element": self.element, "old": _place(self.old), "new": _place(self.new)}


@dataclass(frozen=True, slots=True)
class RelationEdit:
    """A relation (of any family but placement) came to hold or ceased to."""

    subject: str
    relation: str
    object: str
    old: bool
    new: bool

    def marks(self) -> tuple[str, ...]:
        """Returns the elements that it changes."""
        return (self.subject, self.object)

    def concerns(self) -> tuple[str, ...]:
        """Returns the elements that it changes or where it puts them."""
        return (self.subject, self.object)

    def inverse(self) -> RelationEdit:
        """Returns the edit that takes it back."""
        return RelationEdit(self.subject, self.relation, self.object, self.new, self.old)

    def as_json(self) -> _Json:
        """Returns plain data."""
        ends = {"subject": self.subject, "relation": self.relation, "object": self.object}
        return {"edit": "relation", **ends, "old": self.old, "new": self.new}


@dataclass(frozen=True, slots=True)
class PropertyEdit:
    """An element's own value of a property changed; None is "no own value". ``rdfs:label`` counts as a property."""

    element: str
    property: str
    old: Value | None
    new: Value | None

    def marks(self) -> tuple[str, ...]:
        """Returns the elements that it changes."""
        return (self.element,)

    def concerns(self) -> tuple[str, ...]:
        """Returns the elements that it changes or where it puts them."""
        return (self.element,)

    def inverse(self) -> PropertyEdit:
        """Returns the edit that takes it back."""
        return PropertyEdit(self.element, self.property, self.new, self.old)

    def as_json(self) -> _Json:
        """Returns plain data."""
        what = {"element": self.element, "property": self.property}
        return {"edit": "property", **what, "old": _value(self.old), "new": _value(self.new)}


@dataclass(frozen=True, slots=True)
class GoalsEdit:
    """The goals that go with the scene became others (texts, sorted)."""

    old: tuple[str, ...]
    new: tuple[str, ...]

    def marks(self) -> tuple[str, ...]:
        """Returns the elements that it changes: none."""
        return ()

    def concerns(self) -> tuple[str, ...]:
        """Returns the elements that it changes or where it puts them: none."""
        return ()

    def inverse(self) -> GoalsEdit:
        """Returns the edit that takes it back."""
        return GoalsEdit(self.new, self.old)

    def as_json(self) -> _Json:
        """Returns plain data."""
        return {"edit": "goals", "old": list(self.old), "new": list(self.new)}


Edit = ElementEdit | PlacementEdit | RelationEdit | PropertyEdit | GoalsEdit


@dataclass(frozen=True, slots=True)
class Change:
    """One transaction that took effect.

    Attributes:
        number: Counted from 1 without gaps; the world's version afterwards.
        author: Who wrote (a skill, a person, "scene").
        reason: Why, in words for people.
        time: When [s, simulated].
        edits: What changed, net, in an order in which it can be done again.
        writer: What kind of author that is.
        undoes: Number of the change that this one took back, or None.
    """

    number: int
    author: str
    reason: str
    time: float
    edits: tuple[Edit, ...]
    writer: Writer = Writer.SKILL
    undoes: int | None = None

    def marks(self) -> frozenset[str]:
        """Returns the elements that it changed: properties, placement or relations."""
        return frozenset(name for edit in self.edits for name in edit.marks())

    def as_json(self) -> _Json:
        """Returns plain data; equal changes give equal data in equal order."""
        return {
            "number": self.number,
            "author": self.author,
            "writer": self.writer.value,
            "reason": self.reason,
            "time": self.time,
            "undoes": self.undoes,
            "edits": [edit.as_json() for edit in self.edits],
        }


def _element(element: Element | None) -> _Json | None:
    if element is None:
        return None
    properties = {name: _value(element.properties[name]) for name in sorted(element.properties)}
    return {"id": element.id, "type": element.type, "label": element.label, "properties": properties}


def _place(placement: Placement | None) -> _Json | None:
    return None if placement is None else {"relation": placement.relation, "place": placement.place}


def _value(value: Value | None) -> object:
    if isinstance(value, Pose):
        return {"position": list(value.position), "orientation": list(value.orientation)}
    return list(value) if isinstance(value, tuple) else value
