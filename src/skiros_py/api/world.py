"""The world on the wire: elements and their values, changes, taught data, locks."""

from __future__ import annotations

import math
from datetime import datetime
from typing import Annotated, Any, Literal, Self

from pydantic import AfterValidator, ConfigDict, Field, StrictBool, StrictInt, model_validator

from skiros_py.api.wire import Answer, Page, Request, Sentence, Told

EVERYTHING = "sk:Element"
"""The class of all elements."""
_FARTHEST = 1e6
"""No coordinate is farther from its frame than this [m]: simulators and planners break beyond."""
_OFF = 1e-3
"""How far from 1 the length of a quaternion may be: clients round."""

Name = Annotated[str, Field(min_length=1, max_length=300)]
"""A CURIE of the ontology, such as ``kitting:Starter``."""

ElementId = Annotated[str, Field(min_length=1, max_length=300)]
"""Id of an element, such as ``starter_1``; with a prefix for abstract ones (``learned:mug_1``)."""

Reason = Annotated[str, Field(max_length=1000)]
"""Reason of a write, for people."""

Number = Annotated[float, Field(strict=True, allow_inf_nan=False)]


def _normalised(value: tuple[float, float, float, float]) -> tuple[float, float, float, float]:
    length = math.hypot(*value)
    if not abs(length - 1.0) <= _OFF:
        raise ValueError(f"a rotation is a quaternion of length 1 (x, y, z, w), and this has {length:g}")
    x, y, z, w = value
    return x / length, y / length, z / length, w / length


_Component = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=-1.0 - _OFF, le=1.0 + _OFF)]
Rotation = Annotated[tuple[_Component, _Component, _Component, _Component], AfterValidator(_normalised)]
"""A unit quaternion x, y, z, w in a request."""
Coordinate = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=-_FARTHEST, le=_FARTHEST)]


class Placement(Request):
    """The place of an element: one across the whole family of placements."""

    relation: Name = Field(examples=["sk:in"])
    """The placement relation."""
    place: ElementId = Field(examples=["pallet_a"])
    """Id of the place."""


class Pose(Answer):
    """The pose of a frame in another frame."""

    position: tuple[float, float, float] = Field(examples=[[5.0, 1.6, 0.0]])
    """x, y, z [m]."""
    orientation: tuple[float, float, float, float] = Field(examples=[[0.0, 0.0, 0.0, 1.0]])
    """Unit quaternion x, y, z, w."""
    frame: str | None = None
    """Id of the reference element; null for the map, or if given elsewhere."""


class GivenPose(Request):
    """A pose in a request."""

    position: tuple[Coordinate, Coordinate, Coordinate] = Field(examples=[[5.0, 1.6, 0.0]])
    """x, y, z [m], at most 1000 km from the frame."""
    orientation: Rotation = Field(default=(0.0, 0.0, 0.0, 1.0), examples=[[0.0, 0.0, 0.0, 1.0]])
    """Unit quaternion x, y, z, w; the identity if omitted."""
    frame: ElementId | None = None
    """For sk:pose: id of the reference element; null for the map; unchanged if omitted."""


GivenValue = (
    StrictBool
    | StrictInt
    | Number
    | GivenPose
    | Annotated[list[Number], Field(max_length=2048)]
    | Annotated[str, Field(max_length=65536)]
)
"""A value in a request; the ontology determines the data type of the property."""

Value = Any
"""A value in a response: a text, a number, true or false, a list of numbers, or a pose (see :class:`Pose`)."""


class NamedElement(Answer):
    """An element, as it is named in lists, trees and pictures."""

    id: str = Field(examples=["starter_1"])
    """Its id; never reused."""
    class_: str = Field(validation_alias="class", serialization_alias="class", examples=["kitting:Starter"])
    """Its most specific class."""
    label: str = Field(examples=["starter"])
    """Its label."""


class ElementSummary(NamedElement):
    """One element in a list."""

    placement: Placement | None
    """Its place; null for abstract elements and parts."""
    abstract: bool
    """True for individuals of the ontology and learned concepts, which are not in the scene."""
    version: int = Field(examples=[17])
    """Number of its last change; its ETag."""


class Property(Answer):
    """The value of a property of an element."""

    value: Value = Field(examples=[0.4])
    """The value; poses as position and orientation."""
    origin: Literal["own", "taught", "class"]
    """Whether it is the element's own, taught for its class, or given by its class."""
    taught_by: str | None = None
    """Id of the learned concept, for a taught value."""


class Relation(Answer):
    """A relation that holds."""

    subject: str = Field(examples=["starter_1"])
    """Id of the subject."""
    relation: str = Field(examples=["sk:in"])
    """The relation."""
    object: str = Field(examples=["pallet_a"])
    """Id of the object."""
    family: str = Field(examples=["placement"])
    """Family of the relation: "placement", "structure", "computed" or "plain"."""


class ElementDetails(ElementSummary):
    """An element with its values and relations."""

    changed_at: float = Field(examples=[12.5])
    """When it was changed last [s, run time]."""
    properties: dict[str, Property]
    """Values by property."""
    relations: list[Relation]
    """Its stated relations, in both directions: the first 200."""
    relations_total: int
    """Number of its stated relations."""
    computed: list[Relation]
    """The requested computed relations: the first 200 of each, in both directions."""
    owner: str | None
    """Id of its whole; null for none."""
    map_pose: Pose | None
    """Its pose in the map; null if unknown."""


ElementPage = Page[ElementSummary]
"""Some elements, in the order of their ids."""


RelationPage = Page[Relation]
"""Some relations, in order."""


class NewRelation(Request):
    """A relation of a new element, which is the omitted end."""

    subject: ElementId | None = Field(default=None, examples=["kit_1"])
    """Id of the subject."""
    relation: Name = Field(examples=["sk:hasA"])
    """The relation."""
    object: ElementId | None = None
    """Id of the object."""


class Addition(Request):
    """A new element."""

    class_: Name | None = Field(
        default=None, validation_alias="class", serialization_alias="class", examples=["kitting:Starter"]
    )
    """Its class; not together with `like`."""
    like: ElementId | None = Field(default=None, examples=["kitting:standard_kit"])
    """Id of an element or abstract individual to copy with its parts, instead of a class."""
    id: ElementId | None = None
    """Its id; generated from its class if omitted. The id of a copy is always generated."""
    label: Annotated[str, Field(min_length=1, max_length=1000)] | None = None
    """Its label; the name of its class if omitted."""
    properties: Annotated[dict[Name, GivenValue], Field(max_length=200)] = Field(
        default_factory=dict, examples=[{"sk:mass": 0.4}]
    )
    """Own values by property."""
    placement: Placement | None = None
    """Its place."""
    relations: Annotated[list[NewRelation], Field(max_length=200)] = Field(default_factory=list)
    """Its relations, such as that to its whole."""

    @model_validator(mode="after")
    def _says_what(self) -> Self:
        if (self.class_ is None) == (self.like is None):
            raise ValueError("say what is added: either 'class', or 'like' for a copy")
        if self.like is not None and self.id is not None:
            raise ValueError("a copy gets the next id of its class: leave out 'id'")
        return self


class NewElement(Addition):
    """An element to be added."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {
                    "class": "kitting:Starter",
                    "label": "spare starter",
                    "placement": {"relation": "sk:in", "place": "pallet_a"},
                    "reason": "delivered this morning",
                },
                {"like": "kitting:standard_kit", "placement": {"relation": "sk:on", "place": "kit_table"}},
            ]
        },
    )

    reason: Reason = Field(default="", examples=["delivered this morning"])
    """Reason, for people."""


class ElementPatch(Request):
    """Changes of an element, as one change; omitted values are kept."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {
                    "label": "starter, dented",
                    "properties": {"sk:mass": 0.41, "sk:pose": {"position": [0.1, 0.0, 0.0], "frame": "pallet_a"}},
                    "placement": {"relation": "sk:in", "place": "pallet_a"},
                    "reason": "weighed",
                }
            ]
        },
    )

    label: Annotated[str, Field(min_length=1, max_length=1000)] | None = None
    """Its label."""
    properties: Annotated[dict[Name, GivenValue | None], Field(max_length=200)] = Field(
        default_factory=dict, examples=[{"sk:mass": 0.4, "sk:graspHeight": None}]
    )
    """Own values by property; null removes the own value."""
    placement: Placement | None = None
    """Its new place."""
    reason: Reason = Field(default="", examples=["weighed"])
    """Reason, for people."""


class TreeNode(NamedElement):
    """An element with the elements placed there and its parts; the root of the world has the id ""."""

    model_config = ConfigDict(frozen=False)

    relation: str = Field(examples=["sk:on"])
    """Its relation to the parent node."""
    version: int
    """Number of its last change; its ETag."""
    children: list[TreeNode]
    """Its children, in the order of ids; may be incomplete."""
    children_total: int
    """Number of its children."""
    next: str | None
    """If children are missing: the cursor for reading on, together with root=<id>."""


Version = Annotated[int, Field(strict=True, ge=0, le=2**62)]
"""Number of a change."""


class Change(Told):
    """A change: one transaction."""

    number: int = Field(examples=[17])
    """Its number, from 1 without gaps; the version of the world after it."""
    author: str = Field(examples=["ann"])
    """Its author."""
    writer: str = Field(examples=["person"])
    """Kind of author: "person", "skill", "job" or "system"."""
    reason: Sentence = Field(examples=["delivered this morning"])
    """Reason, for people."""
    time: float = Field(examples=[12.5])
    """When [s, run time]."""
    written: datetime | None = None
    """When (UTC); null if not stored."""
    undoes: int | None = None
    """Number of the change that it reverted."""
    edits: list[dict[str, Any]] = Field(
        examples=[
            [
                {
                    "edit": "placement",
                    "element": "starter_1",
                    "old": {"relation": "sk:in", "place": "pallet_a"},
                    "new": {"relation": "sk:in", "place": "kit_1_a"},
                }
            ]
        ]
    )
    """The edits, each with its old and new value, and its kind as "edit": "element", "placement", "property",
    "relation", "goals" or "source" (the file of the scene). Perhaps not all.
    """
    edits_total: int
    """Number of its edits."""
    next: str | None = None
    """If edits are missing: the cursor for reading on at /world/changes/{number}."""


class ChangePage(Page[Change]):
    """Some changes."""

    remembered_from: int
    """Number of the oldest stored change."""
    version: int
    """Number of the latest change."""


class Undoable(Answer):
    """The change that an undo would revert."""

    number: int = Field(examples=[17])
    """Its number."""
    author: str = Field(examples=["ann"])
    """Its author."""
    reason: Sentence = Field(examples=["delivered this morning"])
    """Reason, for people."""


class WorldInfo(Told):
    """Version and size of the world."""

    version: int = Field(examples=[17])
    """Number of the latest change; the world's ETag."""
    time: float = Field(examples=[12.5])
    """Current run time [s]."""
    elements: int
    """Number of elements of the scene."""
    abstract: int
    """Number of individuals of the ontology."""
    learned: int
    """Number of learned concepts."""
    goals: int
    """Number of goals stored with the scene."""
    locks: int
    """Number of locks."""
    remembered_from: int
    """Number of the oldest stored change."""
    undoable: Undoable | None
    """The change that an undo would revert."""
    redoable: Undoable | None
    """The undo that a redo would revert."""


class Written(Told):
    """Result of a write."""

    version: int = Field(examples=[18])
    """Version of the world after it."""
    change: Change | None
    """The change; null if there was nothing to change."""
    ids: dict[str, str] = Field(default_factory=dict)
    """Ids of added elements, by ref."""


class UndoOrder(Request):
    """The change to undo, or the undo to revert by a redo."""

    change: Version | None = Field(default=None, examples=[17])
    """Only if this change is the next one."""


class Learned(NamedElement):
    """A learned concept, which persists beyond this scene."""

    about: str | None = Field(examples=["kitting:Starter"])
    """The class to which it applies."""
    properties: dict[str, Any]
    """Values by property."""
    version: int = Field(examples=[17])
    """Number of its last change; its ETag."""


LearnedPage = Page[Learned]
"""Some learned concepts, in the order of ids."""


class Lock(Answer):
    """A lock: the exclusive right of a person or job to edit an element."""

    element: str = Field(examples=["kit_1"])
    """Id of the element; its parts are locked with it."""
    owner: str = Field(examples=["ann"])
    """Its owner."""
    until: datetime
    """When it expires (UTC)."""
    seconds: float = Field(examples=[59.2])
    """Remaining time [s]."""


LockList = Page[Lock]
"""The locks, by element."""


class LockOrder(Request):
    """Elements to lock."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"elements": ["kit_1"], "seconds": 60.0}]})

    elements: Annotated[list[ElementId], Field(min_length=1, max_length=1000)] = Field(examples=[["kit_1"]])
    """Ids of the elements: all are locked, or none."""
    seconds: Annotated[float, Field(gt=0.0, le=86400.0, allow_inf_nan=False)] = 60.0
    """Duration of the locks [s]; at most a day."""
