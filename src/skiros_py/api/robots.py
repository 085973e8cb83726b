"""Robots: their devices, signals, poses, images, and moving them manually."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import ConfigDict, Field

from skiros_py.api.modules import Arguments
from skiros_py.api.view import DeviceState, OfCycle, PoseInfo
from skiros_py.api.wire import Answer, Name, Page, Request

Number = Annotated[float, Field(allow_inf_nan=False)]


class JointDescription(Answer):
    """One joint."""

    name: str = Field(examples=["panda_joint1"])
    """Its name."""
    lower: float | None = Field(examples=[-2.9])
    """Minimum position [rad or m]; null if it has no limit."""
    upper: float | None = Field(examples=[2.9])
    """Maximum position [rad or m]; null if it has no limit."""
    velocity: float | None = Field(examples=[2.1])
    """Maximum speed [rad/s or m/s]; null if unknown."""


class ManualRun(Request):
    """Jogs or teaches with a device."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {"arguments": {"deltas": [0.1, 0, 0, 0, 0, 0, 0]}},
                {"module": "jog_tool", "arguments": {"frame": "map", "translation": [0, 0, -0.05]}},
            ]
        }
    )

    module: Name | None = Field(None, examples=["jog_tool"])
    """A module of the device for this purpose; the first if omitted."""
    arguments: Arguments = Field(default_factory=dict, examples=[{"translation": [0, 0, -0.05]}])
    """Arguments of the module; its device is that of the address."""


SignalValue = bool | float | tuple[float, ...]
"""A truth value, a number, or a list of numbers."""


class SignalInfo(Answer):
    """A value that a device offers in each cycle."""

    name: str = Field(examples=["force"])
    """Its name, as conditions use it."""
    unit: str = Field(examples=["N"])
    """Its unit; empty for truth values and pure numbers."""
    dimension: str = Field(examples=["force"])
    """The physical dimension of its unit; empty if it has none, or an unknown one."""
    frame: str = Field(examples=[""])
    """Reference frame: "map", or "own" for that of the device; empty if it has none."""
    help: str = Field(examples=["force per finger"])
    """Its meaning."""


class DeviceModule(Answer):
    """A module that the kind of a device names for jogging or teaching."""

    module: str = Field(examples=["gripper_control"])
    """Its name."""
    agent: str | None = Field(examples=["arm_1"])
    """Id of the subsystem that runs it; null if none can."""


class DeviceInfo(Answer):
    """One device."""

    id: str = Field(examples=["gripper_1"])
    """Its id."""
    kind: str = Field(examples=["gripper"])
    """Its kind."""
    robot: str | None = Field(examples=["robot_1"])
    """Id of its robot; null if it has none."""
    model: str = Field(examples=[""])
    """Name of its own model, as in `GET /robots/{id}/model`; empty if it has none, and for a device of a robot."""
    place: PoseInfo | None
    """Pose of a device without a robot in the map; null for a device of a robot."""
    description: dict[str, Any] = Field(examples=[{"max_gap": 0.08}])
    """Its constant data, by the names of its kind."""
    signals: tuple[SignalInfo, ...]
    """Its signals."""
    open: bool = Field(examples=[True])
    """Whether it can be used; false after it was closed."""
    commanded: bool = Field(examples=[True])
    """Whether it takes commands; false for a sensor."""
    joints: tuple[JointDescription, ...]
    """The joints of the model that it moves or measures."""
    frames: tuple[str, ...] = Field(examples=[["tcp"]])
    """Its links in the model: a tip, an optical frame."""
    mounted_on: str = Field(examples=["arm_1"])
    """Id of the device whose frame it shares (the arm of a gripper); empty if there is none."""
    jog: tuple[DeviceModule, ...]
    """Modules that move it by a small step, or home."""
    teach: tuple[DeviceModule, ...]
    """Modules that learn something from its current state."""


Devices = Page[DeviceInfo]
"""The devices of the cell."""


class RobotInfo(Answer):
    """A robot and its devices."""

    id: str = Field(examples=["robot_1"])
    """Its id."""
    label: str = Field(examples=["robot"])
    """Its label."""
    model: str = Field(examples=["mobile_panda"])
    """Name of its model."""
    carrier: str | None = Field(examples=["base_1"])
    """Id of the device of any kind that moves it in the map; null for a stationary robot."""
    place: PoseInfo | None
    """Pose of a stationary robot in the map; null for others."""
    footprint: tuple[tuple[float, float], ...]
    """Corners (x, y) of its outline on the floor, in the frame of its carrier, or in its own [m]."""
    devices: tuple[DeviceInfo, ...]
    """Its devices, of any kind."""
    agents: tuple[str, ...] = Field(examples=[["arm_1", "base_1"]])
    """Subsystems that have skill managers."""


Robots = Page[RobotInfo]
"""The robots of the cell."""


class RobotReading(OfCycle):
    """A robot at one moment."""

    id: str = Field(examples=["robot_1"])
    """Its id."""
    halted: str = Field(examples=[""])
    """Reason of the halt; empty if nothing is halted."""
    at: str = Field(examples=["pallet_a"])
    """Id of the place where it is believed to be; empty if there is none."""
    pose: PoseInfo
    """Pose of the robot in the map, as localised."""
    devices: dict[str, DeviceState]
    """States of its devices, by device id."""
    frames: dict[str, PoseInfo]
    """Poses of the frames of its devices in the map, by device id: the tip of an arm, the optical frame of a camera."""


class DeviceReading(DeviceState, OfCycle):
    """A device at one moment, with its signals."""

    id: str = Field(examples=["gripper_1"])
    """Its id."""
    signals: dict[str, SignalValue] = Field(examples=[{"gap": 0.051, "force": 30.0}])
    """Values of its signals, by name."""


class CellSignal(SignalInfo):
    """A signal of the cell: of a device, computed, or set from outside."""

    name: str = Field(examples=["gripper_1.force"])
    """Its name, as conditions and expressions use it."""
    length: int | None = Field(examples=[3])
    """Number of values of a computed vector; null for any other."""
    source: str = Field(examples=["gripper_1"])
    """Its device or signal provider."""
    input: bool = Field(examples=[False])
    """Whether it can be set from outside."""


CellSignals = Page[CellSignal]
"""The signals of the cell."""


class SignalReading(Answer):
    """The value of a signal in one cycle."""

    value: SignalValue | None = Field(examples=[30.0])
    """The value; null if it has none."""
    reason: str = Field(examples=[""])
    """Why it has no value; empty if it has one."""


class SignalReadings(OfCycle):
    """Values of signals in one control cycle."""

    signals: dict[str, SignalReading]
    """The values, by name of the signal."""


class SetSignal(Request):
    """A new value of a signal."""

    value: bool | Number | tuple[Number, ...] = Field(examples=[0.3])
    """The value, in its unit."""


class Seen(Answer):
    """One segmented object, recognised or not."""

    type: str | None = Field(examples=["kitting:Starter"])
    """Its class; null if it fits no known shape."""
    pose: PoseInfo
    """Its pose in the map."""
    size: tuple[float, float, float]
    """Length, width, height of its bounding box [m]."""
    cost: float = Field(examples=[0.0011])
    """Mean misfit of the shape [m]; smaller is better."""
    margin: float = Field(examples=[0.004])
    """Difference of the cost to the second-best shape [m]."""


class Observation(Answer):
    """The last requested image of a camera, as a point cloud."""

    number: int = Field(examples=[3])
    """Number of the observation by this camera, from 1; 0 if there was none yet."""
    camera: str = Field(examples=["camera_1"])
    """Id of the camera."""
    time: float = Field(examples=[21.4])
    """When it was taken [s, run time]."""
    pose: PoseInfo | None
    """Pose of the camera in the map, z forward; null if there was none yet."""
    points: str
    """Its points: x, y, z in the map [m] as little-endian 32-bit floats, in base64."""
    colours: str
    """Red, green, blue of each point (0 to 255) as bytes, in base64; empty if there are none."""
    seen: tuple[Seen, ...]
    """The objects segmented in it."""
    purpose: str = Field(examples=["parts"])
    """Purpose of the observation: parts, or the exact pose of a kit."""


class DeviceMotion(Answer):
    """The planned motion of a device: the path of a base, the motion of an arm."""

    number: int = Field(examples=[7])
    """Number of the planned motion, from 1; 0 if there was none yet."""
    poses: tuple[PoseInfo, ...]
    """Poses along it in the map, of a base or of the tip of an arm; empty while nothing is planned."""
