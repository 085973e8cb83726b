"""What one transaction changed: who, why, when, and every old and new value."""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import StrEnum
from typing import Any, ClassVar, Self

from skiros_py.geometry import Pose
from skiros_py.world.element import Element, Placement, Value

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


class _Edit:
    """What the kinds of edit share: each has an ``old`` and a ``new`` side."""

    __slots__ = ()
    kind: ClassVar[str]

    def marks(self) -> tuple[str, ...]:
        """Returns the elements that it changes."""
        return (self.element,)  # type: ignore[attr-defined]  # edits of other things override this

    def concerns(self) -> tuple[str, ...]:
        """Returns the elements that it changes or where it puts them."""
        return self.marks()

    def inverse(self) -> Self:
        """Returns the edit that takes it back."""
        return replace(self, old=self.new, new=self.old)  # type: ignore[type-var,attr-defined]

    def as_json(self) -> _Json:
        """Returns plain data."""
        names: tuple[str, ...] = self.__match_args__  # type: ignore[attr-defined]  # of every dataclass
        return {"edit": self.kind, **{name: _plain(getattr(self, name)) for name in names}}


@dataclass(frozen=True, slots=True)
class ElementEdit(_Edit):
    """An element came (``old`` is None, ``new`` has its first properties) or went (``new`` is None)."""

    kind: ClassVar = "element"
    element: str
    old: Element | None
    new: Element | None


@dataclass(frozen=True, slots=True)
class PlacementEdit(_Edit):
    """An element moved; ``old`` is None for one that has just come, ``new`` for one that goes."""

    kind: ClassVar = "placement"
    element: str
    old: Placement | None
    new: Placement | None

    def concerns(self) -> tuple[str, ...]:
        """Returns the elements that it changes or where it puts them."""
        return (self.element, *(placement.place for placement in (self.old, self.new) if placement))


@dataclass(frozen=True, slots=True)
class RelationEdit(_Edit):
    """A relation (of any family but placement) came to hold or ceased to."""

    kind: ClassVar = "relation"
    subject: str
    relation: str
    object: str
    old: bool
    new: bool

    def marks(self) -> tuple[str, ...]:
        """Returns the elements that it changes."""
        return (self.subject, self.object)


@dataclass(frozen=True, slots=True)
class PropertyEdit(_Edit):
    """An element's own value of a property changed; None is "no own value". ``rdfs:label`` counts as a property."""

    kind: ClassVar = "property"
    element: str
    property: str
    old: Value | None
    new: Value | None


@dataclass(frozen=True, slots=True)
class GoalsEdit(_Edit):
    """The goals that go with the scene became others (texts, sorted)."""

    kind: ClassVar = "goals"
    old: tuple[str, ...]
    new: tuple[str, ...]

    def marks(self) -> tuple[str, ...]:
        """Returns the elements that it changes: none."""
        return ()


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


def _plain(value: Element | Placement | Value | None) -> object:
    if isinstance(value, tuple):
        return list(value)
    if isinstance(value, Pose):
        return {"position": list(value.position), "orientation": list(value.orientation)}
    if isinstance(value, Placement):
        return {"relation": value.relation, "place": value.place}
    if isinstance(value, Element):
        properties = {name: _plain(value.properties[name]) for name in sorted(value.properties)}
        return {"id": value.id, "type": value.type, "label": value.label, "properties": properties}
    return value
