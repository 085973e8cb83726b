"""Straight lines of the tip: followed posture by posture, and judged on the way."""

from __future__ import annotations

import math
from collections.abc import Hashable, Iterator
from dataclasses import dataclass, replace
from itertools import chain

import numpy as np
import pinocchio as pin

from skiros_py.geometry import Array
from skiros_py.motion.pinocchio.arm_model import ArmModel
from skiros_py.motion.pinocchio.collision import Checker, Fault
from skiros_py.ports.kinematics import InverseKinematics

_STEP = 0.005  # [m] between postures
_TURN_STEP = math.radians(2.0)  # [rad] between postures
_LARGEST_JUMP = 0.15  # [rad] of one joint between postures; more means the arm would have to flip
_SINGULAR = 0.01  # least singular value of the tip's Jacobian [m/rad]; below it, joints turn fast for a slow tip
_STRIDE = 4  # steps at a time in which a reflex is judged first: most that collide do so coarsely, too
_CENTRING = 0.01  # share of the way to the middle of the joints' ranges made up with each step
_APPROACH = 0.1  # the same for the posture in which a line has to end
_ARRIVAL = 60  # steps at most that the elbow takes at the end of a line to reach that posture
_ARRIVED = 0.01  # [rad]
_ITERATIONS = 12
_NEAR_LIMIT = 0.05  # [rad] a joint that is nearer to its limit is what ends a line


@dataclass(frozen=True, slots=True, eq=False)
class _Step:
    """The next posture on a line and what speaks against it, besides what stands around; after a way of the tip [m]."""

    posture: Array | None
    fault: Fault | None = None
    way: float = 0.0


class Lines:
    """Follows lines of the tip, turning evenly (slerp).

    The postures of a line do not depend on what stands around: they are found once, and checked each time.

    Args:
        arm: The kinematic model.
        solver: Inverse kinematics.
    """

    def __init__(self, arm: ArmModel, solver: InverseKinematics) -> None:
        self._arm = arm
        self._solver = solver
        self._middle = (arm.lower + arm.upper) / 2.0
        self._known: dict[Hashable, tuple[list[_Step], Iterator[_Step]]] = {}

    def length(self, start: Array, goal: pin.SE3) -> float:
        """Returns the way of the tip from joint angles [rad] to a pose in the frame of the base [m]."""
        return float(np.linalg.norm(goal.translation - self._arm.tip_pose(start).translation))

    def follow(self, start: Array, goal: pin.SE3, checker: Checker) -> Array | Fault:
        """Returns the postures of a line from joint angles [rad] to a pose, each found from the one before."""
        return self._followed(start, goal, checker)

    def between(self, start: Array, goal: Array, checker: Checker) -> Array | Fault:
        """Returns the postures of a line between joint angles [rad], which it begins and ends in."""
        end = self._arm.tip_pose(goal)
        coarse = self._followed(start, end, checker, goal, _STRIDE)
        postures = coarse if isinstance(coarse, Fault) else self._followed(start, end, checker, goal)
        if isinstance(postures, Fault):
            return postures
        if np.abs(postures[-1] - goal).max() > _ARRIVED:
            return Fault("reach", "the line ends in another posture of the arm")
        return np.vstack([postures[:-1], goal])

    def _followed(
        self, start: Array, goal: pin.SE3, checker: Checker, end: Array | None = None, stride: int = 1
    ) -> Array | Fault:
        key = start.tobytes(), goal.homogeneous.tobytes(), None if end is None else end.tobytes(), stride
        if key not in self._known:
            self._known[key] = [], self._steps(start, goal, end, stride)
        known, further = self._known[key]
        postures = [start]
        for step in chain(tuple(known), _kept(further, known)):
            posture, fault = step.posture, step.fault
            if posture is not None:
                fault = checker.fault(posture) or fault
                postures.append(posture)
            if fault is not None:
                return replace(fault, reason=f"{fault.reason}, {1000 * step.way:.0f} mm after its start")
        return np.array(postures)

    def _steps(self, start: Array, goal: pin.SE3, end: Array | None, stride: int) -> Iterator[_Step]:
        """Yields the steps of a line, whatever stands around; the last one may have a fault."""
        origin, length, posture = self._arm.tip_pose(start), self.length(start, goal), start
        for share in (*_shares(origin, goal, length, stride), *np.ones(0 if end is None else _ARRIVAL)):
            if share == 1.0 and end is not None and np.abs(posture - end).max() <= _ARRIVED:
                return
            near = self._middle if end is None else start + share * (end - start)
            strength = _CENTRING if end is None else _APPROACH
            step = self._next(posture, _between(origin, goal, share), near, strength, _LARGEST_JUMP * stride)
            yield replace(step, way=share * length)
            if step.posture is None or step.fault is not None:
                return
            posture = step.posture

    def _next(self, previous: Array, target: pin.SE3, near: Array, strength: float, jump: float) -> _Step:
        posture = self._solver.solve(
            target.homogeneous, previous, towards=near, strength=strength, iterations=_ITERATIONS
        )
        if posture is None:
            left = np.minimum(previous - self._arm.lower, self._arm.upper - previous)
            if left.min() < _NEAR_LIMIT:
                return _Step(None, Fault("limits", f"{self._arm.spec.joints[int(left.argmin())]} comes to its limit"))
            return _Step(None, Fault("reach", "the arm reaches no further"))
        if np.abs(posture - previous).max() > jump:
            return _Step(None, Fault("singularity", "the arm would have to flip over"))
        _, jacobian = self._arm.tip_jacobian(posture)
        if float(np.linalg.svd(jacobian, compute_uv=False)[-1]) < _SINGULAR:
            return _Step(posture, Fault("singularity", "the arm is nearly stretched or folded, where joints turn fast"))
        return _Step(posture)


def _kept(further: Iterator[_Step], known: list[_Step]) -> Iterator[_Step]:
    for step in further:
        known.append(step)
        yield step


def _shares(origin: pin.SE3, goal: pin.SE3, length: float, stride: int) -> Array:
    angle = float(np.linalg.norm(pin.log3(origin.rotation.T @ goal.rotation)))
    steps = max(1, math.ceil(length / _STEP / stride), math.ceil(angle / _TURN_STEP / stride))
    return np.linspace(0.0, 1.0, steps + 1)[1:]


def _between(origin: pin.SE3, goal: pin.SE3, share: float) -> pin.SE3:
    rotation = origin.rotation @ pin.exp3(share * pin.log3(origin.rotation.T @ goal.rotation))
    return pin.SE3(rotation, (1.0 - share) * origin.translation + share * goal.translation)
