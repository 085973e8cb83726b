"""One arm of a robot as a kinematic model, seen from the robot's base frame."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property, lru_cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import coal
import numpy as np
import pinocchio as pin

from skiros_py.devices.arm import ArmSpec
from skiros_py.devices.gripper import GripperSpec
from skiros_py.errors import UnknownName
from skiros_py.geometry import Array, Pose
from skiros_py.ports.cell import RobotSpec
from skiros_py.ports.kinematics import write_robot_urdf

_FEWEST_JOINTS, _POSTURES, _SLACK = 4, 4000, 0.01  # [m] how far postures at random may miss the farthest one
_ACCELERATION = 7.5  # [rad/s²] of an arm whose description states none; that of the weakest joint of a Panda
_SLIDING = 2.0  # [m/s²] of a joint that slides, likewise: a linear axis carries a whole arm


def se3(pose: Pose) -> pin.SE3:
    """Returns a pose as Pinocchio's rigid transform."""
    return pin.SE3(pose.matrix())


@dataclass(frozen=True, slots=True, eq=False)
class RevoluteChain:
    """Revolute joints, each mounted on the one before, and a tip on the last one.

    Attributes:
        placements: Pose of each joint's frame at zero in that of the joint before, the first one in the frame of the
            robot's base, and last that of the tip in the frame of the last joint, shape (joints + 1, 4, 4).
        axes: About what they turn, in their own frames, shape (joints, 3).
        lower, upper: Joint limits [rad].
    """

    placements: Array
    axes: Array
    lower: Array
    upper: Array


@dataclass(frozen=True, slots=True, eq=False)
class _Wrist:
    """Where the last joint but one of an arm can be: what the other joints do, and what the tip leaves open.

    Attributes:
        middle, axis, radius: The circle on which it is, in the frame of the tip [m].
        nearest, farthest: Bounds of how far it can be from the shoulder [m].
    """

    middle: Array
    axis: Array
    radius: float
    nearest: float
    farthest: float


class ArmModel:
    """The arm's joints alone; base and wheels stand at zero, so everything is seen from the robot's base frame.

    Args:
        urdf: The robot's description.
        arm: The joints and the tip.
        grippers: Grippers of the robot; those on this arm move their fingers with the gap.

    Attributes:
        lower, upper: Joint limits [rad or m].
        velocity: Joint speed limits [rad/s or m/s].
        acceleration: Joint acceleration limits [rad/s² or m/s²].
        turn: A whole turn of each joint [rad]; 0 for one that slides.
        reach: Upper bound of the distance from the arm's shoulder to its tip [m].
    """

    def __init__(self, urdf: Path, arm: ArmSpec, grippers: Iterable[GripperSpec] = ()) -> None:
        self.spec = arm
        self._full = pin.buildModelFromUrdf(str(urdf))
        self._shapes = _convex_shapes(self._full, urdf)
        self._grippers = tuple(gripper for gripper in grippers if gripper.arm == arm.id)
        self.model, _ = self._reduced(0.0)
        self._data = self.model.createData()
        if not self.model.existFrame(arm.tip):
            links = [frame.name for frame in self.model.frames if frame.type == pin.FrameType.BODY]
            raise UnknownName("link", arm.tip, links)
        self.tip = int(self.model.getFrameId(arm.tip))
        self.lower: Array = np.array(self.model.lowerPositionLimit)
        self.upper: Array = np.array(self.model.upperPositionLimit)
        self.velocity: Array = np.array(self.model.velocityLimit)
        turns = [joint.shortname().startswith("JointModelR") for joint in list(self.model.joints)[1:]]
        self.turn: Array = math.tau * np.array(turns)
        usual = np.where(self.turn > 0.0, _ACCELERATION, _SLIDING)
        self.acceleration: Array = np.array(arm.accelerations) if arm.accelerations else usual
        steps = [placement.translation for placement in list(self.model.jointPlacements)[3:]]
        steps.append(self.model.frames[self.tip].placement.translation)
        travel = np.maximum(np.abs(self.lower), np.abs(self.upper))[self.turn == 0.0]
        self.reach = float(sum(np.linalg.norm(step) for step in steps) + travel.sum())

    def beyond_limits(self, q: Array, slack: float) -> str:
        """Returns which joint is farthest outside its limits; an empty text if none is beyond a slack [rad or m]."""
        beyond = np.maximum(self.lower - q, q - self.upper)
        worst = int(np.argmax(beyond))
        if beyond[worst] <= slack:
            return ""
        unit = "rad" if self.turn[worst] else "m"
        limits = f"{self.lower[worst]:.3f} to {self.upper[worst]:.3f} {unit}"
        return f"{self.spec.joints[worst]} at {q[worst]:.3f} {unit}, outside its limits of {limits}"

    def tip_pose(self, q: Array) -> pin.SE3:
        """Returns the pose of the tip at joint angles [rad]."""
        pin.framesForwardKinematics(self.model, self._data, q)
        return self._data.oMf[self.tip].copy()

    def tip_jacobian(self, q: Array) -> tuple[pin.SE3, Array]:
        """Returns the tip's pose and its Jacobian in the tip frame, shape (6, n): linear part first."""
        pin.computeJointJacobians(self.model, self._data, q)
        pose = pin.updateFramePlacement(self.model, self._data, self.tip)
        return pose, pin.getFrameJacobian(self.model, self._data, self.tip, pin.LOCAL)

    def joint_places(self, q: Array) -> Array:
        """Returns where the joints are at joint angles [rad], in the frame of the base [m], shape (n, 3)."""
        pin.forwardKinematics(self.model, self._data, q)
        return np.array([placement.translation for placement in list(self._data.oMi)[1:]])

    @property
    def chain(self) -> RevoluteChain | None:
        """The joints as a chain; None where one is not revolute or not mounted on the one before."""
        model, tip, joints = self.model, self.model.frames[self.tip], range(1, self.model.njoints)
        pin.computeJointJacobians(model, self._data, pin.neutral(model))
        columns = [pin.getJointJacobian(model, self._data, joint, pin.LOCAL)[:, joint - 1] for joint in joints]
        serial = tip.parentJoint == joints[-1] and all(model.parents[joint] == joint - 1 for joint in joints)
        if not serial or any(column[:3].any() for column in columns):
            return None
        placements = [*list(model.jointPlacements)[1:], tip.placement]
        axes = np.array([column[3:] for column in columns])
        return RevoluteChain(np.array([one.homogeneous for one in placements]), axes, self.lower, self.upper)

    @cached_property
    def shoulder(self) -> Array:
        """Where the second joint of the arm is [m]."""
        pin.forwardKinematics(self.model, self._data, pin.neutral(self.model))
        return np.array(self._data.oMi[min(2, self.model.njoints - 1)].translation)

    def is_beyond_reach(self, target: Array) -> bool:
        """Returns whether a pose of the tip, in the frame of the base, is surely out of reach, whatever its joints do.

        The last joint turns the wrist, where the joint before it is, on a circle about its own axis; how far the wrist
        can be from the shoulder is known. Of arms with other joints than revolute ones, the length of the links tells.

        Args:
            target: The pose, shape (4, 4).
        """
        wrist = self._wrist
        if wrist is None:
            return float(np.linalg.norm(target[:3, 3] - self.shoulder)) > self.reach
        axis = target[:3, :3] @ wrist.axis
        off = self.shoulder - (target[:3, :3] @ wrist.middle + target[:3, 3])
        along = float(off @ axis)
        aside = math.sqrt(max(0.0, float(off @ off) - along * along))
        nearest, farthest = math.hypot(along, aside - wrist.radius), math.hypot(along, aside + wrist.radius)
        return nearest > wrist.farthest or farthest < wrist.nearest

    @cached_property
    def _wrist(self) -> _Wrist | None:
        chain = self.chain
        if chain is None or len(chain.axes) < _FEWEST_JOINTS:
            return None
        axis, in_tip = chain.axes[-1], pin.SE3(chain.placements[-1]).inverse()
        at = pin.SE3(chain.placements[-2]).inverse().translation  # in the frame of the last joint
        on_axis = (at @ axis) * axis
        postures = np.random.default_rng(0).uniform(self.lower, self.upper, (_POSTURES, len(self.lower)))
        ways = [float(np.linalg.norm(self.joint_places(posture)[-2] - self.shoulder)) for posture in postures]
        radius = float(np.linalg.norm(at - on_axis))
        return _Wrist(in_tip.act(on_axis), in_tip.rotation @ axis, radius, min(ways) - _SLACK, max(ways) + _SLACK)

    def collision_shapes(self, gap: float) -> pin.GeometryModel:
        """Returns the convex shapes of the whole robot with the fingers a gap [m] apart, without collision pairs."""
        return self._reduced(gap)[1]

    @cached_property
    def gripper_links(self) -> frozenset[str]:
        """Links that move rigidly with the tip or are fingers: what may touch a part to be grasped."""
        frames = self._full.frames
        joints = (frames[self._full.getFrameId(joint)] for gripper in self._grippers for joint in gripper.joints)
        mounts = {str(frames[joint.parentFrame].name) for joint in joints}
        mounts.add(frames[self._full.getFrameId(self.spec.tip)].name)
        bodies = [frame for frame in self._full.frames if frame.type == pin.FrameType.BODY]
        return frozenset(frame.name for frame in bodies if mounts & self._ancestors(frame))

    def _reduced(self, gap: float) -> tuple[pin.Model, pin.GeometryModel]:
        posture = pin.neutral(self._full)
        for name in (joint for gripper in self._grippers for joint in gripper.joints):
            joint = self._full.joints[self._full.getJointId(name)]
            posture[joint.idx_q] = np.clip(gap / 2.0, *self._limits(joint))
        locked = [i for i, name in enumerate(self._full.names) if i > 0 and name not in self.spec.joints]
        return pin.buildReducedModel(self._full, self._shapes, locked, posture)  # type: ignore[no-any-return]

    def _limits(self, joint: Any) -> tuple[float, float]:
        return self._full.lowerPositionLimit[joint.idx_q], self._full.upperPositionLimit[joint.idx_q]

    def _ancestors(self, frame: Any) -> set[str]:
        names = {frame.name}
        while frame.parentFrame != 0:
            frame = self._full.frames[frame.parentFrame]
            names.add(frame.name)
        return names


@lru_cache
def _loaded(model: str, arm: ArmSpec, grippers: tuple[GripperSpec, ...]) -> ArmModel:
    with TemporaryDirectory(prefix="skiros-motion-") as directory:
        return ArmModel(write_robot_urdf(model, Path(directory)), arm, grippers)


def arm_model(robot: RobotSpec, arm: ArmSpec) -> ArmModel:
    """Returns the model of an arm of a robot; it is built once.

    Raises:
        UnknownName: No distribution provides the robot's model.
        SkirosError: The model cannot be read.
    """
    return _loaded(robot.model, arm, robot.of(GripperSpec))


def _convex_shapes(model: pin.Model, urdf: Path) -> pin.GeometryModel:
    """Replaces each mesh by its convex hull, which is what a physics engine collides too."""
    shapes = pin.buildGeomFromUrdf(model, str(urdf), pin.GeometryType.COLLISION, package_dirs=[str(urdf.parent)])
    for shape in shapes.geometryObjects:
        if hasattr(shape.geometry, "vertices"):
            shape.geometry = _hull(np.asarray(shape.geometry.vertices()))
    return shapes


def _hull(points: Array) -> coal.Convex:
    """Returns the convex hull of points, of its corners alone: Coal's own keeps points inside, and errs then."""
    from scipy.spatial import ConvexHull  # half a second of imports that most processes never need

    hull = ConvexHull(points)
    corners, triangles = coal.StdVec_Vec3s(), coal.StdVec_Triangle()
    corners.extend(list(points[hull.vertices]))
    number = {int(vertex): index for index, vertex in enumerate(hull.vertices)}
    triangles.extend([coal.Triangle(*(number[int(vertex)] for vertex in face)) for face in hull.simplices])
    return coal.Convex(corners, triangles)
