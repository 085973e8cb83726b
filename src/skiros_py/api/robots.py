"""Robots: what they are made of, their devices and signals, where they are, what they saw, and moving them by hand."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import ConfigDict, Field

from skiros_py.api.modules import Arguments
from skiros_py.api.view import DeviceState, PoseInfo
from skiros_py.api.wire import Answer, Name, Request

Number = Annotated[float, Field(allow_inf_nan=False)]


class JointDescription(Answer):
    """One joint."""

    name: str = Field(examples=["panda_joint1"])
    """Its name."""
    lower: float | None = Field(examples=[-2.9])
    """Least position [rad or m]; null where it has no limit."""
    upper: float | None = Field(examples=[2.9])
    """Greatest position [rad or m]; null where it has no limit."""
    velocity: float | None = Field(examples=[2.1])
    """Greatest speed [rad/s or m/s]; null if unknown."""


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
    """One of the modules that the device has for this; the first of them where left out."""
    arguments: Arguments = Field(default_factory=dict, examples=[{"translation": [0, 0, -0.05]}])
    """Parameters of the module; its device is the one in the address."""


SignalValue = bool | float | tuple[float, ...]
"""A truth value, a number, or numbers."""


class SignalInfo(Answer):
    """A value that a device offers in each cycle."""

    name: str = Field(examples=["force"])
    """Its name, as conditions use it."""
    unit: str = Field(examples=["N"])
    """Its unit; empty for truth values and pure numbers."""
    dimension: str = Field(examples=["force"])
    """The dimension that its unit measures; empty for no unit, or one that is not known."""
    frame: str = Field(examples=[""])
    """"map", "own" for the frame of the device; empty where none matters."""
    help: str = Field(examples=["force per finger"])
    """Its meaning."""


class DeviceModule(Answer):
    """A module that the kind of a device names for jogging or teaching."""

    module: str = Field(examples=["gripper_control"])
    """Its name."""
    agent: str | None = Field(examples=["arm_1"])
    """Id of the subsystem that runs it; null where none can."""


class DeviceInfo(Answer):
    """One device."""

    id: str = Field(examples=["gripper_1"])
    """Its id."""
    kind: str = Field(examples=["gripper"])
    """Its kind."""
    robot: str | None = Field(examples=["robot_1"])
    """The robot that it belongs to; null for none."""
    model: str = Field(examples=[""])
    """Name of its own model, as `GET /robots/{id}/model` has it; empty for none, and for a device of a robot."""
    place: PoseInfo | None
    """Pose of a device without a robot in the map; null for a device of a robot."""
    description: dict[str, Any] = Field(examples=[{"max_gap": 0.08}])
    """What is known of it, by the names that its kind uses."""
    signals: tuple[SignalInfo, ...]
    """The values that it offers."""
    open: bool = Field(examples=[True])
    """Whether it may be used; false after it was closed."""
    commanded: bool = Field(examples=[True])
    """Whether it takes commands; false for a sensor."""
    joints: tuple[JointDescription, ...]
    """The joints of its robot's model that it moves or measures."""
    frames: tuple[str, ...] = Field(examples=[["tcp"]])
    """Its links of its robot's model: a tip, an optical frame."""
    mounted_on: str = Field(examples=["arm_1"])
    """Id of the device whose frame it shares: the arm of a gripper; empty for none."""
    jog: tuple[DeviceModule, ...]
    """Modules that move it by a small step, or home."""
    teach: tuple[DeviceModule, ...]
    """Modules that learn something from its present state."""


class RobotInfo(Answer):
    """A robot and its devices."""

    id: str = Field(examples=["robot_1"])
    """Its id."""
    label: str = Field(examples=["robot"])
    """Its label."""
    model: str = Field(examples=["mobile_panda"])
    """Name of its model."""
    carrier: str | None = Field(examples=["base_1"])
    """Id of the device that moves it through the map, of whatever kind; null for a robot that stands still."""
    place: PoseInfo | None
    """Where in the map a robot stands that nothing moves; null for others."""
    footprint: tuple[tuple[float, float], ...]
    """Corners of its outline on the floor [m]."""
    devices: tuple[DeviceInfo, ...]
    """Its devices, of any kind."""
    agents: tuple[str, ...] = Field(examples=[["arm_1", "base_1"]])
    """Subsystems that have skill managers."""


class RobotReading(Answer):
    """A robot at one moment."""

    id: str = Field(examples=["robot_1"])
    """Its id."""
    time: float = Field(examples=[45.8])
    """Run time [s]."""
    cycle: int = Field(examples=[9160])
    """Number of the control cycle."""
    halted: str = Field(examples=[""])
    """Reason of the halt; empty if nothing is halted."""
    at: str = Field(examples=["pallet_a"])
    """Id of the place where it is believed to be; empty for none."""
    pose: PoseInfo
    """Where the robot is in the map, as localised."""
    devices: dict[str, DeviceState]
    """Its devices by id."""
    frames: dict[str, PoseInfo]
    """Frames of its devices in the map by id: the tip of an arm, the optical frame of a camera."""


class DeviceReading(DeviceState):
    """A device at one moment, with its signals."""

    id: str = Field(examples=["gripper_1"])
    """Its id."""
    time: float = Field(examples=[45.8])
    """Run time [s]."""
    cycle: int = Field(examples=[9160])
    """Number of the control cycle."""
    signals: dict[str, SignalValue] = Field(examples=[{"gap": 0.051, "force": 30.0}])
    """The values that it offers, by name."""


class CellSignal(SignalInfo):
    """A signal of the cell: of a device, computed, or set from outside."""

    name: str = Field(examples=["gripper_1.force"])
    """Its name, as conditions and expressions use it."""
    length: int | None = Field(examples=[3])
    """Number of values of a computed vector; null for any other."""
    source: str = Field(examples=["gripper_1"])
    """Device or provider that gives it."""
    input: bool = Field(examples=[False])
    """Whether it can be set."""


class SignalReading(Answer):
    """The value of a signal in one cycle."""

    value: SignalValue | None = Field(examples=[30.0])
    """The value; null where it has none."""
    reason: str = Field(examples=[""])
    """Why it has no value; empty where it has one."""


class SignalReadings(Answer):
    """Values of signals in one control cycle."""

    time: float = Field(examples=[45.8])
    """Run time [s]."""
    cycle: int = Field(examples=[9160])
    """Number of the control cycle."""
    signals: dict[str, SignalReading]
    """The values by the names of the signals."""


class SetSignal(Request):
    """A new value of a signal."""

    value: bool | Number | tuple[Number, ...] = Field(examples=[0.3])
    """The value, in its unit."""


class Seen(Answer):
    """One thing that was recognised, or not."""

    type: str | None = Field(examples=["kitting:Starter"])
    """Its class; null for what fits no known shape."""
    pose: PoseInfo
    """Where it is in the map."""
    size: tuple[float, float, float]
    """Length, width, height of the box around it [m]."""
    cost: float = Field(examples=[0.0011])
    """Mean misfit of the shape [m]; smaller is better."""
    margin: float = Field(examples=[0.004])
    """By how much the next best shape fits worse [m]."""


class Look(Answer):
    """The last picture that a camera took for somebody, as points."""

    number: int = Field(examples=[3])
    """Counts the looks of this camera; 0 when there was none yet."""
    camera: str = Field(examples=["camera_1"])
    """The camera."""
    time: float = Field(examples=[21.4])
    """When it was taken [s, run time]."""
    pose: PoseInfo | None
    """Where the camera was in the map; z looks forward. Null for no look yet."""
    points: str
    """What it saw: x, y, z in the map [m] as little-endian 32-bit floats, in base64."""
    colours: str
    """Red, green, blue of each point (0 to 255) as bytes, in base64; empty for none."""
    seen: tuple[Seen, ...]
    """What was made out in it."""
    purpose: str = Field(examples=["parts"])
    """What the look was for: parts, or a kit's exact pose."""


class DeviceMotion(Answer):
    """The planned motion of a device: the path of a base, the motion of an arm."""

    number: int = Field(examples=[7])
    """Changes with the planned motion; 0 if there was none yet."""
    poses: tuple[PoseInfo, ...]
    """Poses in the map along it: of a base, or of the tip of an arm; empty while nothing is planned."""
