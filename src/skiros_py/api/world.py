"""The world on the wire: elements and their values, changes and transactions, taught data, locks."""

from __future__ import annotations

import math
from datetime import datetime
from typing import Annotated, Any, Literal, Self

from pydantic import ConfigDict, Field, StrictBool, StrictInt, field_validator, model_validator

from skiros_py.api.wire import Answer, Items, Page, Request

EVERYTHING = "sk:Element"
"""The class of all elements."""
_FARTHEST = 1e6
"""No coordinate is farther from its frame than this [m]: simulators and planners break beyond."""
_OFF = 1e-3
"""How far from 1 the length of a quaternion may be: clients round."""

Name = Annotated[str, Field(min_length=1, max_length=300)]
"""A CURIE of the ontology, such as ``kitting:Starter``."""

ElementId = Annotated[str, Field(min_length=1, max_length=300)]
"""Id of an element, such as ``starter_1``; with a prefix for what is abstract (``learned:mug_1``)."""

Reason = Annotated[str, Field(max_length=1000)]
"""Why something is written, for people."""

Number = Annotated[float, Field(strict=True, allow_inf_nan=False)]
Coordinate = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=-_FARTHEST, le=_FARTHEST)]


class Placement(Request):
    """Where an element is: it has one place across the whole family of placements."""

    relation: Name = Field(examples=["sk:in"])
    """The placement relation."""
    place: ElementId = Field(examples=["pallet_a"])
    """Id of the place."""


class Pose(Answer):
    """Where a frame is, seen from another."""

    position: tuple[float, float, float] = Field(examples=[[5.0, 1.6, 0.0]])
    """x, y, z [m]."""
    orientation: tuple[float, float, float, float] = Field(examples=[[0.0, 0.0, 0.0, 1.0]])
    """Unit quaternion x, y, z, w."""
    frame: str | None = None
    """Element in whose frame it is given; null for the map, or where that is said elsewhere."""


class GivenPose(Request):
    """A pose that somebody writes."""

    position: tuple[Coordinate, Coordinate, Coordinate] = Field(examples=[[5.0, 1.6, 0.0]])
    """x, y, z [m], at most 1000 km from the frame."""
    orientation: tuple[Number, Number, Number, Number] = Field(
        default=(0.0, 0.0, 0.0, 1.0), examples=[[0.0, 0.0, 0.0, 1.0]]
    )
    """Unit quaternion x, y, z, w; not turned where left out."""
    frame: ElementId | None = None
    """For sk:pose: the element in whose frame it is given; null for the map. Left out, it stays the one that it is now.
    """

    @field_validator("orientation")
    @classmethod
    def _is_a_rotation(cls, value: tuple[float, float, float, float]) -> tuple[float, float, float, float]:
        length = math.hypot(*value)
        if not abs(length - 1.0) <= _OFF:
            raise ValueError(f"a rotation is a quaternion of length 1 (x, y, z, w), and this has {length:g}")
        x, y, z, w = value
        return x / length, y / length, z / length, w / length


GivenValue = (
    StrictBool
    | StrictInt
    | Number
    | GivenPose
    | Annotated[list[Number], Field(max_length=2048)]
    | Annotated[str, Field(max_length=65536)]
)
"""A value that somebody writes; what a property takes, its data type in the ontology says."""

Value = Any
"""A value that is told: a text, a number, true or false, a list of numbers, or a pose (see :class:`Pose`)."""


class ElementSummary(Answer):
    """One element in a list."""

    id: str = Field(examples=["starter_1"])
    """Its id; never used again after removal."""
    class_: str = Field(validation_alias="class", serialization_alias="class", examples=["kitting:Starter"])
    """Its most specific class."""
    label: str = Field(examples=["starter"])
    """What people call it."""
    placement: Placement | None
    """Where it is; null for what is nowhere, or goes with its owner."""
    abstract: bool
    """True for what the ontology describes or what was learned, not really there."""
    version: int = Field(examples=[17])
    """Number of the change that touched it last; its ETag."""


class Property(Answer):
    """What an element has as the value of a property."""

    value: Value = Field(examples=[0.4])
    """The value; poses as position and orientation."""
    origin: Literal["own", "taught", "class"]
    """Whether the element has it itself, it was taught for its class, or its class gives it."""
    taught_by: str | None = None
    """For what was taught: the learned element that says it."""


class Relation(Answer):
    """A relation that holds."""

    subject: str = Field(examples=["starter_1"])
    """Id of the subject."""
    relation: str = Field(examples=["sk:in"])
    """The relation."""
    object: str = Field(examples=["pallet_a"])
    """Id of the object."""
    family: str = Field(examples=["placement"])
    """What the relation is for: "placement", "structure", "computed" or "plain"."""


class ElementDetails(ElementSummary):
    """Everything about one element."""

    changed_at: float = Field(examples=[12.5])
    """When it was changed last [s, run time]."""
    properties: dict[str, Property]
    """Values by property."""
    relations: list[Relation]
    """What is stated of it, in both directions: the first 200."""
    relations_total: int
    """How many relations are stated of it."""
    computed: list[Relation]
    """Computed relations, those that were asked for: of each the first 200 in either direction."""
    owner: str | None
    """What it is a piece of."""
    map_pose: Pose | None
    """Its pose in the map, where that is known."""


ElementPage = Page[ElementSummary]
"""Some elements, in the order of their ids."""


RelationPage = Page[Relation]
"""Some relations, in order."""


class NewRelation(Request):
    """A relation of a new element: the end that is left out is the element."""

    subject: ElementId | None = Field(default=None, examples=["kit_1"])
    """Id of the subject."""
    relation: Name = Field(examples=["sk:hasA"])
    """The relation."""
    object: ElementId | None = None
    """Id of the object."""


class Addition(Request):
    """What is added."""

    class_: Name | None = Field(
        default=None, validation_alias="class", serialization_alias="class", examples=["kitting:Starter"]
    )
    """Its class; not together with `like`."""
    like: ElementId | None = Field(default=None, examples=["kitting:standard_kit"])
    """Copied with its pieces: an abstract individual, or another element. Instead of a class."""
    id: ElementId | None = None
    """Its id; the next of its class where left out. A copy always gets the next one."""
    label: Annotated[str, Field(min_length=1, max_length=1000)] | None = None
    """What people call it; its class's name where left out."""
    properties: Annotated[dict[Name, GivenValue], Field(max_length=200)] = Field(
        default_factory=dict, examples=[{"sk:mass": 0.4}]
    )
    """Own values by property."""
    placement: Placement | None = None
    """Where it is."""
    relations: Annotated[list[NewRelation], Field(max_length=200)] = Field(default_factory=list)
    """Relations of it, such as whose piece it is."""

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
    """Why, for people."""


class ElementPatch(Request):
    """What becomes different of an element, all at once; what is left out stays."""

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
    """What people call it."""
    properties: Annotated[dict[Name, GivenValue | None], Field(max_length=200)] = Field(
        default_factory=dict, examples=[{"sk:mass": 0.4, "sk:graspHeight": None}]
    )
    """Own values by property; null takes the own value away."""
    placement: Placement | None = None
    """Where it is from now on."""
    reason: Reason = Field(default="", examples=["weighed"])
    """Why, for people."""


class TreeNode(Answer):
    """An element with what is placed there and what it is built of."""

    id: str = Field(examples=["pallet_a"])
    """Its id; "" for the node above everything."""
    class_: str = Field(validation_alias="class", serialization_alias="class", examples=["kitting:Pallet"])
    """Its class."""
    label: str = Field(examples=["pallet A"])
    """What people call it."""
    relation: str = Field(examples=["sk:on"])
    """The relation by which it hangs on the node above."""
    version: int
    """Number of the change that touched it last; its ETag."""
    children: list[TreeNode]
    """What hangs on it, in the order of ids; perhaps not all."""
    children_total: int
    """How many hang on it."""
    next: str | None
    """Where not all children are here: the cursor to go on with, together with root=<id>."""


_MOST_OPERATIONS = 1000

Version = Annotated[int, Field(strict=True, ge=0, le=2**62)]
"""Number of a change."""


class Change(Answer):
    """One transaction that took effect."""

    number: int = Field(examples=[17])
    """Counted from 1 without gaps; the world's version afterwards."""
    author: str = Field(examples=["ann"])
    """Who wrote."""
    writer: str = Field(examples=["person"])
    """What kind of author: "person", "skill", "job" or "system"."""
    reason: str = Field(examples=["delivered this morning"])
    """Why, for people."""
    time: float = Field(examples=[12.5])
    """When [s, run time]."""
    written: datetime | None = None
    """When (UTC), where that is remembered."""
    undoes: int | None = None
    """Number of the change that this one took back."""
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
    """What changed, each with its old and new value; "edit" tells what kind it is: "element", "placement", "property",
    "relation", "goals" or "source" (the file of the scene). Perhaps not all.
    """
    edits_total: int
    """How many edits it has."""
    next: str | None = None
    """Where not all edits are here: the cursor to read on with at /world/changes/{number}."""


class ChangePage(Answer):
    """Some changes."""

    items: list[Change]
    """The changes."""
    next: str | None
    """Cursor of the next page; null at the end."""
    remembered_from: int
    """Number of the oldest change that is remembered."""
    version: int
    """Number of the latest change."""


class Undoable(Answer):
    """The change that an undo would take back."""

    number: int = Field(examples=[17])
    """Its number."""
    author: str = Field(examples=["ann"])
    """Who wrote it."""
    reason: str = Field(examples=["delivered this morning"])
    """Why."""


class WorldInfo(Answer):
    """What there is, in numbers."""

    version: int = Field(examples=[17])
    """Number of the latest change; the world's ETag."""
    time: float = Field(examples=[12.5])
    """Run time now [s]."""
    elements: int
    """Elements of the scene."""
    abstract: int
    """Individuals that the ontology describes."""
    learned: int
    """Individuals that robots were taught."""
    goals: int
    """Goals that go with the scene."""
    locks: int
    """Locks in force."""
    remembered_from: int
    """Number of the oldest change that is remembered."""
    undoable: Undoable | None
    """What an undo would take back."""


class Written(Answer):
    """What a write did."""

    version: int = Field(examples=[18])
    """The world's version now."""
    change: Change | None
    """The change; null where everything was so already."""
    ids: dict[str, str] = Field(default_factory=dict)
    """Ids of what was added, by its ref."""


class UndoOrder(Request):
    """Which change is meant."""

    change: Version | None = Field(default=None, examples=[17])
    """Take it back only if it is this one that comes next."""


# ------------------------------------------------------------------ transactions

Target = Annotated[str, Field(min_length=1, max_length=300)]
"""Id of an element, or "$" and the ref of one that was added before in the same transaction."""


class AddOperation(Addition):
    """Adds an element."""

    op: Literal["add"]
    """What is done."""
    ref: Annotated[str, Field(pattern="^[a-z][a-z0-9_]{0,49}$")] | None = None
    """A name for later operations of this transaction, which write "$name"."""


class RemoveOperation(Request):
    """Removes an element with its pieces; what was placed there moves to where it was."""

    op: Literal["remove"]
    """What is done."""
    element: Target = Field(examples=["starter_1"])
    """Which one."""


class SetOperation(Request):
    """Sets an element's own value of a property; ``rdfs:label`` is its label."""

    op: Literal["set"]
    """What is done."""
    element: Target = Field(examples=["starter_1"])
    """Which one."""
    property: Name = Field(examples=["sk:mass"])
    """Which property."""
    value: GivenValue | None = Field(examples=[0.4])
    """The value; null takes the own value away."""


class PlaceOperation(Request):
    """Moves an element."""

    op: Literal["place"]
    """What is done."""
    element: Target = Field(examples=["starter_1"])
    """Which one."""
    relation: Name = Field(examples=["sk:in"])
    """The placement relation."""
    place: Target = Field(examples=["pallet_b"])
    """Where to."""


class RelateOperation(Request):
    """States a relation; a placement moves its element."""

    op: Literal["relate"]
    """What is done."""
    subject: Target = Field(examples=["kit_1"])
    """The subject."""
    relation: Name = Field(examples=["sk:hasA"])
    """The relation."""
    object: Target = Field(examples=["kit_1_a"])
    """The object."""


class UnrelateOperation(Request):
    """Takes back a stated relation."""

    op: Literal["unrelate"]
    """What is done."""
    subject: Target
    """The subject."""
    relation: Name
    """The relation."""
    object: Target
    """The object."""


Operation = Annotated[
    AddOperation | RemoveOperation | SetOperation | PlaceOperation | RelateOperation | UnrelateOperation,
    Field(discriminator="op"),
]


class TransactionOrder(Request):
    """Several writes, of which all take effect or none."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {
                    "reason": "two starters were delivered",
                    "expects": {"pallet_a": 1},
                    "operations": [
                        {
                            "op": "add",
                            "ref": "first",
                            "class": "kitting:Starter",
                            "placement": {"relation": "sk:in", "place": "pallet_a"},
                        },
                        {"op": "set", "element": "$first", "property": "sk:mass", "value": 0.4},
                    ],
                }
            ]
        },
    )

    reason: Annotated[str, Field(min_length=1, max_length=1000)]
    """Why, for people."""
    expects: Annotated[dict[Annotated[str, Field(max_length=300)], Version], Field(max_length=1000)] = Field(
        default_factory=dict
    )
    """The versions that the author has seen, by id of an element; for "" that of the world."""
    operations: Annotated[list[Operation], Field(min_length=1, max_length=_MOST_OPERATIONS)]
    """What is written, in this order."""


class Learned(Answer):
    """Something that a robot was taught, and keeps beyond this scene."""

    id: str = Field(examples=["learned:taught_grasp_1"])
    """Its id."""
    class_: str = Field(validation_alias="class", serialization_alias="class", examples=["sk:TaughtGrasp"])
    """Its class."""
    label: str
    """What people call it."""
    about: str | None = Field(examples=["kitting:Starter"])
    """The class of things that it is about."""
    properties: dict[str, Any]
    """What it says: values by property."""
    version: int = Field(examples=[17])
    """Number of the change that touched it last; its ETag."""


LearnedPage = Page[Learned]
"""Some of what was learned, in the order of ids."""


class Lock(Answer):
    """Somebody's right to be the only person or job that edits an element."""

    element: str = Field(examples=["kit_1"])
    """Id of the element; its pieces are locked with it."""
    owner: str = Field(examples=["ann"])
    """Who has it."""
    until: datetime
    """When it ends by itself (UTC)."""
    seconds: float = Field(examples=[59.2])
    """In how long that is [s]."""


LockList = Items[Lock]
"""The locks in force, by element."""


class LockOrder(Request):
    """What is to be locked."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"elements": ["kit_1"], "seconds": 60.0}]})

    elements: Annotated[list[ElementId], Field(min_length=1, max_length=1000)] = Field(examples=[["kit_1"]])
    """Ids of the elements: all are locked, or none."""
    seconds: Annotated[float, Field(gt=0.0, le=86400.0, allow_inf_nan=False)] = 60.0
    """After how long the locks end by themselves [s]; at most a day."""
