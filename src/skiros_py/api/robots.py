"""Robots: what they are made of, where they are, and moving them by hand."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import ConfigDict, Field, model_validator

from skiros_py.api.modules import Arguments
from skiros_py.api.state import ArmInfo, BaseInfo, GripperInfo, PoseInfo
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
