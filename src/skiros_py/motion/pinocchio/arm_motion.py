"""Plans whole arm motions: of all routes and arm postures the feasible one with the least joint motion."""

from __future__ import annotations

import numpy as np

from skiros_py.devices.arm import ArmSpec
from skiros_py.errors import UnknownName
from skiros_py.geometry import Array
from skiros_py.motion.pinocchio.arm_model import ArmModel, arm_model
from skiros_py.motion.pinocchio.collision import CollisionScene, self_collision_pairs
from skiros_py.motion.pinocchio.coverage import covered
from skiros_py.motion.pinocchio.route_search import Chain, FreeLeg, Refusal, RouteSearch
from skiros_py.motion.timing import JointLimits, time_path
from skiros_py.ports.adapters import InstalledPorts
from skiros_py.ports.cell import RobotSpec
from skiros_py.ports.kinematics import InverseKinematics
from skiros_py.ports.motion import MotionPlan, MotionRequest, NoMotion, Trajectory

_START_SLACK = 0.05  # [rad] a sensed start may lie this far outside the limits


class ArmMotion:
    """Motion planning of the arms of one robot.

    Args:
        spec: The robot.
    """

    def __init__(self, spec: RobotSpec) -> None:
        self._arms = {arm.id: arm_model(spec, arm) for arm in spec.of(ArmSpec)}
        ports = InstalledPorts((spec,))
        self._solvers = {name: ports.port(InverseKinematics, name) for name in self._arms}
        self._self_pairs = {name: self_collision_pairs(arm) for name, arm in self._arms.items()}

    def plan(self, request: MotionRequest) -> MotionPlan | NoMotion:
        """Plans one request.

        Raises:
            UnknownName: The robot has no such arm.
        """
        arm = self._arm(request.arm)
        start = np.array(request.start)
        if outside := _outside(arm, start):
            return NoMotion(outside)
        scene = CollisionScene(
            arm, self._self_pairs[request.arm], request.base, request.obstacles, request.held, request.gap
        )
        search = RouteSearch(arm, self._solvers[request.arm], scene, request.base, request.seed)
        found = search.find(np.clip(start, arm.lower, arm.upper), request.routes)
        if isinstance(found, Refusal):
            return NoMotion(found.text(len(request.routes)))
        limits = JointLimits(arm.velocity, arm.acceleration).scaled(request.speed)
        legs = _timed(found, limits)
        postures = np.vstack([start, *(leg.positions for leg in legs)])
        covers, ends = (covered(arm, some, request.held) for some in (postures, postures[-1:]))
        return MotionPlan(found.route, legs, covers, ends)

    def _arm(self, name: str) -> ArmModel:
        if name not in self._arms:
            raise UnknownName("arm", name, self._arms)
        return self._arms[name]


def _outside(arm: ArmModel, start: Array) -> str:
    beyond = np.maximum(arm.lower - start, start - arm.upper)
    worst = int(np.argmax(beyond))
    if beyond[worst] <= _START_SLACK:
        return ""
    return f"the arm starts with {arm.spec.joints[worst]} at {start[worst]:.3f} rad, outside its limits"


def _timed(chain: Chain, limits: JointLimits) -> tuple[Trajectory, ...]:
    legs = []
    for leg in chain.legs:
        if isinstance(leg, FreeLeg):
            legs.append(_joined([time_path(piece, limits) for piece in leg.pieces]))
        else:
            legs.append(time_path(leg.line.postures, limits, leg.speed / max(leg.line.length, 1e-9)))
    return tuple(legs)


def _joined(pieces: list[Trajectory]) -> Trajectory:
    """Joins trajectories that end and begin at rest in the same posture."""
    positions = [pieces[0].positions, *(piece.positions[1:] for piece in pieces[1:])]
    velocities = [pieces[0].velocities, *(piece.velocities[1:] for piece in pieces[1:])]
    return Trajectory(np.vstack(positions), np.vstack(velocities))
