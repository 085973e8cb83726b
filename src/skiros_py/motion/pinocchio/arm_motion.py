"""Plans whole arm motions: of all routes and arm postures the feasible one with the least joint movement."""

from __future__ import annotations

from itertools import product

import numpy as np
import shapely

from skiros_py.devices.arm import ArmSpec
from skiros_py.errors import UnknownName
from skiros_py.geometry import Array
from skiros_py.motion.pinocchio.arm_model import ArmModel, arm_model
from skiros_py.motion.pinocchio.collision import CollisionScene, self_collision_pairs
from skiros_py.motion.pinocchio.free_moves import FreeMoves, KeptPaths
from skiros_py.motion.pinocchio.lines import Lines
from skiros_py.motion.pinocchio.route_search import RouteSearch
from skiros_py.motion.timing import JointLimits, time_path
from skiros_py.ports.adapters import InstalledPorts, Ports
from skiros_py.ports.cell import RobotSpec
from skiros_py.ports.kinematics import InverseKinematics
from skiros_py.ports.motion import Held, MotionPlan, MotionRequest, NoMotion, SamplingPlanner, Trajectory

_THICK = 0.12
"""How far links, hand and camera stick out around the joints and the tip [m]."""
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
    around = (points[:, None, :2] + _RIM).reshape(-1, 2)
    corners = shapely.get_coordinates(shapely.MultiPoint(around).convex_hull)[:-1]
    return tuple((float(x), float(y)) for x, y in corners)


def _points(arm: ArmModel, posture: Array, body: Array) -> Array:
    """Returns the joints, the tip and the corners of what it holds [m]."""
    tip = arm.tip_pose(posture)
    return np.vstack([arm.joint_places(posture), body @ tip.rotation.T + tip.translation])


_TIP_SPEED = 0.65
"""Greatest speed of the tip [m/s]; a slower arm hits more softly, but nothing stops it at a contact yet."""
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

    def plan(self, request: MotionRequest) -> MotionPlan | NoMotion:
        """Plans one request.

        Raises:
            UnknownName: The robot has no such arm.
        """
        if request.device not in self._arms:
            raise UnknownName("arm", request.device, self._arms)
        arm = self._arms[request.device]
        start = np.array(request.start)
        if beyond := arm.beyond_limits(start, _START_SLACK):
            return NoMotion.because("limits", f"the arm starts with {beyond}")
        name = request.device
        solver, pairs, planner = self._solvers[name], self._self_pairs[name], self._planners[name]
        scene = CollisionScene(
            arm, pairs, request.base, request.obstacles, request.held, request.gap, request.constraints
        )
        lines = Lines(arm, solver)
        moves = FreeMoves(arm, scene, lines, planner, self._kept[name], request.seed, reflexes=self._reflexes)
        search = RouteSearch(arm, solver, scene, request.base, request.seed, lines, moves)
        found = search.find(np.clip(start, arm.lower, arm.upper), request.routes)
        if found is None:
            return NoMotion(search.reason(request.routes), refusals=search.refusals)
        acceleration = arm.acceleration if request.held is None else np.minimum(arm.acceleration, _LOADED)
        limits = JointLimits(arm.velocity, acceleration).scaled(request.speed)
        legs = tuple(
            _joined([time_path(piece, limits, _rates(arm, piece, leg.rate)) for piece in leg.pieces])
            for leg in found.legs
        )
        postures = np.vstack([start, *(leg.positions for leg in legs)])
        covers, ends = (covered(arm, some, request.held) for some in (postures, postures[-1:]))
        planners = tuple(leg.planner for leg in found.legs)
        return MotionPlan(found.route, legs, covers, ends, planners, search.refusals)


def _rates(arm: ArmModel, path: Array, most: float) -> Array:
    """Returns the greatest rates of the path parameter along a path, so that the tip is nowhere too fast [1/s]."""
    places = np.array([arm.tip_pose(posture).translation for posture in path])
    ways = np.linalg.norm(np.gradient(places, 1.0 / (len(path) - 1), axis=0), axis=1)
    return np.asarray(np.minimum(most, _TIP_SPEED / np.maximum(ways, 1e-9)))


def _joined(pieces: list[Trajectory]) -> Trajectory:
    """Joins trajectories that end and begin at rest in the same posture."""
    positions = [pieces[0].positions, *(piece.positions[1:] for piece in pieces[1:])]
    velocities = [pieces[0].velocities, *(piece.velocities[1:] for piece in pieces[1:])]
    return Trajectory(np.vstack(positions), np.vstack(velocities))
