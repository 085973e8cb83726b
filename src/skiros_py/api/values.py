"""What the world is told and tells in: names, values, poses."""

from __future__ import annotations

import math
from typing import Annotated, Any

from pydantic import Field, StrictBool, StrictInt, field_validator

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
