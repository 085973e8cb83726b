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

    name: str = Field(description="Its name.", examples=["panda_joint1"])
    lower: float | None = Field(description="Least angle [rad]; null where it has no limit.", examples=[-2.9])
    upper: float | None = Field(description="Greatest angle [rad]; null where it has no limit.", examples=[2.9])
    velocity: float | None = Field(description="Greatest speed [rad/s]; null if unknown.", examples=[2.1])


class ArmDescription(Answer):
    """One arm."""

    id: str = Field(description="Its id.", examples=["arm_1"])
    joints: tuple[JointDescription, ...] = Field(description="Its joints, in the order of all numbers about it.")
    home: tuple[float, ...] = Field(description="Joint angles in which it travels [rad].")
    tip: str = Field(description="Link of the model that is its tool.", examples=["tcp"])


class GripperDescription(Answer):
    """One gripper."""

    id: str = Field(description="Its id.", examples=["gripper_1"])
    arm: str = Field(description="The arm that it is on.", examples=["arm_1"])
    joints: tuple[str, ...] = Field(
        default=(),
        description="Joints of its fingers in the model; each stands at half the gap [m].",
        examples=[["panda_finger_joint1", "panda_finger_joint2"]],
    )
    max_gap: float = Field(description="Greatest distance between the fingers [m].", examples=[0.08])
    max_force: float = Field(description="Greatest force of each finger [N].", examples=[70.0])


class BaseDescription(Answer):
    """The base."""

    id: str = Field(description="Its id.", examples=["base_1"])
    joints: tuple[str, ...] = Field(
        default=(),
        description="Joints of the model that stand at the base's x [m], y [m] and heading [rad] in the map; none where"
        " its model is not known.",
        examples=[["base_x", "base_y", "base_yaw"]],
    )
    max_linear: float = Field(description="Greatest speed [m/s].", examples=[0.5])
    max_angular: float = Field(description="Greatest turning speed [rad/s].", examples=[0.8])
    footprint: tuple[tuple[float, float], ...] = Field(description="Corners of its outline in its frame [m].")


class CameraDescription(Answer):
    """One camera."""

    id: str = Field(description="Its id.", examples=["camera_1"])
    frame: str = Field(
        default="",
        description="Link of the model from which it looks: z forward, x to the right in its image, y down.",
        examples=["camera_optical"],
    )
    width: int = Field(description="Width of its image [px].", examples=[640])
    height: int = Field(description="Height of its image [px].", examples=[480])
    vertical_fov: float = Field(description="Vertical field of view [rad].", examples=[0.9])


class RobotInfo(Answer):
    """What a robot is made of."""

    id: str = Field(description="Its id.", examples=["robot_1"])
    label: str = Field(description="Its name for people.", examples=["robot"])
    model: str = Field(description="Name of its model.", examples=["mobile_panda"])
    base: BaseDescription | None = Field(
        description="Its base; null for a robot that stands still, or that something else moves."
    )
    place: PoseInfo | None = Field(description="Where in the map a robot stands that nothing moves; null for others.")
    footprint: tuple[tuple[float, float], ...] = Field(description="Corners of its outline on the floor [m].")
    arms: tuple[ArmDescription, ...] = Field(description="Its arms.")
    grippers: tuple[GripperDescription, ...] = Field(description="Its grippers.")
    cameras: tuple[CameraDescription, ...] = Field(description="Its cameras.")
    agents: tuple[str, ...] = Field(description="Subsystems that have skill managers.", examples=[["arm_1", "base_1"]])


class ArmReading(ArmInfo):
    """An arm at one moment."""

    tool: PoseInfo | None = Field(description="Where its tool is in the map, by localisation; null where unknown.")


class RobotReading(Answer):
    """A robot at one moment."""

    id: str = Field(description="Its id.", examples=["robot_1"])
    time: float = Field(description="Run time [s].", examples=[45.8])
    cycle: int = Field(description="Number of the control cycle.", examples=[9160])
    halted: str = Field(description="Why everything is halted; empty while it is not.", examples=[""])
    at: str = Field(description="Id of the place where it is believed to be; empty for none.", examples=["pallet_a"])
    base: BaseInfo | None = Field(description="Its base; null where it has none.")
    pose: PoseInfo = Field(description="Where the robot is in the map, as localised.")
    arms: dict[str, ArmReading] = Field(description="Its arms by id.")
    grippers: dict[str, GripperInfo] = Field(description="Its grippers by id.")


class JogJoints(Request):
    """Turns the joints of an arm by a little."""

    arm: Name | None = Field(None, description="The arm; may be left out where there is one.", examples=["arm_1"])
    deltas: tuple[Turn, ...] = Field(
        min_length=1,
        max_length=20,
        description="By how much each joint turns [rad], at most 0.2.",
        examples=[[0.1, 0, 0, 0, 0, 0, 0]],
    )


class JogTool(Request):
    """Moves the tool of an arm by a little, on a straight line."""

    arm: Name | None = Field(None, description="The arm; may be left out where there is one.", examples=["arm_1"])
    frame: Name = Field(
        "tool", description="Along whose axes: tool, base, map, or the id of an element.", examples=["map"]
    )
    translation: tuple[Length, Length, Length] = Field(
        (0.0, 0.0, 0.0), description="Along x, y, z [m]; 0.1 m at most in all.", examples=[[0.0, 0.0, -0.05]]
    )
    rotation: tuple[Angle, Angle, Angle] = Field(
        (0.0, 0.0, 0.0),
        description="Axis, as long as it turns about the tool's tip [rad]; 0.35 rad at most.",
        examples=[[0.0, 0.0, 0.1]],
    )
    near: Name | None = Field(
        None, description="A thing that the gripper may touch, with what it lies on.", examples=["starter_1"]
    )


class JogBase(Request):
    """Drives the base by a little; a step to the side is a turn, a straight way and a turn back."""

    dx: Step = Field(0.0, description="How far ahead [m].", examples=[0.1])
    dy: Step = Field(0.0, description="How far to the left [m]; 0.2 m at most with `dx`.", examples=[0.0])
    dyaw: Angle = Field(0.0, description="How far it turns to the left [rad].", examples=[0.0])


class JogGripper(Request):
    """Moves the fingers."""

    gripper: Name | None = Field(None, description="The gripper; may be left out where there is one.")
    width: float = Field(ge=0.0, le=1.0, description="Distance between the fingers afterwards [m].", examples=[0.04])


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

    joints: JogJoints | None = Field(None, description="Turns joints.")
    tool: JogTool | None = Field(None, description="Moves the tool.")
    base: JogBase | None = Field(None, description="Drives the base.")
    gripper: JogGripper | None = Field(None, description="Moves the fingers.")

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

    what: Literal["grasp", "driving-pose", "placing-pose"] = Field(description="What it learns.")
    arguments: Arguments = Field(
        default_factory=dict,
        description="Of the primitive that learns it: teach_grasp, teach_driving_pose, teach_placing_pose.",
        examples=[{"location": "pallet_a", "type": "kitting:Pallet"}],
    )


class HomeRobot(Request):
    """Brings arms home."""

    model_config = ConfigDict(json_schema_extra={"examples": [{}]})

    arm: Name | None = Field(None, description="The arm; all arms where left out.", examples=["arm_1"])


SignalValue = bool | float | tuple[float, ...]
"""A truth value, a number, or numbers."""


class SignalInfo(Answer):
    """A value that a device offers in each cycle."""

    name: str = Field(description="Its name, as conditions use it.", examples=["force"])
    unit: str = Field(description="Its unit; empty for truth values and pure numbers.", examples=["N"])
    frame: str = Field(description='"map", "own" for the frame of the device; empty where none matters.', examples=[""])
    help: str = Field(description="Its meaning.", examples=["force per finger"])


class DeviceInfo(Answer):
    """One device."""

    id: str = Field(description="Its id.", examples=["gripper_1"])
    kind: str = Field(description="Its kind.", examples=["gripper"])
    robot: str | None = Field(description="The robot that it belongs to; null for none.", examples=["robot_1"])
    description: dict[str, Any] = Field(
        description="What is known of it, by the names that its kind uses.", examples=[{"max_gap": 0.08}]
    )
    signals: tuple[SignalInfo, ...] = Field(description="The values that it offers.")
    open: bool = Field(description="Whether it may be used; false after it was closed.", examples=[True])
    commanded: bool = Field(description="Whether it takes commands; false for a sensor.", examples=[True])
    jog: str = Field(description="Module that moves it by a little; empty for none.", examples=["gripper_control"])
    teach: str = Field(description="Module that teaches a pose with it; empty for none.", examples=[""])


class DeviceReading(Answer):
    """A device at one moment."""

    id: str = Field(description="Its id.", examples=["gripper_1"])
    time: float = Field(description="Run time [s].", examples=[45.8])
    cycle: int = Field(description="Number of the control cycle.", examples=[9160])
    still: bool = Field(description="Whether it stands, so that a stop need not wait for it.", examples=[True])
    state: dict[str, Any] | None = Field(
        description="What it says, by the names that its kind uses; null for one that is only asked, a camera.",
        examples=[{"gap": 0.051, "force": 30.0, "still": True}],
    )
    signals: dict[str, SignalValue] = Field(
        description="The values that it offers, by name.", examples=[{"gap": 0.051, "force": 30.0}]
    )


class CellSignal(SignalInfo):
    """A signal of the cell: of a device, computed, or set from outside."""

    name: str = Field(description="Its name, as conditions and expressions use it.", examples=["gripper_1.force"])
    length: int | None = Field(description="Number of values of a computed vector; null for any other.", examples=[3])
    source: str = Field(description="Device or provider that gives it.", examples=["gripper_1"])
    input: bool = Field(description="Whether it can be set.", examples=[False])


class SignalReading(Answer):
    """The value of a signal in one cycle."""

    value: SignalValue | None = Field(description="The value; null where it has none.", examples=[30.0])
    reason: str = Field(description="Why it has no value; empty where it has one.", examples=[""])


class SignalReadings(Answer):
    """Values of signals in one control cycle."""

    time: float = Field(description="Run time [s].", examples=[45.8])
    cycle: int = Field(description="Number of the control cycle.", examples=[9160])
    signals: dict[str, SignalReading] = Field(description="The values by the names of the signals.")


class SetSignal(Request):
    """A new value of a signal."""

    value: bool | Number | tuple[Number, ...] = Field(description="The value, in its unit.", examples=[0.3])


class Seen(Answer):
    """One thing that was recognised, or not."""

    type: str | None = Field(description="Its class; null for what fits no known shape.", examples=["kitting:Starter"])
    pose: PoseInfo = Field(description="Where it is in the map.")
    size: tuple[float, float, float] = Field(description="Length, width, height of the box around it [m].")
    cost: float = Field(description="Mean misfit of the shape [m]; smaller is better.", examples=[0.0011])
    margin: float = Field(description="By how much the next best shape fits worse [m].", examples=[0.004])


class Look(Answer):
    """The last picture that a camera took for somebody, as points."""

    number: int = Field(description="Counts the looks of this camera; 0 when there was none yet.", examples=[3])
    camera: str = Field(description="The camera.", examples=["camera_1"])
    time: float = Field(description="When it was taken [s, run time].", examples=[21.4])
    pose: PoseInfo | None = Field(description="Where the camera was in the map; z looks forward. Null for no look yet.")
    points: str = Field(description="What it saw: x, y, z in the map [m] as little-endian 32-bit floats, in base64.")
    colours: str = Field(description="Red, green, blue of each point (0 to 255) as bytes, in base64; empty for none.")
    seen: tuple[Seen, ...] = Field(description="What was made out in it.")
    purpose: str = Field(description="What the look was for: parts, or a kit's exact pose.", examples=["parts"])


class Waypoint(Answer):
    """A point on a base's way."""

    x: float = Field(description="In the map [m].", examples=[1.2])
    y: float = Field(description="In the map [m].", examples=[0.4])
    heading: float = Field(description="Heading in the map [rad].", examples=[1.57])


class ArmWay(Answer):
    """Where an arm's tool is about to go."""

    arm: str = Field(description="The arm.", examples=["arm_1"])
    points: tuple[tuple[float, float, float], ...] = Field(description="The tip's positions in the map [m].")


class RobotMotion(Answer):
    """What a robot is about to do, or did last."""

    number: int = Field(description="Counts the plans of this robot; 0 when there was none yet.", examples=[7])
    base: tuple[Waypoint, ...] = Field(description="The base's way; empty where it stands.")
    arms: tuple[ArmWay, ...] = Field(description="The arms' ways; empty where they stand.")
