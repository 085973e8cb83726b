"""Plans whole arm motions: of all routes and arm postures the feasible one with the least joint movement."""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import numpy as np
import shapely

from skiros_py.devices.arm import ArmSpec
from skiros_py.errors import UnknownName
from skiros_py.geometry import Array, Primitive, Solid
from skiros_py.motion.pinocchio.arm_model import ArmModel, arm_model
from skiros_py.motion.pinocchio.collision import SEEN, Checker, CollisionScene, self_collision_pairs
from skiros_py.motion.pinocchio.free_moves import FreeMoves, KeptPaths
from skiros_py.motion.pinocchio.lines import Lines
from skiros_py.motion.pinocchio.reaching import reached_from
from skiros_py.motion.pinocchio.route_search import Chain, Postures, RouteSearch
from skiros_py.motion.timing import JointLimits, time_path
from skiros_py.motion.voxels import VoxelMap, things
from skiros_py.ports.adapters import InstalledPorts, Ports
from skiros_py.ports.cell import RobotSpec
from skiros_py.ports.kinematics import InverseKinematics
from skiros_py.ports.motion import (
    DepthView,
    Held,
    LineMove,
    MotionCheck,
    MotionPlan,
    MotionRequest,
    NoMotion,
    Obstacle,
    Reached,
    ReachRequest,
    Refusal,
    SamplingPlanner,
    Trajectory,
)
from skiros_py.ports.paths import hull

_THICK = 0.12
"""How far links, hand and camera stick out around the joints and the tip [m]."""
_CHECKED = 5
"""Every so many samples of a motion that is under way are checked; between two, nothing moves by more than 2 cm."""
_STEP = 10
"""Every so many samples of a trajectory are looked at; between two, nothing moves by more than 0.1 m."""

_TURNS = np.linspace(0.0, 2.0 * np.pi, 8, endpoint=False)
_RIM = _THICK / np.cos(np.pi / 8.0) * np.column_stack([np.cos(_TURNS), np.sin(_TURNS)])
"""Corners of an octagon around a circle."""

Corners = tuple[tuple[float, float], ...]


def covered(arm: ArmModel, postures: Array, held: Held | None) -> Corners:
    """Returns the corners of a convex outline, in the frame of the base [m], above which the arm is all the time.

    Args:
        arm: The arm.
        postures: Joint angles in close succession [rad], shape (samples, joints).
        held: What it holds, which sticks out further.
    """
    body = np.zeros((1, 3))  # the tip, and the corners of the box around what it holds, in the frame of the tip
    if held is not None:
        corners = np.array(list(product(*np.transpose(held.solid.bounds()))))
        body = np.vstack([body, held.pose.apply(corners)])
    points = np.vstack([_points(arm, posture, body) for posture in (*postures[::_STEP], postures[-1])])
    outer = shapely.get_coordinates(hull(points[:, :2]))
    corners = shapely.get_coordinates(hull((outer[:, None] + _RIM).reshape(-1, 2)))[:-1]
    return tuple((float(x), float(y)) for x, y in corners)


def _points(arm: ArmModel, posture: Array, body: Array) -> Array:
    """Returns the joints, the tip and the corners of what it holds [m]."""
    tip = arm.tip_pose(posture)
    return np.vstack([arm.joint_places(posture), body @ tip.rotation.T + tip.translation])


_TIP_SPEED = 0.65
"""Greatest speed of the tip [m/s]."""
_NEAR_SPEED = 0.25
"""The same near to things, and where it comes near to them at last: what is met there is hit softly [m/s]."""
_NEAR = 0.05
"""How near that is [m]."""
_COMING = 0.2
"""Length of the last stretch before a line at whose end something is taken or put down [m]."""
_CAREFUL = 0.5
"""Share of the speed at which it moves where it may hit something, since it keeps away by less than the error."""
_LOADED = 7.5
"""Greatest joint acceleration with a load, whose inertia would be felt as a contact [rad/s²]."""
_START_SLACK = 0.05  # [rad] a sensed start may lie this far outside the limits


class ArmMotion:
    """Motion planning of the arms of one robot.

    Args:
        spec: The robot.
        ports: Inverse kinematics and sampling planners; by default those that are installed.
        reflexes: False to search for each free motion at once, for comparisons.
    """

    def __init__(self, spec: RobotSpec, ports: Ports | None = None, *, reflexes: bool = True) -> None:
        self._arms = {arm.id: arm_model(spec, arm) for arm in spec.of(ArmSpec)}
        ports = ports or InstalledPorts((spec,))
        self._solvers = {name: ports.port(InverseKinematics, name) for name in self._arms}
        self._planners = {name: ports.port(SamplingPlanner, name) for name in self._arms}
        self._kept = {name: KeptPaths() for name in self._arms}
        self._reflexes = reflexes
        self._self_pairs = {name: self_collision_pairs(arm) for name, arm in self._arms.items()}
        self._map = VoxelMap()

    def see(self, view: DepthView) -> tuple[Obstacle, ...]:
        """Takes in a picture; returns blocks around all that motions keep away from because it was seen, up to now."""
        self._map.see(view)
        return tuple(Obstacle(SEEN, solid, pose) for pose, solid in things(self._map.occupied))

    def blocked(self, check: MotionCheck) -> NoMotion | None:
        """Returns what that was seen is in the way of a motion; None for nothing.

        Raises:
            UnknownName: The robot has no such arm.
        """
        arm, start = self._arm(check.device), check.positions[0]
        voxels = replace(self._map.occupied, only_middles=True)  # as it may have been planned
        scene = CollisionScene(arm, (), check.base, (), check.held, check.gap, voxels=voxels)
        checker = scene.checker(0.0, start=start)
        faults = (checker.fault(posture) for posture in (*check.positions[::_CHECKED], check.positions[-1]))
        fault = next((fault for fault in faults if fault is not None), None)
        return None if fault is None else NoMotion.because(fault.cause, fault.reason)

    def reach(self, request: ReachRequest) -> tuple[Reached, ...]:
        """Returns what is reached from each base that was looked at.

        Raises:
            UnknownName: The robot has no such arm.
        """
        arm, found = self._arm(request.device), list[Reached]()
        solver, pairs = self._solvers[request.device], self._self_pairs[request.device]
        left = request.enough
        for base in request.bases:
            scene = CollisionScene(arm, pairs, base, request.obstacles, request.held, request.gap)
            found.append(reached_from(arm, solver, scene, base, request))
            left -= None not in found[-1]
            if left <= 0:
                break
        return tuple(found)

    def _arm(self, name: str) -> ArmModel:
        if name not in self._arms:
            raise UnknownName("arm", name, self._arms)
        return self._arms[name]

    def plan(self, request: MotionRequest) -> MotionPlan | NoMotion:
        """Plans one request.

        Raises:
            UnknownName: The robot has no such arm.
        """
        arm = self._arm(request.device)
        start = np.array(request.start)
        if beyond := arm.beyond_limits(start, _START_SLACK):
            return NoMotion.because("limits", f"the arm starts with {beyond}")
        name = request.device
        solver, pairs, planner = self._solvers[name], self._self_pairs[name], self._planners[name]
        lines, refusals = Lines(arm, solver), tuple[Refusal, ...]()
        postures = Postures(arm, solver, request.base, request.seed)
        seen = self._map.occupied
        is_exact = not len(seen.centres) and not any(one.error for one in request.obstacles)
        for share in (1.0,) if is_exact else request.shares:
            around = [_grown(one, share * one.error) for one in request.obstacles]
            voxels = replace(seen, only_middles=share < 1.0)
            scene = CollisionScene(
                arm, pairs, request.base, around, request.held, request.gap, request.constraints, voxels
            )
            moves = FreeMoves(arm, scene, lines, planner, self._kept[name], request.seed, reflexes=self._reflexes)
            search = RouteSearch(arm, scene, postures, lines, moves)
            found = search.find(np.clip(start, arm.lower, arm.upper), request.routes)
            refusals += search.refusals
            if found is not None:
                return self._timed(
                    arm, scene, request, found, MotionPlan(found.route, (), refusals=refusals, share=share)
                )
            if all(one.cause in {"reach", "limits"} for one in search.refusals):
                break
        return NoMotion(search.reason(request.routes), refusals=refusals)

    @staticmethod
    def _timed(
        arm: ArmModel, scene: CollisionScene, request: MotionRequest, found: Chain, plan: MotionPlan
    ) -> MotionPlan:
        """Gives a plan its motions, the slower the nearer to things it may come."""
        acceleration = arm.acceleration if request.held is None else np.minimum(arm.acceleration, _LOADED)
        careful = 1.0 if plan.share >= 1.0 else _CAREFUL
        limits = JointLimits(arm.velocity, acceleration).scaled(request.speed * careful)
        near, route = scene.checker(_NEAR), request.routes[found.route]
        legs = []
        for number, leg in enumerate(found.legs):
            comes = any(isinstance(move, LineMove) for move in route[number + 1 : number + 2])
            end = arm.tip_pose(leg.goal).translation if comes and not isinstance(route[number], LineMove) else None
            rates = (_rates(arm, piece, leg.rate, near, end) * careful for piece in leg.pieces)
            legs.append(
                _joined([time_path(piece, limits, rate) for piece, rate in zip(leg.pieces, rates, strict=True)])
            )
        postures = np.vstack([np.array(request.start), *(leg.positions for leg in legs)])
        covers, ends = (covered(arm, some, request.held) for some in (postures, postures[-1:]))
        planners = tuple(leg.planner for leg in found.legs)
        return replace(plan, legs=tuple(legs), covers=covers, ends=ends, planners=planners)


def _grown(obstacle: Obstacle, by: float) -> Obstacle:
    """Returns an obstacle that is larger to all sides, but not higher where it stands upright [m]."""
    if by <= 0.0:
        return obstacle

    def larger(block: Primitive) -> Primitive:
        upright = abs((obstacle.pose @ block.pose).matrix()[2, 2]) > _UPRIGHT
        sides = (by, 2.0 * by) if block.kind == "cylinder" else (2.0 * by,) * 3
        more = (*sides[:-1], 0.0 if upright else sides[-1])
        return replace(block, size=tuple(length + extra for length, extra in zip(block.size, more, strict=True)))

    return replace(obstacle, solid=Solid(tuple(map(larger, obstacle.solid.primitives))))


_UPRIGHT = 0.999
"""Cosine of the angle up to which a block counts as upright."""


def _rates(arm: ArmModel, path: Array, most: float, near: Checker, end: Array | None) -> Array:
    """Returns the greatest rates of the path parameter along a path, so that nothing is too fast anywhere [1/s].

    Args:
        arm: The arm.
        path: The path, shape (n, joints).
        most: Greatest rate anywhere [1/s].
        near: Tells where nothing is near.
        end: Where the tip comes near to things at last; None where it does not [m].
    """
    places = np.array([_points(arm, posture, np.zeros((1, 3))) for posture in path])
    ways = np.linalg.norm(np.gradient(places, 1.0 / (len(path) - 1), axis=0), axis=2) + 1e-9
    slow = np.array([not near.clear(posture) for posture in path])
    if end is not None:
        slow |= np.linalg.norm(places[:, -1] - end, axis=1) < _COMING
    near_rate = np.where(slow, _NEAR_SPEED / ways.max(axis=1), np.inf)
    return np.asarray(np.minimum(np.minimum(most, near_rate), _TIP_SPEED / ways[:, -1]))


def _joined(pieces: list[Trajectory]) -> Trajectory:
    """Joins trajectories that end and begin at rest in the same posture."""
    positions = [pieces[0].positions, *(piece.positions[1:] for piece in pieces[1:])]
    velocities = [pieces[0].velocities, *(piece.velocities[1:] for piece in pieces[1:])]
    return Trajectory(np.vstack(positions), np.vstack(velocities))
