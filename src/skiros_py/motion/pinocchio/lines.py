"""Straight motions of the tip: a chain of joint postures along the line, or the reason why there is none."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from skiros_py.geometry import Array
from skiros_py.motion.pinocchio.arm_model import ArmModel
from skiros_py.motion.pinocchio.collision import Checker
from skiros_py.ports.kinematics import InverseKinematics

_STEP = 0.005  # [m] between postures
_TURN_STEP = math.radians(2.0)  # [rad] between postures
_LARGEST_JUMP = 0.15  # [rad] of one joint between postures; more means the arm would have to flip
_CENTRING = 0.01  # share of the way to the middle of the joints' ranges made up with each step
_ITERATIONS = 12


@dataclass(frozen=True, slots=True, eq=False)
class Line:
    """A straight motion of the tip.

    Attributes:
        postures: Joint angles [rad] at even steps along the line, shape (n, joints), n >= 2.
        length: Way of the tip [m].
    """

    postures: Array
    length: float


class LineFollower:
    """Follows straight lines with inverse kinematics, each posture from the one before.

    Args:
        arm: The kinematic model.
        solver: Inverse kinematics.
    """

    def __init__(self, arm: ArmModel, solver: InverseKinematics) -> None:
        self._arm = arm
        self._solver = solver
        self._middle = (arm.lower + arm.upper) / 2.0

    def follow(self, start: Array, goal: pin.SE3, checker: Checker) -> Line | str:
        """Follows the line from where the tip is at ``start`` to ``goal``.

        Args:
            start: Joint angles [rad].
            goal: Pose of the tip at the end, in the robot's base frame.
            checker: Checks for collisions on the way.

        Returns:
            The line, or why it is not possible.
        """
        origin = self._arm.tip_pose(start)
        length = float(np.linalg.norm(goal.translation - origin.translation))
        postures = [start]
        for share in _shares(origin, goal, length):
            posture = self._next(postures[-1], _between(origin, goal, share), checker)
            if isinstance(posture, str):
                return f"{posture}, {1000 * share * length:.0f} mm after its start"
            postures.append(posture)
        return Line(np.array(postures), length)

    def _next(self, previous: Array, target: pin.SE3, checker: Checker) -> Array | str:
        posture = self._solver.solve(
            target.homogeneous, previous, towards=self._middle, strength=_CENTRING, iterations=_ITERATIONS
        )
        if posture is None:
            return "the arm cannot follow it (a joint limit or the end of its reach)"
        if np.abs(posture - previous).max() > _LARGEST_JUMP:
            return "the arm would have to flip over"
        contact = checker.contact(posture)
        return str(contact) if contact else posture


def _shares(origin: pin.SE3, goal: pin.SE3, length: float) -> Array:
    angle = float(np.linalg.norm(pin.log3(origin.rotation.T @ goal.rotation)))
    steps = max(1, math.ceil(length / _STEP), math.ceil(angle / _TURN_STEP))
    return np.linspace(0.0, 1.0, steps + 1)[1:]


def _between(origin: pin.SE3, goal: pin.SE3, share: float) -> pin.SE3:
    rotation = origin.rotation @ pin.exp3(share * pin.log3(origin.rotation.T @ goal.rotation))
    return pin.SE3(rotation, (1.0 - share) * origin.translation + share * goal.translation)
