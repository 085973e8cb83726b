"""The world as a whole: its state, changes and transactions; what robots were taught; locks."""

from __future__ import annotations

from datetime import datetime
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field

from skiros_py.api.elements import Addition
from skiros_py.api.values import ElementId, GivenValue, Name
from skiros_py.api.wire import Answer, Request

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
