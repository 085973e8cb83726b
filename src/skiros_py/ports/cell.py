"""A robot cell as plain data: what a driver (a simulator or real hardware) needs to know to bring it up.

It is read from the world model once, before anything moves; adapters see this and never the world model.
"""

from __future__ import annotations

from dataclasses import dataclass

from skiros_py.geometry import Pose, Solid

__all__ = ["ArmSpec", "BaseSpec", "BodySpec", "CameraSpec", "CellSpec", "GripperSpec", "RobotSpec"]


@dataclass(frozen=True, slots=True)
class BodySpec:
    """One body of the scene.

    Attributes:
        id: Its element id.
        type: Its class ("kitting:Starter"); bodies of one type have one solid.
        solid: Its shape, standing on its own frame.
        mass: [kg]; 0 for what never moves.
        pose: Pose of its frame in the map (or in ``carrier``'s base frame), or None: the driver of a simulation draws
            it from the run's seed, somewhere on ``place``'s support surface.
        place: Id of the body that it lies on or in, or None for the floor.
        carrier: Id of the robot base it is fixed to, or None.
        support: Half extents (x, y) [m] of the flat surface on which parts lie; None where nothing can lie.
        support_height: Height of that surface above the body's frame [m].
        support_centre: Middle (x, y) of that surface in the body's frame [m].
        compartment: True for a compartment: a region, not a body of its own; ``solid`` is its inner volume.
    """

    id: str
    type: str
    solid: Solid
    mass: float = 0.0
    pose: Pose | None = None
    place: str | None = None
    carrier: str | None = None
    support: tuple[float, float] | None = None
    support_height: float = 0.0
    support_centre: tuple[float, float] = (0.0, 0.0)
    compartment: bool = False


@dataclass(frozen=True, slots=True)
class ArmSpec:
    """One arm.

    Attributes:
        id: Its element id.
        joints: Joint names in the robot's URDF, in the order of every vector about this arm.
        tip: URDF link that motions are planned for (the tool centre point).
        home: Joint angles [rad] in which it starts and travels.
    """

    id: str
    joints: tuple[str, ...]
    tip: str
    home: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class GripperSpec:
    """A parallel gripper: finger joint names, mounted arm's id, greatest gap [m] and greatest force per finger [N]."""

    id: str
    joints: tuple[str, ...]
    arm: str
    max_gap: float
    max_force: float


@dataclass(frozen=True, slots=True)
class BaseSpec:
    """A differential-drive base.

    Attributes:
        id: Its element id.
        start: Pose in the map where it stands at the start.
        max_linear, max_angular: Speed limits [m/s, rad/s].
        max_linear_acceleration, max_angular_acceleration: Acceleration and braking limits [m/s², rad/s²].
        footprint: Corners of its outline on the floor in the base frame [m], counter-clockwise.
    """

    id: str
    start: Pose
    max_linear: float
    max_angular: float
    max_linear_acceleration: float
    max_angular_acceleration: float
    footprint: tuple[tuple[float, float], ...]


@dataclass(frozen=True, slots=True)
class CameraSpec:
    """A depth camera.

    Attributes:
        id: Its element id.
        frame: URDF link of its optical frame.
        width, height: Image size [px].
        vertical_fov: Vertical field of view [rad].
        near, far: Range of depth [m].
        noise: Standard deviation of depth noise [m].
        latency: Time from request to image [s].
    """

    id: str
    frame: str
    width: int
    height: int
    vertical_fov: float
    near: float
    far: float
    noise: float
    latency: float


@dataclass(frozen=True, slots=True)
class RobotSpec:
    """One robot: a name for its model and its devices.

    Attributes:
        id: Its element id.
        model: Name of the robot model that the adapters know how to build ("mobile_panda").
        base, arms, grippers, cameras: Its devices.
    """

    id: str
    model: str
    base: BaseSpec
    arms: tuple[ArmSpec, ...]
    grippers: tuple[GripperSpec, ...]
    cameras: tuple[CameraSpec, ...]


@dataclass(frozen=True, slots=True)
class CellSpec:
    """Everything that stands in the cell at the start: bodies in the order they are built, and robots."""

    bodies: tuple[BodySpec, ...]
    robots: tuple[RobotSpec, ...]

    def body(self, body_id: str) -> BodySpec:
        """Returns the body with that id.

        Raises:
            KeyError: There is none.
        """
        for body in self.bodies:
            if body.id == body_id:
                return body
        raise KeyError(body_id)
