"""Robots: what they are made of, their devices and signals, where they are, what they saw, and moving them by hand."""

from __future__ import annotations

from typing import Annotated, Any, Literal, Self

from pydantic import ConfigDict, Field, model_validator

from skiros_py.api.modules import Arguments
from skiros_py.api.view import ArmInfo, BaseInfo, GripperInfo, PoseInfo
from skiros_py.api.wire import Answer, Name, Request

Number = Annotated[float, Field(allow_inf_nan=False)]
Turn = Annotated[float, Field(ge=-0.2, le=0.2)]
Length = Annotated[float, Field(ge=-0.1, le=0.1)]
Angle = Annotated[float, Field(ge=-0.35, le=0.35)]
Step = Annotated[float, Field(ge=-0.2, le=0.2)]


class JointDescription(Answer):
    """One joint of an arm."""

    name: str = Field(examples=["panda_joint1"])
    """Its name."""
    lower: float | None = Field(examples=[-2.9])
    """Least angle [rad]; null where it has no limit."""
    upper: float | None = Field(examples=[2.9])
    """Greatest angle [rad]; null where it has no limit."""
    velocity: float | None = Field(examples=[2.1])
    """Greatest speed [rad/s]; null if unknown."""


class ArmDescription(Answer):
    """One arm."""

    id: str = Field(examples=["arm_1"])
    """Its id."""
    joints: tuple[JointDescription, ...]
    """Its joints, in the order of all numbers about it."""
    home: tuple[float, ...]
    """Joint angles in which it travels [rad]."""
    tip: str = Field(examples=["tcp"])
    """Link of the model that is its tool."""


class GripperDescription(Answer):
    """One gripper."""

    id: str = Field(examples=["gripper_1"])
    """Its id."""
    arm: str = Field(examples=["arm_1"])
    """The arm that it is on."""
    joints: tuple[str, ...] = Field(default=(), examples=[["panda_finger_joint1", "panda_finger_joint2"]])
    """Joints of its fingers in the model; each stands at half the gap [m]."""
    max_gap: float = Field(examples=[0.08])
    """Greatest distance between the fingers [m]."""
    max_force: float = Field(examples=[70.0])
    """Greatest force of each finger [N]."""


class BaseDescription(Answer):
    """The base."""

    id: str = Field(examples=["base_1"])
    """Its id."""
    joints: tuple[str, ...] = Field(default=(), examples=[["base_x", "base_y", "base_yaw"]])
    """Joints of the model that stand at the base's x [m], y [m] and heading [rad] in the map; none where its model is
    not known.
    """
    max_linear: float = Field(examples=[0.5])
    """Greatest speed [m/s]."""
    max_angular: float = Field(examples=[0.8])
    """Greatest turning speed [rad/s]."""
    footprint: tuple[tuple[float, float], ...]
    """Corners of its outline in its frame [m]."""


class CameraDescription(Answer):
    """One camera."""

    id: str = Field(examples=["camera_1"])
    """Its id."""
    frame: str = Field(default="", examples=["camera_optical"])
    """Link of the model from which it looks: z forward, x to the right in its image, y down."""
    width: int = Field(examples=[640])
    """Width of its image [px]."""
    height: int = Field(examples=[480])
    """Height of its image [px]."""
    vertical_fov: float = Field(examples=[0.9])
    """Vertical field of view [rad]."""


class RobotInfo(Answer):
    """What a robot is made of."""

    id: str = Field(examples=["robot_1"])
    """Its id."""
    label: str = Field(examples=["robot"])
    """Its name for people."""
    model: str = Field(examples=["mobile_panda"])
    """Name of its model."""
    base: BaseDescription | None
    """Its base; null for a robot that stands still, or that something else moves."""
    carrier: str | None = Field(examples=["base_1"])
    """Id of the device that moves it through the map, of whatever kind; null for a robot that stands still."""
    place: PoseInfo | None
    """Where in the map a robot stands that nothing moves; null for others."""
    footprint: tuple[tuple[float, float], ...]
    """Corners of its outline on the floor [m]."""
    arms: tuple[ArmDescription, ...]
    """Its arms."""
    grippers: tuple[GripperDescription, ...]
    """Its grippers."""
    cameras: tuple[CameraDescription, ...]
    """Its cameras."""
    agents: tuple[str, ...] = Field(examples=[["arm_1", "base_1"]])
    """Subsystems that have skill managers."""


class ArmReading(ArmInfo):
    """An arm at one moment."""

    tool: PoseInfo | None
    """Where its tool is in the map, by localisation; null where unknown."""


class RobotReading(Answer):
    """A robot at one moment."""

    id: str = Field(examples=["robot_1"])
    """Its id."""
    time: float = Field(examples=[45.8])
    """Run time [s]."""
    cycle: int = Field(examples=[9160])
    """Number of the control cycle."""
    halted: str = Field(examples=[""])
    """Why everything is halted; empty while it is not."""
    at: str = Field(examples=["pallet_a"])
    """Id of the place where it is believed to be; empty for none."""
    base: BaseInfo | None
    """Its base; null where it has none."""
    pose: PoseInfo
    """Where the robot is in the map, as localised."""
    arms: dict[str, ArmReading]
    """Its arms by id."""
    grippers: dict[str, GripperInfo]
    """Its grippers by id."""


class JogJoints(Request):
    """Turns the joints of an arm by a little."""

    arm: Name | None = Field(None, examples=["arm_1"])
    """The arm; may be left out where there is one."""
    deltas: tuple[Turn, ...] = Field(min_length=1, max_length=20, examples=[[0.1, 0, 0, 0, 0, 0, 0]])
    """By how much each joint turns [rad], at most 0.2."""


class JogTool(Request):
    """Moves the tool of an arm by a little, on a straight line."""

    arm: Name | None = Field(None, examples=["arm_1"])
    """The arm; may be left out where there is one."""
    frame: Name = Field("tool", examples=["map"])
    """Along whose axes: tool, base, map, or the id of an element."""
    translation: tuple[Length, Length, Length] = Field((0.0, 0.0, 0.0), examples=[[0.0, 0.0, -0.05]])
    """Along x, y, z [m]; 0.1 m at most in all."""
    rotation: tuple[Angle, Angle, Angle] = Field((0.0, 0.0, 0.0), examples=[[0.0, 0.0, 0.1]])
    """Axis, as long as it turns about the tool's tip [rad]; 0.35 rad at most."""
    near: Name | None = Field(None, examples=["starter_1"])
    """A thing that the gripper may touch, with what it lies on."""


class JogBase(Request):
    """Drives the base by a little; a step to the side is a turn, a straight way and a turn back."""

    dx: Step = Field(0.0, examples=[0.1])
    """How far ahead [m]."""
    dy: Step = Field(0.0, examples=[0.0])
    """How far to the left [m]; 0.2 m at most with `dx`."""
    dyaw: Angle = Field(0.0, examples=[0.0])
    """How far it turns to the left [rad]."""


class JogGripper(Request):
    """Moves the fingers."""

    gripper: Name | None = None
    """The gripper; may be left out where there is one."""
    width: float = Field(ge=0.0, le=1.0, examples=[0.04])
    """Distance between the fingers afterwards [m]."""


class Jog(Request):
    """Moves a robot by a little: exactly one of joints, tool, base, gripper."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {"joints": {"arm": "arm_1", "deltas": [0.1, 0, 0, 0, 0, 0, 0]}},
                {"tool": {"frame": "map", "translation": [0, 0, -0.05]}},
                {"base": {"dx": 0.1}},
                {"gripper": {"width": 0.04}},
            ]
        }
    )

    joints: JogJoints | None = None
    """Turns joints."""
    tool: JogTool | None = None
    """Moves the tool."""
    base: JogBase | None = None
    """Drives the base."""
    gripper: JogGripper | None = None
    """Moves the fingers."""

    @model_validator(mode="after")
    def _is_one(self) -> Self:
        given = [one for one in (self.joints, self.tool, self.base, self.gripper) if one is not None]
        if len(given) != 1:
            raise ValueError("give exactly one of joints, tool, base and gripper")
        return self


class Teach(Request):
    """Teaches a robot, as it stands now."""

    model_config = ConfigDict(
        json_schema_extra={"examples": [{"what": "driving-pose", "arguments": {"location": "pallet_a"}}]}
    )

    what: Literal["grasp", "driving-pose", "placing-pose"]
    """What it learns."""
    arguments: Arguments = Field(default_factory=dict, examples=[{"location": "pallet_a", "type": "kitting:Pallet"}])
    """Of the primitive that learns it: teach_grasp, teach_driving_pose, teach_placing_pose."""


class HomeRobot(Request):
    """Brings arms home."""

    model_config = ConfigDict(json_schema_extra={"examples": [{}]})

    arm: Name | None = Field(None, examples=["arm_1"])
    """The arm; all arms where left out."""


SignalValue = bool | float | tuple[float, ...]
"""A truth value, a number, or numbers."""


class SignalInfo(Answer):
    """A value that a device offers in each cycle."""

    name: str = Field(examples=["force"])
    """Its name, as conditions use it."""
    unit: str = Field(examples=["N"])
    """Its unit; empty for truth values and pure numbers."""
    frame: str = Field(examples=[""])
    """"map", "own" for the frame of the device; empty where none matters."""
    help: str = Field(examples=["force per finger"])
    """Its meaning."""


class DeviceInfo(Answer):
    """One device."""

    id: str = Field(examples=["gripper_1"])
    """Its id."""
    kind: str = Field(examples=["gripper"])
    """Its kind."""
    robot: str | None = Field(examples=["robot_1"])
    """The robot that it belongs to; null for none."""
    description: dict[str, Any] = Field(examples=[{"max_gap": 0.08}])
    """What is known of it, by the names that its kind uses."""
    signals: tuple[SignalInfo, ...]
    """The values that it offers."""
    open: bool = Field(examples=[True])
    """Whether it may be used; false after it was closed."""
    commanded: bool = Field(examples=[True])
    """Whether it takes commands; false for a sensor."""
    jog: str = Field(examples=["gripper_control"])
    """Module that moves it by a little; empty for none."""
    teach: str = Field(examples=[""])
    """Module that teaches a pose with it; empty for none."""


class DeviceReading(Answer):
    """A device at one moment."""

    id: str = Field(examples=["gripper_1"])
    """Its id."""
    time: float = Field(examples=[45.8])
    """Run time [s]."""
    cycle: int = Field(examples=[9160])
    """Number of the control cycle."""
    still: bool = Field(examples=[True])
    """Whether it stands, so that a stop need not wait for it."""
    state: dict[str, Any] | None = Field(examples=[{"gap": 0.051, "force": 30.0, "still": True}])
    """What it says, by the names that its kind uses; null for one that is only asked, a camera."""
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


class Waypoint(Answer):
    """A point on a base's way."""

    x: float = Field(examples=[1.2])
    """In the map [m]."""
    y: float = Field(examples=[0.4])
    """In the map [m]."""
    heading: float = Field(examples=[1.57])
    """Heading in the map [rad]."""


class ArmWay(Answer):
    """Where an arm's tool is about to go."""

    arm: str = Field(examples=["arm_1"])
    """The arm."""
    points: tuple[tuple[float, float, float], ...]
    """The tip's positions in the map [m]."""


class RobotMotion(Answer):
    """What a robot is about to do, or did last."""

    number: int = Field(examples=[7])
    """Counts the plans of this robot; 0 when there was none yet."""
    base: tuple[Waypoint, ...]
    """The base's way; empty where it stands."""
    arms: tuple[ArmWay, ...]
    """The arms' ways; empty where they stand."""
