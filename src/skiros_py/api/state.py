"""The robots' state at one moment on the wire."""

from __future__ import annotations

from pydantic import Field

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
