"""A change made by one transaction: author, reason, time, and every old and new value."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import Any, ClassVar, NamedTuple, Self

from skiros_py.geometry import Pose
from skiros_py.world.element import Element, Placement, Value

_Json = dict[str, Any]


class Writer(StrEnum):
    """The kind of author: locks apply to users and jobs; only users' changes can be undone."""

    SKILL = "skill"
    """A running skill or primitive reports what it sensed or did: never blocked by locks."""
    PERSON = "person"
    """A user edits the world model."""
    JOB = "job"
    """An order from outside."""
    SYSTEM = "system"
    """The platform itself: a scene is loaded, a skill manager registers."""


class _Edit:
    """Common base of edits: each has an ``old`` and a ``new`` side.

    Attributes:
        kind: Its name in plain data.
    """

    __slots__: tuple[str, ...] = ()
    kind: ClassVar[str]

    def marks(self) -> tuple[str, ...]:
        """Returns the elements that it changes."""
        return (self.element,) if hasattr(self, "element") else ()

    def concerns(self) -> tuple[str, ...]:
        """Returns the elements that it changes, and their places."""
        return self.marks()

    def inverse(self) -> Self:
        """Returns the edit that reverts it."""
        return replace(self, old=self.new, new=self.old)  # type: ignore[type-var,attr-defined]

    def as_json(self) -> _Json:
        """Returns plain data: the kind, then the fields in order."""
        return {"edit": self.kind, **{name: _plain(getattr(self, name)) for name in self.__slots__}}


@dataclass(frozen=True, slots=True)
class ElementEdit(_Edit):
    """An element was added (``old`` is None, ``new`` has its first properties) or removed (``new`` is None)."""

    kind: ClassVar[str] = "element"
    element: str
    old: Element | None
    new: Element | None


@dataclass(frozen=True, slots=True)
class PlacementEdit(_Edit):
    """An element moved; ``old`` is None for one just added, ``new`` for one being removed."""

    kind: ClassVar[str] = "placement"
    element: str
    old: Placement | None
    new: Placement | None

    def concerns(self) -> tuple[str, ...]:
        """Returns the elements that it changes, and their places."""
        return (self.element, *(placement.place for placement in (self.old, self.new) if placement))


@dataclass(frozen=True, slots=True)
class RelationEdit(_Edit):
    """A relation (of any family except placement) was added or removed."""

    kind: ClassVar[str] = "relation"
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

    kind: ClassVar[str] = "property"
    element: str
    property: str
    old: Value | None
    new: Value | None


@dataclass(frozen=True, slots=True)
class GoalsEdit(_Edit):
    """The goals stored with the scene changed (texts, sorted)."""

    kind: ClassVar[str] = "goals"
    old: tuple[str, ...]
    new: tuple[str, ...]


class SceneSource(NamedTuple):
    """The file that a scene was last loaded from or saved to.

    Attributes:
        name: Name of the scene; empty for an upload, or if unknown.
        checksum: Checksum of the file.
    """

    name: str = ""
    checksum: int = 0


@dataclass(frozen=True, slots=True)
class SourceEdit(_Edit):
    """The scene was loaded from another file, or saved to it."""

    kind: ClassVar[str] = "source"
    old: SceneSource
    new: SceneSource


Edit = ElementEdit | PlacementEdit | RelationEdit | PropertyEdit | GoalsEdit | SourceEdit


@dataclass(frozen=True, slots=True)
class Change:
    """One transaction that took effect.

    Attributes:
        number: Counted from 1 without gaps; the world's version afterwards.
        author: The author (a skill, a user, "scene").
        reason: Why, in readable form.
        time: When [s, simulated].
        edits: The net edits, in an order in which they can be reapplied.
        writer: The kind of author.
        undoes: Number of the change that this one reverts, or None.
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


def _plain(value: Any) -> object:
    plain = _PLAIN.get(type(value))
    return value if plain is None else plain(value)


_PLAIN: Mapping[type, Callable[[Any], object]] = {
    tuple: list,
    SceneSource: list,
    Pose: lambda pose: {"position": list(pose.position), "orientation": list(pose.orientation)},
    Placement: lambda placement: {"relation": placement.relation, "place": placement.place},
    Element: lambda element: {
        "id": element.id,
        "type": element.type,
        "label": element.label,
        "properties": {name: _plain(element.properties[name]) for name in sorted(element.properties)},
    },
}
"""Converters to plain data for types that JSON lacks: one look-up per value."""
