"""Ports to motion libraries: arm motion planning, base path planning."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any, Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from skiros_py.geometry import Array, Pose, Solid
from skiros_py.ports.paths import Layer, Path
from skiros_py.ports.values import CameraIntrinsics, Pending


@dataclass(frozen=True, slots=True)
class Obstacle:
    """Something not to touch: a solid at a pose in the map.

    Attributes:
        id: Its id.
        solid: Its shape.
        pose: Where it is believed to be.
        error: How far beside that it may be for the robot, since neither knows exactly where it is [m]. Planners keep
            away by so much, and by less only where they find nothing else.
    """

    id: str
    solid: Solid
    pose: Pose
    error: float = 0.0


@dataclass(frozen=True, slots=True)
class Held:
    """What the gripper holds: a solid at a pose in the arm's tip frame; it moves with the arm."""

    solid: Solid
    pose: Pose


Vector = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class Cone:
    """A constraint on the whole way: an axis of the tip stays near a direction, as a full cup stays upright.

    Attributes:
        axis: Unit vector in the frame of the tip.
        direction: Unit vector in the map.
        angle: Greatest angle between the two [rad].
    """

    axis: Vector
    direction: Vector
    angle: float

    @classmethod
    def upright(cls, tip: Pose, angle: float) -> Cone:
        """Makes the constraint that what is held stays as upright as it is at a pose of the tip in the map.

        Args:
            tip: The pose.
            angle: How far it may tilt [rad].
        """
        x, y, z = tip.matrix()[2, :3].tolist()
        return cls((x, y, z), (0.0, 0.0, 1.0), angle)


@dataclass(frozen=True, slots=True)
class KeepOut:
    """A constraint on the whole way: a volume in the map that neither the arm nor what it holds enters."""

    id: str
    solid: Solid
    pose: Pose


Constraint = Cone | KeepOut


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


SHARES = (1.0, 0.5, 0.0)
"""Shares of the errors of obstacles that motions keep away by, the best first."""


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
        constraints: What holds on the whole way of every move.
        shares: Shares of the errors of obstacles to keep away by: each is tried where there is no motion with the ones
            before. The less it is, the slower is the motion.
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
    constraints: tuple[Constraint, ...] = ()
    shares: tuple[float, ...] = SHARES


Cause = Literal["collision", "constraint", "singularity", "limits", "reach", "not found"]


@dataclass(frozen=True, slots=True)
class Refusal:
    """Why one way of moving is not possible.

    Attributes:
        route: Number of the route, from 0.
        move: Number of the move in it, from 0.
        planner: What would have moved so: "joint interpolation", "straight line", the name of a sampling planner; empty
            where the end of the move is not possible in the first place.
        cause: What kind of reason it is.
        reason: The reason, for a person.
        touches: What would touch: each a link of the robot, and the obstacle.
    """

    route: int
    move: int
    planner: str
    cause: Cause
    reason: str
    touches: tuple[tuple[str, str], ...] = ()


def furthest(refusals: Iterable[Refusal]) -> Refusal | None:
    """Returns the first refusal of what came furthest, after reflexes a search; None if there is none."""
    return max(refusals, key=lambda one: (one.move, one.cause == "not found"), default=None)


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
        planners: What found each leg: "joint interpolation", "straight line", the name of a sampling planner.
        refusals: Why other ways of moving were not taken.
        share: Share of the errors of obstacles that it keeps away by: 1 where there is room.
    """

    route: int
    legs: tuple[Trajectory, ...]
    covers: tuple[tuple[float, float], ...] = ()
    ends: tuple[tuple[float, float], ...] = ()
    planners: tuple[str, ...] = ()
    refusals: tuple[Refusal, ...] = ()
    share: float = 1.0


@dataclass(frozen=True, slots=True)
class NoMotion:
    """No feasible motion was found, or one was broken off.

    Attributes:
        reason: For a person ("pose 2 cannot be reached", ...).
        met: True when the robot has touched something that it did not expect.
        refusals: Why each way of moving that was tried is not possible.
    """

    reason: str
    met: bool = False
    refusals: tuple[Refusal, ...] = ()

    @classmethod
    def because(cls, cause: Cause, reason: str) -> NoMotion:
        """Makes the answer that holds for every way of moving."""
        return cls(reason, refusals=(Refusal(0, 0, "", cause, reason),))

    @property
    def values(self) -> dict[str, Any]:
        """What kind of reason it is, as values of a failure: a :data:`Cause` or "contact"; empty if unknown.

        It is "reach" only if no way at all is within reach. "bodies" are the ids of what would be touched.
        """
        decisive = furthest(one for one in self.refusals if one.cause != "reach") or furthest(self.refusals)
        cause = "contact" if self.met else decisive.cause if decisive else ""
        bodies = sorted({body for _, body in decisive.touches}) if decisive and not self.met else []
        return ({"cause": cause} if cause else {}) | ({"bodies": bodies} if bodies else {})


class ArmPlanner(Protocol):
    """Collision-free motions of arms."""

    def plan(self, request: MotionRequest) -> Pending[MotionPlan | NoMotion]:
        """Plans one request."""


@dataclass(frozen=True, slots=True, eq=False)
class DepthView:
    """A picture of a depth camera, for what plans among the things that it shows.

    Attributes:
        device: Id of the arm for which it is.
        depth: Distance along the optical axis [m], shape (height, width); 0 where nothing was measured.
        intrinsics: The camera's model.
        camera_pose: Pose of the optical frame in the map.
        time: When it was taken [s].
        known: What is believed to stand around. What is near to it, or within its error, belongs to it.
        moving: The robots where they were then, and what they held: the same, but only for what this picture shows.
    """

    device: str
    depth: NDArray[np.float32]
    intrinsics: CameraIntrinsics
    camera_pose: Pose
    time: float
    known: tuple[Obstacle, ...]
    moving: tuple[Obstacle, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class MotionCheck:
    """The rest of a motion that is under way.

    Attributes:
        device: Id of the arm.
        base: Pose of the robot's base in the map.
        positions: Joint angles from now on [rad], shape (n, joints).
        held: What the gripper holds, or None.
        gap: Gap between the fingers [m].
    """

    device: str
    base: Pose
    positions: Array
    held: Held | None
    gap: float


class SceneMapper(Protocol):
    """Shows a planner of arms what cameras see, which it keeps the arms away from; calls count in their order."""

    def see(self, view: DepthView) -> Pending[tuple[Obstacle, ...]]:
        """Takes in a picture; answers with blocks around all that was seen, up to now, and is unknown."""

    def blocked(self, check: MotionCheck) -> Pending[NoMotion | None]:
        """Answers what that was seen is in the way of a motion; None for nothing."""


@dataclass(frozen=True, slots=True, eq=False)
class ReachRequest:
    """From which of several poses of its base an arm reaches what it is wanted to.

    Attributes:
        device: Id of the arm.
        bases: The poses of the base in the map, the preferred ones first.
        targets: What is to be reached: for each the alternatives, and for each of these the poses of the tip in the
            map that the arm has to reach one after the other.
        near: Joint angles that solutions are looked for around [rad].
        obstacles: Bodies in the map that the arm, the gripper and what it holds must not touch.
        held: What the gripper holds, or None.
        gap: Gap between the fingers [m].
        touching: Ids of obstacles that may be touched.
        enough: After so many bases from which every target is reached, no further one is looked at.
        seed: Seed of every random choice.
    """

    device: str
    bases: tuple[Pose, ...]
    targets: tuple[tuple[tuple[Pose, ...], ...], ...]
    near: tuple[float, ...]
    obstacles: tuple[Obstacle, ...] = ()
    held: Held | None = None
    gap: float = 0.08
    touching: frozenset[str] = frozenset()
    enough: int = 1
    seed: int = 0


Reached = tuple[float | None, ...]
"""For each target how far the joints stay from their limits, as a share of half their ranges; None if out of reach."""


class ReachChecker(Protocol):
    """Postures of arms without the motions to them: much cheaper than a plan."""

    def reach(self, request: ReachRequest) -> Pending[tuple[Reached, ...]]:
        """Answers for each base that was looked at, in their order, what is reached from there."""


@dataclass(frozen=True, slots=True, eq=False)
class SearchTask:
    """A free motion of an arm that neither joint interpolation nor a straight line solves.

    Attributes:
        start, goal: Joint angles [rad].
        lower, upper: Joint limits [rad].
        clear: Tells whether joint angles are free of collisions and keep the constraints.
        straight: Tells the same of all postures between two.
        project: Moves joint angles to where the constraints hold; returns them as they are where they do already, and
            None where that is not possible.
        constrained: Whether there are constraints but keep-out volumes, which are among the obstacles.
        obstacles: What stands within reach, its poses in the frame of the robot's base.
        held: What the gripper holds, or None.
        gap: Gap between the fingers [m].
        margin: Distance to keep from everything [m].
        iterations: How many samples may be drawn; the search is bounded by this and not by time, to be repeatable.
        seed: Seed of every random choice.
    """

    start: Array
    goal: Array
    lower: Array
    upper: Array
    clear: Callable[[Array], bool]
    straight: Callable[[Array, Array], bool]
    project: Callable[[Array], Array | None]
    constrained: bool
    obstacles: tuple[Obstacle, ...]
    held: Held | None
    gap: float
    margin: float
    iterations: int
    seed: int


class SamplingPlanner(Protocol):
    """Searches paths of one arm in joint space by samples; an arm names the one it prefers by ``sk:adapter``."""

    @property
    def name(self) -> str:
        """Its name, for people ("prm")."""

    def search(self, task: SearchTask) -> Sequence[Array] | None:
        """Returns way points from start to goal, straight lines between them; None where it finds none.

        The path may be long and crooked: it is shortened, checked in small steps and rounded afterwards. Equal tasks
        have equal answers.
        """


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
        glides: Whether it is omnidirectional: it may drive in any direction from its heading, into its goal, too.
    """

    start: Pose
    goal: Pose
    shape: tuple[Layer, ...]
    obstacles: tuple[Obstacle, ...]
    clearance: float = 0.08
    device: str = ""
    glides: bool = False


class BasePlanner(Protocol):
    """Paths of a base among obstacles; what a base can follow depends on its kind."""

    def plan(self, request: BasePathRequest) -> Pending[Path | NoMotion]:
        """Plans one path."""
