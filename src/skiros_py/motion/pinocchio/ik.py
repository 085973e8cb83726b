"""Inverse kinematics by damped least squares, inside the joint limits."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from skiros_py.geometry import Array
from skiros_py.motion.pinocchio.arm_model import ArmModel
from skiros_py.ports.kinematics import InverseKinematics

_ITERATIONS = 40
_POSITION_TOLERANCE = 1e-6  # [m] the last step converges quadratically, so being exact costs one more iteration
_ANGLE_TOLERANCE = 1e-5  # [rad]
_CLAMPED_JOINTS = 3  # joints at their limit for which the others may compensate in one step
_SETTLING = 15  # iterations that move a solution towards the reference
_DISTINCT = 0.3  # [rad] two solutions closer than this in every joint are one
_STRENGTH = 0.2  # share of the difference made up by each
_LARGEST_STEP = 0.6  # [rad] per iteration


class IkSolver:
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
            if not pulled and _small(error):
                return q
            drift = strength * (towards - q) if towards is not None and pulled else nowhere
            q = self._step(q, jacobian, error, drift)
        return None

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


def solutions(
    solver: InverseKinematics,
    target: Array,
    reference: Array,
    limits: tuple[Array, Array],
    rng: np.random.Generator,
    *,
    count: int = 6,
    restarts: int = 50,
) -> list[Array]:
    """Returns distinct solutions, the one nearest to a reference first.

    Each is also moved, elbow by elbow, as near to the reference as its pose allows; both are returned.

    Args:
        solver: What finds one.
        target: Pose of the tip in the robot's base frame, shape (4, 4).
        reference: Joint angles from where the arm comes [rad]; also the first seed.
        limits: Lowest and highest joint angles [rad].
        rng: Source of the other seeds.
        count: Stop after as many solutions.
        restarts: Bound of the effort: number of seeds.
    """
    found: list[Array] = []
    for attempt in range(restarts):
        raw = solver.solve(target, reference if attempt == 0 else rng.uniform(*limits))
        if raw is None:
            continue
        for q in (solver.solve(target, raw, towards=reference, pulls=_SETTLING), raw):
            if q is not None and all(np.abs(q - other).max() > _DISTINCT for other in found):
                found.append(q)
        if len(found) >= count:
            break
    return sorted(found, key=lambda q: float(np.linalg.norm(q - reference)))


def _small(error: Array) -> bool:
    linear, angular = error[:3], error[3:]
    return bool(linear @ linear < _POSITION_TOLERANCE**2 and angular @ angular < _ANGLE_TOLERANCE**2)
