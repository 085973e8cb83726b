"""Ports to motion libraries: arm motion planning, base path planning."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from skiros_py.geometry import Array, Pose, Solid
from skiros_py.ports.paths import Layer, Path
from skiros_py.ports.values import Pending


@dataclass(frozen=True, slots=True)
class Obstacle:
    """Something not to touch: a solid at a pose in the map."""

    id: str
    solid: Solid
    pose: Pose


@dataclass(frozen=True, slots=True)
class Held:
    """What the gripper holds: a solid at a pose in the arm's tip frame; it moves with the arm."""

    solid: Solid
    pose: Pose


@dataclass(frozen=True, slots=True)
class JointMove:
    """Move freely to joint angles [rad]."""

    positions: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class PoseMove:
    """Move freely until the arm's tip is at a pose in the map."""

    pose: Pose


@dataclass(frozen=True, slots=True)
class LineMove:
    """Move the tip on a straight line, turning evenly, to a pose in the map.

    Attributes:
        pose: Where the tip ends.
        speed: Greatest tip speed [m/s].
        touching: Ids of obstacles that this move may come close to or touch (the part to grasp, its support).
    """

    pose: Pose
    speed: float = 0.25
    touching: frozenset[str] = frozenset()


Move = JointMove | PoseMove | LineMove
Route = tuple[Move, ...]


@dataclass(frozen=True, slots=True)
class MotionRequest:
    """What the arm shall do next, all of it checked before anything moves.

    Attributes:
        device: Id of the arm that shall move.
        start: Joint angles now [rad].
        base: Pose of the robot's base in the map, as localised.
        routes: Alternative routes (two grasp directions, ...); of the feasible ones the one with the least joint motion
            is taken. All moves of a route are planned, one after the other.
        obstacles: Bodies in the map that the arm, the gripper and what it holds must not touch.
        held: What the gripper holds, or None.
        gap: Gap between the fingers while moving [m].
        speed: Share of the joint speed limits to use, 0 to 1.
        seed: Seed of every random choice of the planner.
    """

    device: str
    start: tuple[float, ...]
    base: Pose
    routes: tuple[Route, ...]
    obstacles: tuple[Obstacle, ...] = ()
    held: Held | None = None
    gap: float = 0.08
    speed: float = 1.0
    seed: int = 0


@dataclass(frozen=True, slots=True, eq=False)
class Trajectory:
    """Joint set-points, one per control period, from rest to rest.

    Attributes:
        positions: [rad], shape (samples, joints); the first row is the start.
        velocities: [rad/s], same shape.
    """

    positions: Array
    velocities: Array


@dataclass(frozen=True, slots=True)
class MotionPlan:
    """A feasible route.

    Attributes:
        route: Index of the route taken.
        legs: One trajectory for each of its moves.
        covers: Corners of a convex outline in the frame of the base [m]: arm, gripper and what it holds stay above it.
        ends: The same for the posture at the end.
    """

    route: int
    legs: tuple[Trajectory, ...]
    covers: tuple[tuple[float, float], ...] = ()
    ends: tuple[tuple[float, float], ...] = ()


@dataclass(frozen=True, slots=True)
class NoMotion:
    """No feasible motion was found, or one was broken off.

    Attributes:
        reason: For a person ("pose 2 cannot be reached", ...).
        met: True when the robot has touched something that it did not expect.
    """

    reason: str
    met: bool = False


class ArmPlanner(Protocol):
    """Collision-free motions of arms."""

    def plan(self, request: MotionRequest) -> Pending[MotionPlan | NoMotion]:
        """Plans one request."""


@dataclass(frozen=True, slots=True)
class BasePathRequest:
    """Where the base shall drive.

    Attributes:
        start: Base pose now, in the map.
        goal: Base pose wanted; the last stretch to it is driven straight ahead.
        shape: What the robot covers while it drives: base, arms and load, each at its heights.
        obstacles: What stands on the floor.
        clearance: Distance kept from obstacles on the way [m] (less where it docks).
        device: Id of the base that shall drive, for displays; empty if unknown.
    """

    start: Pose
    goal: Pose
    shape: tuple[Layer, ...]
    obstacles: tuple[Obstacle, ...]
    clearance: float = 0.08
    device: str = ""


class BasePlanner(Protocol):
    """Paths of a base among obstacles; what a base can follow depends on its kind."""

    def plan(self, request: BasePathRequest) -> Pending[Path | NoMotion]:
        """Plans one path."""
