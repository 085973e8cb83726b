"""What can be seen: shapes of the world, the robots' state at one moment, and replays of jobs."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import ConfigDict, Field

from skiros_py.api.wire import Answer


class PoseInfo(Answer):
    """Where something is, seen from the map."""

    position: tuple[float, float, float] = Field(description="(x, y, z) [m].", examples=[[1.2, 0.4, 0.0]])
    orientation: tuple[float, float, float, float] = Field(
        description="Unit quaternion (x, y, z, w).", examples=[[0.0, 0.0, 0.0, 1.0]]
    )


class ArmInfo(Answer):
    """The joints of one arm."""

    positions: tuple[float, ...] = Field(description="Joint angles [rad].", examples=[[0.0, -0.8, 0.0]])
    velocities: tuple[float, ...] = Field(description="Joint speeds [rad/s].", examples=[[0.0, 0.0, 0.0]])
    still: bool = Field(description="Whether it stands.", examples=[True])
    tool: PoseInfo | None = Field(default=None, description="Where its tip is; null if its model is unknown.")


class GripperInfo(Answer):
    """One gripper."""

    gap: float = Field(description="Distance between the fingers [m].", examples=[0.051])
    force: float = Field(description="Force of each finger on what it holds [N].", examples=[30.0])
    still: bool = Field(description="Whether the fingers stand.", examples=[True])
    holds: str | None = Field(description="Id of what it holds as far as anybody knows.", examples=["starter_1"])


class BaseInfo(Answer):
    """One mobile base."""

    pose: PoseInfo = Field(description="Where it is, as it localises itself.")
    linear: float = Field(description="Forward speed [m/s].", examples=[0.0])
    angular: float = Field(description="Turning speed, counter-clockwise [rad/s].", examples=[0.0])
    still: bool = Field(description="Whether it stands.", examples=[True])


class ModuleAtWork(Answer):
    """A module that was started."""

    agent: str = Field(description="Id of the subsystem that runs it.", examples=["arm_1"])
    module: str = Field(description="Its name.", examples=["pick"])
    status: str = Field(description="running, paused, stopping, stopped or ended.", examples=["running"])


class TaskAtWork(Answer):
    """A task under way."""

    name: str = Field(description="Its name; that of a job is the job's id.", examples=["kit-17"])
    status: str = Field(description="planning, running, paused, waiting or ended.", examples=["running"])


class StationState(Answer):
    """What the robots do at one moment."""

    time: float = Field(description="Run time [s].", examples=[45.8])
    cycle: int = Field(description="Number of the control cycle.", examples=[9160])
    pace: float | None = Field(description="Run time per wall time; null for as fast as possible.", examples=[1.0])
    halted: str = Field(description="Why everything is halted; empty while it is not.", examples=[""])
    standing: bool = Field(description="Whether all arms and bases stand.", examples=[True])
    arms: dict[str, ArmInfo] = Field(description="The arms by id.")
    grippers: dict[str, GripperInfo] = Field(description="The grippers by id.")
    bases: dict[str, BaseInfo] = Field(description="The bases by id.")
    platforms: dict[str, PoseInfo] = Field(
        default_factory=dict,
        description="The frames of all devices that carry bodies (bases, turntables), in the map, by device.",
    )
    modules: tuple[ModuleAtWork, ...] = Field(description="What runs.")
    tasks: tuple[TaskAtWork, ...] = Field(description="What is under way.")
    looks: dict[str, int] = Field(
        description="Number of the last look by camera: where it is another one there is a new picture to be read.",
        examples=[{"camera_1": 3}],
    )
    motions: dict[str, int] = Field(
        description="Number of the last motion by robot: where it is another one, its motion is to be read again.",
        examples=[{"robot_1": 7}],
    )


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


class ReplayDevice(Answer):
    """A device, moment by moment."""

    states: tuple[dict[str, Any], ...] = Field(description="What it said, as `GET /devices/{id}/state` has it.")
    poses: tuple[tuple[float, ...], ...] | None = Field(
        description="Its frame in the map: x, y, z [m] and a quaternion x, y, z, w; null where it has none of its own."
    )


class ReplayFrames(Answer):
    """Where the devices were, at the same moments each."""

    times: tuple[float, ...] = Field(
        description="The moments, ascending [s, run time]; none while nothing moves, apart from the first and the last."
    )
    arms: dict[str, tuple[tuple[float, ...], ...]] = Field(description="Joint angles [rad] by arm, moment by moment.")
    grippers: dict[str, tuple[float, ...]] = Field(description="Distance between the fingers [m] by gripper.")
    bases: dict[str, tuple[tuple[float, float, float], ...]] = Field(description="x [m], y [m], heading [rad] by base.")
    devices: dict[str, ReplayDevice] = Field(default_factory=dict, description="Devices of all other kinds, by id.")


class ReplayChange(Answer):
    """What looked different from a moment on."""

    time: float = Field(description="When [s, run time].", examples=[23.1])
    author: str = Field(description="Who changed it; empty where it is the world as it was found.", examples=["pick"])
    anew: bool = Field(
        default=False,
        description="True where the view is of the whole world, and what is not in it is gone: the job was held, or"
        " cut off by a restart, and goes on.",
    )
    view: WorldView = Field(
        description="The elements that look different, and those that are gone; of the shapes those that did not come"
        " before."
    )


class Replay(Answer):
    """A job from its first step to its end."""

    job: str = Field(description="Id of the job.", examples=["kit-17"])
    start: float = Field(description="When it began [s, run time].", examples=[0.3])
    end: float = Field(description="When it ended; while it runs, how far it is kept [s, run time].", examples=[158.6])
    complete: bool = Field(
        description="Whether it is over and all of it is there; else it still runs or is held, or something is"
        " missing: it was cut off, or is too much to be kept."
    )
    shifts: tuple[tuple[float, float], ...] = Field(
        default=(),
        description="Run time begins again with the server: from the first number on [s], all times in here are later"
        " by the second [s] than run time was.",
    )
    beginning: WorldView = Field(description="The world at the beginning, or at the start of the range asked for.")
    frames: ReplayFrames = Field(
        description="Where the robots were; of a range also the last frame before it and the first one after it."
    )
    changes: tuple[ReplayChange, ...] = Field(description="What changed after that, in order.")
