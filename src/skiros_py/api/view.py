"""Data for pictures: shapes of the world, the state of the robots, and replays of jobs."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import Field

from skiros_py.api.wire import Answer
from skiros_py.api.world import NamedElement


class PoseInfo(Answer):
    """A pose in the map."""

    position: tuple[float, float, float] = Field(examples=[[1.2, 0.4, 0.0]])
    """(x, y, z) [m]."""
    orientation: tuple[float, float, float, float] = Field(examples=[[0.0, 0.0, 0.0, 1.0]])
    """Unit quaternion (x, y, z, w)."""


class DeviceState(Answer):
    """A device at one moment."""

    still: bool = Field(examples=[True])
    """Whether it stands still, so that a stop need not wait for it."""
    state: dict[str, Any] | None = Field(examples=[{"gap": 0.051, "force": 30.0, "still": True}])
    """Its readings, by the names of its kind; null for a device that is read on request only, such as a camera."""
    holds: str | None = Field(examples=["starter_1"])
    """Id of the element that it is believed to hold; null for none."""


class ModuleAtWork(Answer):
    """An active module."""

    agent: str = Field(examples=["arm_1"])
    """Id of the subsystem that runs it."""
    module: str = Field(examples=["pick"])
    """Its name."""
    status: str = Field(examples=["running"])
    """running, paused, stopping, stopped or ended."""


class TaskAtWork(Answer):
    """An active task."""

    name: str = Field(examples=["kit-17"])
    """Its name; that of a job is the job's id."""
    status: str = Field(examples=["running"])
    """planning, running, paused, waiting or ended."""


class OfCycle(Answer):
    """What was read in one control cycle."""

    time: float = Field(examples=[45.8])
    """Run time [s]."""
    cycle: int = Field(examples=[9160])
    """Number of the control cycle."""


class StationState(OfCycle):
    """State of the robots at one moment."""

    pace: float | None = Field(examples=[1.0])
    """Run time per wall time; null if as fast as possible."""
    halted: str = Field(examples=[""])
    """Reason of the halt; empty if nothing is halted."""
    standing: bool = Field(examples=[True])
    """Whether all devices stand still."""
    devices: dict[str, DeviceState]
    """The devices by id."""
    platforms: dict[str, PoseInfo]
    """The frames of all devices that carry bodies (bases, turntables), in the map, by device."""
    frames: dict[str, PoseInfo]
    """The frames of all other devices that have one (tips of arms, grippers, cameras), in the map, by device."""
    joints: dict[str, float] = Field(examples=[{"robot_1/panda_joint1": 0.0}])
    """Positions of the joints of all models [rad or m], by "robot/joint", or "device/joint" for a device without a
    robot.
    """
    modules: tuple[ModuleAtWork, ...]
    """The active modules."""
    tasks: tuple[TaskAtWork, ...]
    """The active tasks."""
    observations: dict[str, int] = Field(examples=[{"camera_1": 3}])
    """Number of the last observation by camera; if it changes, there is a new image."""
    motions: dict[str, int] = Field(examples=[{"base_1": 7}])
    """Number of the planned motion by device; if it changes, another motion is planned, or none any more."""


class Block(Answer):
    """A box or a cylinder of a shape."""

    kind: Literal["box", "cylinder"] = Field(examples=["box"])
    """Its kind."""
    size: tuple[float, ...] = Field(examples=[[0.6, 0.8, 0.45]])
    """Box: lengths along x, y, z [m]. Cylinder: radius, and length along z [m]."""
    pose: PoseInfo
    """Pose of its centre, in the frame of the element."""


class ViewElement(NamedElement):
    """An element with its shape and pose."""

    pose: PoseInfo | None
    """Where its frame is in the map, or in that of its carrier; null where that is not known exactly. Of a robot and
    its base: where it localised itself when this was answered.
    """
    carrier: str | None = Field(default=None, examples=["base_1"])
    """Id of the device on which it rides (a base, a turntable): its pose is in the frame of that device, which the live
    state has among its platforms. Null where its pose is in the map.
    """
    place: str | None = Field(examples=["pallet_a"])
    """Id of its place; null for none."""
    owner: str | None = Field(examples=["kit_1"])
    """Id of its whole; null for none."""
    held_by: str | None = Field(examples=["gripper_1"])
    """Id of the gripper that holds it; null for none."""
    in_hand: PoseInfo | None = None
    """Pose in the frame of the tool that holds it; null if it is not held."""
    shape: str | None = Field(examples=["kitting:Starter"])
    """Key of its shape; null for none."""
    hollow: bool = False
    """Whether its shape is a cavity."""
    kind: Literal["part", "place", "furniture", "floor", "robot", "device", "other"] = Field(examples=["part"])
    """What a picture shows it as: a part that can be carried, a place that holds parts, what stands there, the floor, a
    robot, a piece of one, anything else.
    """
    version: int = Field(examples=[17])
    """Number of its last change."""


class WorldView(Answer):
    """Believed poses and shapes of the world."""

    version: int = Field(examples=[17])
    """Version of the world."""
    elements: tuple[ViewElement, ...]
    """The elements, without abstract individuals."""
    shapes: dict[str, tuple[Block, ...]]
    """The shapes of these elements by key; a key keeps its meaning while the server runs."""
    gone: tuple[str, ...] = ()
    """Ids of requested elements that do not exist or have no shape."""


class ReplayFrames(Answer):
    """The states of all devices at the same moments."""

    times: tuple[float, ...]
    """The moments, ascending [s, run time]; none while nothing moves, apart from the first and the last."""
    joints: dict[str, tuple[float, ...]] = Field(examples=[{"robot_1/panda_joint1": [0.0, 0.1]}])
    """Positions of the joints at these moments [rad or m], by the names that they have in the live state."""
    frames: dict[str, tuple[tuple[float, ...], ...]] = Field(
        examples=[{"base_1": [[1.2, 0.4, 0.0, 0.0, 0.0, 0.0, 1.0]]}]
    )
    """Frames of the devices in the map at these moments, by device: x, y, z [m] and a unit quaternion x, y, z, w."""
    states: dict[str, tuple[dict[str, Any], ...]]
    """States of the devices at these moments, by device, as in `GET /devices/{id}/state`."""


class ReplayChange(Answer):
    """A visible change at one time."""

    time: float = Field(examples=[23.1])
    """When [s, run time]."""
    author: str = Field(examples=["pick"])
    """Its author; empty for the initial world."""
    whole: bool = False
    """True where the view shows the whole world, so that elements that are not in it are gone: the job goes on after it
    was held, or interrupted by a restart.
    """
    view: WorldView
    """The elements that look different, and those that are gone; of the shapes those that did not come before."""


class Replay(Answer):
    """Recording of a job from its first step to its end."""

    job: str = Field(examples=["kit-17"])
    """Id of the job."""
    start: float = Field(examples=[0.3])
    """When it began [s, run time]."""
    end: float = Field(examples=[158.6])
    """When it ended; while it runs, how far it is kept [s, run time]."""
    complete: bool
    """Whether it is over and all of it is there; else it still runs or is held, or something is missing: it was cut
    off, or is too much to be kept.
    """
    shifts: tuple[tuple[float, float], ...] = ()
    """Run time begins again with the server: from the first number on [s], all times in here are later by the second
    [s] than run time was.
    """
    beginning: WorldView
    """The world at the beginning, or at the start of the range asked for."""
    frames: ReplayFrames
    """Where the robots were; of a range also the last frame before it and the first one after it."""
    changes: tuple[ReplayChange, ...]
    """What changed after that, in order."""
