"""Kinematics of a whole robot, and inverse kinematics by damped least squares, inside the joint limits."""

from __future__ import annotations

import math
import threading
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pinocchio as pin

from skiros_py.errors import UnknownName
from skiros_py.geometry import Array, Pose
from skiros_py.motion.pinocchio.arm_model import ArmModel
from skiros_py.ports.kinematics import BASE_LINK, InverseKinematics, JointMotion, JointRange, write_robot_urdf

_ITERATIONS = 40
_POSITION_TOLERANCE = 1e-6  # [m] the last step converges quadratically, so being exact costs one more iteration
_ANGLE_TOLERANCE = 1e-5  # [rad]
_CLAMPED_JOINTS = 3  # joints at their limit for which the others may compensate in one step
_STRENGTH = 0.2  # share of the difference made up by each
_LARGEST_STEP = 0.6  # [rad] per iteration


class IkSolver(InverseKinematics):
    """Damped least squares; a :class:`skiros_py.ports.kinematics.InverseKinematics`.

    Args:
        arm: The kinematic model.
    """

    def __init__(self, arm: ArmModel) -> None:
        self._arm = arm
        self._identity = np.eye(6)

    def solve(
        self,
        target: Array,
        seed: Array,
        *,
        towards: Array | None = None,
        pulls: int = 1,
        strength: float = _STRENGTH,
        iterations: int = _ITERATIONS,
    ) -> Array | None:
        """Iterates from one seed; returns joint angles within the limits [rad], or None where it finds none."""
        goal = pin.SE3(target)
        q, nowhere = seed.copy(), np.zeros(len(seed))
        for iteration in range(iterations):
            pose, jacobian = self._arm.tip_jacobian(q)
            error = pin.log6(pose.actInv(goal)).vector
            pulled = towards is not None and iteration < pulls
            close = error[:3] @ error[:3] < _POSITION_TOLERANCE**2 and error[3:] @ error[3:] < _ANGLE_TOLERANCE**2
            if close and not pulled:
                return q
            drift = strength * (towards - q) if towards is not None and pulled else nowhere
            q = self._step(q, jacobian, error, drift)
        return None

    def unwound(self, q: Array, reference: Array) -> Array:
        """Returns the posture with each joint, by whole turns, as near to a reference as its limits allow [rad]."""
        nearer = q + self._arm.turn * np.round((reference - q) / math.tau)
        return np.where((nearer >= self._arm.lower) & (nearer <= self._arm.upper), nearer, q)

    def _step(self, q: Array, jacobian: Array, error: Array, drift: Array) -> Array:
        """Moves towards the target; the other joints compensate for a joint that would leave its range."""
        free = np.ones(len(q), dtype=bool)
        for _ in range(_CLAMPED_JOINTS):
            step = self._least_squares(jacobian * free, error, drift * free)
            wanted = q + step
            inside = (wanted >= self._arm.lower) & (wanted <= self._arm.upper)
            if inside.all():
                return wanted
            free &= inside | (step == 0.0)
        return np.clip(wanted, self._arm.lower, self._arm.upper)

    def _least_squares(self, jacobian: Array, error: Array, drift: Array) -> Array:
        damping = 1e-9 + 1e-3 * float(error @ error)
        square = jacobian @ jacobian.T + damping * self._identity
        step: Array = drift + jacobian.T @ np.linalg.solve(square, error - jacobian @ drift)
        largest = float(np.abs(step).max())
        return step if largest <= _LARGEST_STEP else step * (_LARGEST_STEP / largest)


class PinocchioKinematics:
    """The links and joints of a robot model: a :class:`skiros_py.ports.kinematics.Kinematics` and ``Dynamics``.

    Args:
        urdf: Its description. Poses are seen from its base link, or from its root where it has no link of that name.

    Attributes:
        parents: The link on which each link is mounted.
        joints: The movable joints by name.
    """

    def __init__(self, urdf: Path) -> None:
        model = self._model = pin.buildModelFromUrdf(str(urdf))
        self._data = threading.local()
        self._joints = {
            name: joint
            for number, (name, joint) in enumerate(zip(model.names, model.joints, strict=True))
            if number and joint.nv == 1  # number 0 is Pinocchio's own joint "universe"
        }
        self._neutral: Array = pin.neutral(model)
        self._places: dict[str, tuple[int, int, int]] = {
            name: (joint.idx_q, joint.idx_v, joint.nq) for name, joint in self._joints.items()
        }
        self.joints: Mapping[str, JointRange] = {name: self._range(joint) for name, joint in self._joints.items()}
        bodies = [frame for frame in model.frames if frame.type == pin.FrameType.BODY]
        self._frames = {str(frame.name): int(model.getFrameId(frame.name)) for frame in bodies}
        self._base = self._frames.get(BASE_LINK, next(iter(self._frames.values())))
        self.parents: Mapping[str, str] = dict(self._mounts())

    def pose(self, link: str, positions: Mapping[str, float]) -> Pose:
        """Returns the pose of a link in the frame of the base link.

        Raises:
            UnknownName: The robot has no such link.
        """
        frame = self._frame(link)
        data = self._computed(positions)
        return _pose(data.oMf[self._base].actInv(data.oMf[frame]))

    def poses(self, positions: Mapping[str, float]) -> dict[str, Pose]:
        """Returns the poses of all links in the frame of the base link."""
        data = self._computed(positions)
        base = data.oMf[self._base]
        return {link: _pose(base.actInv(data.oMf[self._frames[link]])) for link in self.parents}

    def jacobian(self, link: str, positions: Mapping[str, float], joints: Sequence[str]) -> Array:
        """Returns the velocity of a link per velocity of some joints, in the frame of the link, shape (6, joints).

        Raises:
            UnknownName: The robot has no such link or joint.
        """
        frame, columns = self._frame(link), [self._column(joint) for joint in joints]
        whole = pin.computeFrameJacobian(self._model, self._fresh(), self._posture(positions), frame, pin.LOCAL)
        return np.asarray(whole[:, columns])

    @property
    def mass(self) -> float:
        """Mass of the robot [kg]."""
        return float(pin.computeTotalMass(self._model))

    def efforts(self, motion: JointMotion) -> Array:
        """Returns what joints exert for a motion [N m or N].

        Raises:
            UnknownName: The robot has no such joint.
        """
        indices = [self._column(name) for name in motion.joints]
        velocities, accelerations = np.zeros(self._model.nv), np.zeros(self._model.nv)
        velocities[indices], accelerations[indices] = motion.velocities, motion.accelerations
        posture = self._posture(dict(zip(motion.joints, motion.positions, strict=True)))
        whole = pin.rnea(self._model, self._fresh(), posture, velocities, accelerations)
        return np.asarray(whole[indices])

    def _column(self, joint: str) -> int:
        """Returns the place of a joint among the velocities."""
        if joint not in self._places:
            raise UnknownName("joint", joint, self._places)
        return self._places[joint][1]

    def _computed(self, positions: Mapping[str, float]) -> pin.Data:
        data = self._fresh()
        pin.framesForwardKinematics(self._model, data, self._posture(positions))
        return data

    def _fresh(self) -> pin.Data:
        """Returns the workspace of the calling thread."""
        if not hasattr(self._data, "own"):
            self._data.own = self._model.createData()
        return self._data.own

    def _posture(self, positions: Mapping[str, float]) -> Array:
        posture = self._neutral.copy()
        for name, position in positions.items():
            place, _, size = self._places.get(name, (0, 0, 0))
            if size == 1:
                posture[place] = position
            elif size == 2:  # a joint that turns without end
                posture[place : place + 2] = math.cos(position), math.sin(position)
        return posture

    def _range(self, joint: pin.JointModel) -> JointRange:
        speed, effort = (
            float(limits[joint.idx_v]) if 0.0 < limits[joint.idx_v] < math.inf else None
            for limits in (self._model.velocityLimit, self._model.effortLimit)
        )
        if joint.nq != 1:
            return JointRange(None, None, speed, effort)
        lower, upper = self._model.lowerPositionLimit[joint.idx_q], self._model.upperPositionLimit[joint.idx_q]
        return JointRange(float(lower), float(upper), speed, effort)

    def _mounts(self) -> list[tuple[str, str]]:
        """Returns the links below the base link, each with the link on which it is mounted."""
        found: dict[str, str] = {}
        base = str(self._model.frames[self._base].name)
        for link, index in self._frames.items():
            frame = self._model.frames[index]
            while frame.parentFrame != 0:
                frame = self._model.frames[frame.parentFrame]
                if frame.type == pin.FrameType.BODY:
                    break
            if frame.name != link and (frame.name == base or frame.name in found):
                found[link] = str(frame.name)
        return list(found.items())

    def _frame(self, link: str) -> int:
        if link not in self._frames:
            raise UnknownName("link", link, self._frames)
        return self._frames[link]


@cache
def kinematics_of(model: str) -> PinocchioKinematics:
    """Returns the kinematics of a robot model, which is loaded once.

    Raises:
        UnknownName: No distribution provides that model.
        SkirosError: It cannot be read.
    """
    with TemporaryDirectory(prefix="skiros-model-") as directory:
        return PinocchioKinematics(write_robot_urdf(model, Path(directory)))


def _pose(placement: pin.SE3) -> Pose:
    x, y, z, *orientation = pin.SE3ToXYZQUAT(placement).tolist()
    return Pose((x, y, z), tuple(orientation))
