"""Transactions on the wire: several writes to the world, executed all or none."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import ConfigDict, Field

from skiros_py.api.wire import Request
from skiros_py.api.world import Addition, GivenValue, Name, Version

_MOST_OPERATIONS = 1000

Target = Annotated[str, Field(min_length=1, max_length=300)]
"""Id of an element, or "$" and the ref of an element added earlier in the same transaction."""


class AddOperation(Addition):
    """Adds an element."""

    op: Literal["add"]
    """The operation."""
    ref: Annotated[str, Field(pattern="^[a-z][a-z0-9_]{0,49}$")] | None = None
    """A name for later operations of this transaction, which refer to it as "$name"."""


class RemoveOperation(Request):
    """Removes an element with its parts; elements placed there move to its place."""

    op: Literal["remove"]
    """The operation."""
    element: Target = Field(examples=["starter_1"])
    """Id of the element."""


class SetOperation(Request):
    """Sets an element's own value of a property; ``rdfs:label`` is its label."""

    op: Literal["set"]
    """The operation."""
    element: Target = Field(examples=["starter_1"])
    """Id of the element."""
    property: Name = Field(examples=["sk:mass"])
    """The property."""
    value: GivenValue | None = Field(examples=[0.4])
    """The value; null removes the own value."""


class PlaceOperation(Request):
    """Moves an element."""

    op: Literal["place"]
    """The operation."""
    element: Target = Field(examples=["starter_1"])
    """Id of the element."""
    relation: Name = Field(examples=["sk:in"])
    """The placement relation."""
    place: Target = Field(examples=["pallet_b"])
    """Id of its new place."""


class RelateOperation(Request):
    """States a relation; a placement moves its element."""

    op: Literal["relate"]
    """The operation."""
    subject: Target = Field(examples=["kit_1"])
    """The subject."""
    relation: Name = Field(examples=["sk:hasA"])
    """The relation."""
    object: Target = Field(examples=["kit_1_a"])
    """The object."""


class UnrelateOperation(Request):
    """Removes a stated relation."""

    op: Literal["unrelate"]
    """The operation."""
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
    """Several writes, executed all or none."""

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
    """Reason, for people."""
    expects: Annotated[dict[Annotated[str, Field(max_length=300)], Version], Field(max_length=1000)] = Field(
        default_factory=dict
    )
    """Versions seen by the author, by id of an element; "" for the world."""
    operations: Annotated[list[Operation], Field(min_length=1, max_length=_MOST_OPERATIONS)]
    """The operations, in order."""
