"""What there is to be seen of the world: shapes and where they are, for pictures of any kind."""

from __future__ import annotations

from typing import Literal

from pydantic import ConfigDict, Field

from skiros_py.api.state import PoseInfo
from skiros_py.api.wire import Answer


class Block(Answer):
    """A box or a cylinder, one of those that a shape is built of."""

    kind: Literal["box", "cylinder"] = Field(description="Which of the two.", examples=["box"])
    size: tuple[float, ...] = Field(
        description="Box: lengths along x, y, z [m]. Cylinder: radius, and length along z [m].",
        examples=[[0.6, 0.8, 0.45]],
    )
    pose: PoseInfo = Field(description="Of its middle, in the frame of the element.")


class ViewElement(Answer):
    """An element as it is seen."""

    model_config = ConfigDict(populate_by_name=True)

    id: str = Field(description="Its id.", examples=["starter_1"])
    class_: str = Field(
        validation_alias="class", serialization_alias="class", description="Its class.", examples=["kitting:Starter"]
    )
    label: str = Field(description="What people call it.", examples=["starter"])
    pose: PoseInfo | None = Field(
        description="Where its frame is in the map, or in that of its carrier; null where nobody knows where exactly."
        " Of a robot and its base: where it localised itself when this was answered."
    )
    carrier: str | None = Field(
        default=None,
        description="Id of the device on which it rides (a base, a turntable): its pose is in the frame of that device,"
        " which the live state has among its platforms. Null where its pose is in the map.",
        examples=["base_1"],
    )
    place: str | None = Field(description="Id of what it is on, in or at; null for none.", examples=["pallet_a"])
    owner: str | None = Field(description="Id of what it is a piece of; null for none.", examples=["kit_1"])
    held_by: str | None = Field(description="Id of the gripper that holds it; null for none.", examples=["gripper_1"])
    in_hand: PoseInfo | None = Field(
        default=None, description="Where its frame is in that of the tool that holds it; null where nothing does."
    )
    shape: str | None = Field(description="Key of its shape; null for none.", examples=["kitting:Starter"])
    hollow: bool = Field(default=False, description="Whether its shape is the room inside, not matter.")
    kind: Literal["part", "place", "furniture", "floor", "robot", "device", "other"] = Field(
        description="What a picture shows it as: a part that can be carried, a place that holds parts, what stands"
        " there, the floor, a robot, a piece of one, anything else.",
        examples=["part"],
    )
    version: int = Field(description="Number of the change that touched it last.", examples=[17])


class WorldView(Answer):
    """The world as it is believed to look."""

    version: int = Field(description="Number of the last change of the world in it.", examples=[17])
    elements: tuple[ViewElement, ...] = Field(description="What is there; abstract individuals are not.")
    shapes: dict[str, tuple[Block, ...]] = Field(
        description="The shapes of these elements by key; as long as the server runs, a key means the same shape."
    )
    gone: tuple[str, ...] = Field(
        default=(), description="Of the elements that were asked for: the ids of those that are not there to be seen."
    )
