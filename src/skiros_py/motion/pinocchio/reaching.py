"""Which poses of its tip an arm reaches from where its base stands, by inverse kinematics and without motions."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from skiros_py.geometry import Array, Pose
from skiros_py.motion.pinocchio.arm_model import ArmModel
from skiros_py.motion.pinocchio.collision import Checker, CollisionScene
from skiros_py.ports.kinematics import InverseKinematics
from skiros_py.ports.motion import Reached, ReachRequest

_SEEDS = 5
"""For inverse kinematics per pose."""
_POSTURES = 3
"""Postures per pose that are looked at."""
_MARGIN = 0.002
"""Smallest distance from what must not be touched [m]."""


def reached_from(
    arm: ArmModel, solver: InverseKinematics, scene: CollisionScene, base: Pose, request: ReachRequest
) -> Reached:
    """Returns for each target how far the joints stay from their limits; None for one that is out of reach.

    Args:
        arm: The kinematic model.
        solver: Inverse kinematics.
        scene: Robot and obstacles, for this pose of the base.
        base: Where the base stands in the map.
        request: What is to be reached.
    """
    seen = _Reach(arm, solver, scene, base, request)
    return tuple(seen.best(alternatives) for alternatives in request.targets)


class _Reach:
    def __init__(
        self, arm: ArmModel, solver: InverseKinematics, scene: CollisionScene, base: Pose, request: ReachRequest
    ) -> None:
        self._arm, self._solver, self._scene, self._request = arm, solver, scene, request
        self._to_base, self._near = base.inverse(), np.array(request.near)
        self._rng = np.random.default_rng(request.seed)
        self._checkers: dict[float, Checker] = {}

    def best(self, alternatives: Sequence[Sequence[Pose]]) -> float | None:
        """Returns the comfort of the first alternative that can be reached."""
        found = (self._comfort([self._to_base @ pose for pose in poses]) for poses in alternatives)
        return next((comfort for comfort in found if comfort is not None), None)

    def _comfort(self, poses: Sequence[Pose]) -> float | None:
        """Returns how far the joints stay from their limits at poses in the frame of the base; None out of reach."""
        first, *others = (pose.matrix() for pose in poses)
        if any(map(self._arm.is_beyond_reach, (first, *others))):
            return None
        limits = self._arm.lower, self._arm.upper
        for start in self._solver.branches(first, self._near, limits, self._rng, count=_POSTURES, restarts=_SEEDS):
            chain = [start]
            for matrix in others:
                after = self._solver.solve(matrix, chain[-1])
                if after is None:
                    break
                chain.append(after)
            if len(chain) < len(poses):
                continue
            checker = self._checker(min(pose.position[2] for pose in poses))
            if all(checker.clear(posture) for posture in chain):
                return min(self._left(posture) for posture in chain)
        return None

    def _checker(self, lowest: float) -> Checker:
        """Returns what checks postures with the tip no lower than a height [m]; making one takes long."""
        if lowest not in self._checkers:
            self._checkers[lowest] = self._scene.checker(_MARGIN, self._request.touching, lowest=lowest)
        return self._checkers[lowest]

    def _left(self, posture: Array) -> float:
        """Returns how far a posture is from the nearest limit, as a share of half the range of that joint."""
        half = (self._arm.upper - self._arm.lower) / 2.0
        return float((np.minimum(posture - self._arm.lower, self._arm.upper - posture) / half).min())
