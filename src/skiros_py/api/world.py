"""The world on the wire: elements and their values, changes and transactions, taught data, locks."""

from __future__ import annotations

import math
from datetime import datetime
from typing import Annotated, Any, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, StrictBool, StrictInt, field_validator, model_validator

from skiros_py.api.wire import Answer, Request

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

    relation: Name = Field(description="The placement relation.", examples=["sk:in"])
    place: ElementId = Field(description="Id of the place.", examples=["pallet_a"])


class Pose(Answer):
    """Where a frame is, seen from another."""

    position: tuple[float, float, float] = Field(description="x, y, z [m].", examples=[[5.0, 1.6, 0.0]])
    orientation: tuple[float, float, float, float] = Field(
        description="Unit quaternion x, y, z, w.", examples=[[0.0, 0.0, 0.0, 1.0]]
    )
    frame: str | None = Field(
        default=None,
        description="Element in whose frame it is given; null for the map, or where that is said elsewhere.",
    )


class GivenPose(Request):
    """A pose that somebody writes."""

    position: tuple[Coordinate, Coordinate, Coordinate] = Field(
        description="x, y, z [m], at most 1000 km from the frame.", examples=[[5.0, 1.6, 0.0]]
    )
    orientation: tuple[Number, Number, Number, Number] = Field(
        default=(0.0, 0.0, 0.0, 1.0),
        description="Unit quaternion x, y, z, w; not turned where left out.",
        examples=[[0.0, 0.0, 0.0, 1.0]],
    )
    frame: ElementId | None = Field(
        default=None,
        description="For sk:pose: the element in whose frame it is given; null for the map. Left out, it stays the one"
        " that it is now.",
    )

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

    id: str = Field(description="Its id; never used again after removal.", examples=["starter_1"])
    class_: str = Field(
        validation_alias="class",
        serialization_alias="class",
        description="Its most specific class.",
        examples=["kitting:Starter"],
    )
    label: str = Field(description="What people call it.", examples=["starter"])
    placement: Placement | None = Field(description="Where it is; null for what is nowhere, or goes with its owner.")
    abstract: bool = Field(description="True for what the ontology describes or what was learned, not really there.")
    version: int = Field(description="Number of the change that touched it last; its ETag.", examples=[17])


class Property(Answer):
    """What an element has as the value of a property."""

    value: Value = Field(description="The value; poses as position and orientation.", examples=[0.4])
    origin: Literal["own", "taught", "class"] = Field(
        description="Whether the element has it itself, it was taught for its class, or its class gives it."
    )
    taught_by: str | None = Field(default=None, description="For what was taught: the learned element that says it.")


class Relation(Answer):
    """A relation that holds."""

    subject: str = Field(examples=["starter_1"], description="Id of the subject.")
    relation: str = Field(examples=["sk:in"], description="The relation.")
    object: str = Field(examples=["pallet_a"], description="Id of the object.")
    family: str = Field(
        examples=["placement"], description='What the relation is for: "placement", "structure", "computed" or "plain".'
    )


class ElementDetails(ElementSummary):
    """Everything about one element."""

    changed_at: float = Field(description="When it was changed last [s, run time].", examples=[12.5])
    properties: dict[str, Property] = Field(description="Values by property.")
    relations: list[Relation] = Field(description="What is stated of it, in both directions: the first 200.")
    relations_total: int = Field(description="How many relations are stated of it.")
    computed: list[Relation] = Field(
        description="Computed relations, those that were asked for: of each the first 200 in either direction."
    )
    owner: str | None = Field(description="What it is a piece of.")
    map_pose: Pose | None = Field(description="Its pose in the map, where that is known.")


class ElementPage(Answer):
    """Some elements, in the order of their ids."""

    items: list[ElementSummary] = Field(description="The elements.")
    next: str | None = Field(description="Cursor of the next page; null at the end.")


class RelationPage(Answer):
    """Some relations, in order."""

    items: list[Relation] = Field(description="The relations.")
    next: str | None = Field(description="Cursor of the next page; null at the end.")


class NewRelation(Request):
    """A relation of a new element: the end that is left out is the element."""

    subject: ElementId | None = Field(default=None, description="Id of the subject.", examples=["kit_1"])
    relation: Name = Field(description="The relation.", examples=["sk:hasA"])
    object: ElementId | None = Field(default=None, description="Id of the object.")


class Addition(Request):
    """What is added."""

    class_: Name | None = Field(
        default=None,
        validation_alias="class",
        serialization_alias="class",
        description="Its class; not together with `like`.",
        examples=["kitting:Starter"],
    )
    like: ElementId | None = Field(
        default=None,
        description="Copied with its pieces: an abstract individual, or another element. Instead of a class.",
        examples=["kitting:standard_kit"],
    )
    id: ElementId | None = Field(
        default=None, description="Its id; the next of its class where left out. A copy always gets the next one."
    )
    label: Annotated[str, Field(min_length=1, max_length=1000)] | None = Field(
        default=None, description="What people call it; its class's name where left out."
    )
    properties: Annotated[dict[Name, GivenValue], Field(max_length=200)] = Field(
        default_factory=dict, description="Own values by property.", examples=[{"sk:mass": 0.4}]
    )
    placement: Placement | None = Field(default=None, description="Where it is.")
    relations: Annotated[list[NewRelation], Field(max_length=200)] = Field(
        default_factory=list, description="Relations of it, such as whose piece it is."
    )

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

    reason: Reason = Field(default="", description="Why, for people.", examples=["delivered this morning"])


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

    label: Annotated[str, Field(min_length=1, max_length=1000)] | None = Field(
        default=None, description="What people call it."
    )
    properties: Annotated[dict[Name, GivenValue | None], Field(max_length=200)] = Field(
        default_factory=dict,
        description="Own values by property; null takes the own value away.",
        examples=[{"sk:mass": 0.4, "sk:graspHeight": None}],
    )
    placement: Placement | None = Field(default=None, description="Where it is from now on.")
    reason: Reason = Field(default="", description="Why, for people.", examples=["weighed"])


class TreeNode(Answer):
    """An element with what is placed there and what it is built of."""

    id: str = Field(description='Its id; "" for the node above everything.', examples=["pallet_a"])
    class_: str = Field(
        validation_alias="class", serialization_alias="class", description="Its class.", examples=["kitting:Pallet"]
    )
    label: str = Field(description="What people call it.", examples=["pallet A"])
    relation: str = Field(description="The relation by which it hangs on the node above.", examples=["sk:on"])
    version: int = Field(description="Number of the change that touched it last; its ETag.")
    children: list[TreeNode] = Field(description="What hangs on it, in the order of ids; perhaps not all.")
    children_total: int = Field(description="How many hang on it.")
    next: str | None = Field(
        description="Where not all children are here: the cursor to go on with, together with root=<id>."
    )


_MOST_OPERATIONS = 1000

Version = Annotated[int, Field(strict=True, ge=0, le=2**62)]
"""Number of a change."""


class Change(Answer):
    """One transaction that took effect."""

    number: int = Field(description="Counted from 1 without gaps; the world's version afterwards.", examples=[17])
    author: str = Field(description="Who wrote.", examples=["ann"])
    writer: str = Field(description='What kind of author: "person", "skill", "job" or "system".', examples=["person"])
    reason: str = Field(description="Why, for people.", examples=["delivered this morning"])
    time: float = Field(description="When [s, run time].", examples=[12.5])
    written: datetime | None = Field(default=None, description="When (UTC), where that is remembered.")
    undoes: int | None = Field(default=None, description="Number of the change that this one took back.")
    edits: list[dict[str, Any]] = Field(
        description='What changed, each with its old and new value; "edit" tells what kind it is: "element",'
        ' "placement", "property", "relation" or "goals". Perhaps not all.',
        examples=[
            [
                {
                    "edit": "placement",
                    "element": "starter_1",
                    "old": {"relation": "sk:in", "place": "pallet_a"},
                    "new": {"relation": "sk:in", "place": "kit_1_a"},
                }
            ]
        ],
    )
    edits_total: int = Field(description="How many edits it has.")
    next: str | None = Field(
        default=None, description="Where not all edits are here: the cursor to read on with at /world/changes/{number}."
    )


class ChangePage(Answer):
    """Some changes."""

    items: list[Change] = Field(description="The changes.")
    next: str | None = Field(description="Cursor of the next page; null at the end.")
    remembered_from: int = Field(description="Number of the oldest change that is remembered.")
    version: int = Field(description="Number of the latest change.")


class Undoable(Answer):
    """The change that an undo would take back."""

    number: int = Field(description="Its number.", examples=[17])
    author: str = Field(description="Who wrote it.", examples=["ann"])
    reason: str = Field(description="Why.", examples=["delivered this morning"])


class WorldInfo(Answer):
    """What there is, in numbers."""

    version: int = Field(description="Number of the latest change; the world's ETag.", examples=[17])
    time: float = Field(description="Run time now [s].", examples=[12.5])
    elements: int = Field(description="Elements of the scene.")
    abstract: int = Field(description="Individuals that the ontology describes.")
    learned: int = Field(description="Individuals that robots were taught.")
    goals: int = Field(description="Goals that go with the scene.")
    locks: int = Field(description="Locks in force.")
    remembered_from: int = Field(description="Number of the oldest change that is remembered.")
    undoable: Undoable | None = Field(description="What an undo would take back.")


class Written(Answer):
    """What a write did."""

    version: int = Field(description="The world's version now.", examples=[18])
    change: Change | None = Field(description="The change; null where everything was so already.")
    ids: dict[str, str] = Field(default_factory=dict, description="Ids of what was added, by its ref.")


class UndoOrder(Request):
    """Which change is meant."""

    change: Version | None = Field(
        default=None, description="Take it back only if it is this one that comes next.", examples=[17]
    )


# ------------------------------------------------------------------ transactions

Target = Annotated[str, Field(min_length=1, max_length=300)]
"""Id of an element, or "$" and the ref of one that was added before in the same transaction."""


class AddOperation(Addition):
    """Adds an element."""

    op: Literal["add"] = Field(description="What is done.")
    ref: Annotated[str, Field(pattern="^[a-z][a-z0-9_]{0,49}$")] | None = Field(
        default=None, description='A name for later operations of this transaction, which write "$name".'
    )


class RemoveOperation(Request):
    """Removes an element with its pieces; what was placed there moves to where it was."""

    op: Literal["remove"] = Field(description="What is done.")
    element: Target = Field(description="Which one.", examples=["starter_1"])


class SetOperation(Request):
    """Sets an element's own value of a property; ``rdfs:label`` is its label."""

    op: Literal["set"] = Field(description="What is done.")
    element: Target = Field(description="Which one.", examples=["starter_1"])
    property: Name = Field(description="Which property.", examples=["sk:mass"])
    value: GivenValue | None = Field(description="The value; null takes the own value away.", examples=[0.4])


class PlaceOperation(Request):
    """Moves an element."""

    op: Literal["place"] = Field(description="What is done.")
    element: Target = Field(description="Which one.", examples=["starter_1"])
    relation: Name = Field(description="The placement relation.", examples=["sk:in"])
    place: Target = Field(description="Where to.", examples=["pallet_b"])


class RelateOperation(Request):
    """States a relation; a placement moves its element."""

    op: Literal["relate"] = Field(description="What is done.")
    subject: Target = Field(description="The subject.", examples=["kit_1"])
    relation: Name = Field(description="The relation.", examples=["sk:hasA"])
    object: Target = Field(description="The object.", examples=["kit_1_a"])


class UnrelateOperation(Request):
    """Takes back a stated relation."""

    op: Literal["unrelate"] = Field(description="What is done.")
    subject: Target = Field(description="The subject.")
    relation: Name = Field(description="The relation.")
    object: Target = Field(description="The object.")


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

    reason: Annotated[str, Field(min_length=1, max_length=1000)] = Field(description="Why, for people.")
    expects: Annotated[dict[Annotated[str, Field(max_length=300)], Version], Field(max_length=1000)] = Field(
        default_factory=dict,
        description='The versions that the author has seen, by id of an element; for "" that of the world.',
    )
    operations: Annotated[list[Operation], Field(min_length=1, max_length=_MOST_OPERATIONS)] = Field(
        description="What is written, in this order."
    )


class Learned(Answer):
    """Something that a robot was taught, and keeps beyond this scene."""

    id: str = Field(description="Its id.", examples=["learned:taught_grasp_1"])
    class_: str = Field(
        validation_alias="class", serialization_alias="class", description="Its class.", examples=["sk:TaughtGrasp"]
    )
    label: str = Field(description="What people call it.")
    about: str | None = Field(description="The class of things that it is about.", examples=["kitting:Starter"])
    properties: dict[str, Any] = Field(description="What it says: values by property.")
    version: int = Field(description="Number of the change that touched it last; its ETag.", examples=[17])


class LearnedPage(Answer):
    """Some of what was learned, in the order of ids."""

    items: list[Learned] = Field(description="What was learned.")
    next: str | None = Field(description="Cursor of the next page; null at the end.")


class Lock(Answer):
    """Somebody's right to be the only person or job that edits an element."""

    element: str = Field(description="Id of the element; its pieces are locked with it.", examples=["kit_1"])
    owner: str = Field(description="Who has it.", examples=["ann"])
    until: datetime = Field(description="When it ends by itself (UTC).")
    seconds: float = Field(description="In how long that is [s].", examples=[59.2])


class LockList(Answer):
    """The locks in force, by element."""

    items: list[Lock] = Field(description="The locks.")


class LockOrder(BaseModel):
    """What is to be locked."""

    model_config = ConfigDict(
        frozen=True, extra="forbid", json_schema_extra={"examples": [{"elements": ["kit_1"], "seconds": 60.0}]}
    )

    elements: Annotated[list[ElementId], Field(min_length=1, max_length=1000)] = Field(
        description="Ids of the elements: all are locked, or none.", examples=[["kit_1"]]
    )
    seconds: Annotated[float, Field(gt=0.0, le=86400.0, allow_inf_nan=False)] = Field(
        default=60.0, description="After how long the locks end by themselves [s]; at most a day."
    )
