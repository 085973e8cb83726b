"""Searches the postures with which a route of straight and free motions can be executed.

RRT-Connect is Kuffner and LaValle's (ICRA 2000); the result is shortened by random short cuts.

A free move to a pose leaves the choice of the posture, and the lines that follow it depend on that choice. So first
chains of postures are built for all routes, each line followed and checked, the free moves only guessed as straight;
then, from the shortest chain on, the free moves are planned.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
import pinocchio as pin

from skiros_py.geometry import Array, Pose
from skiros_py.motion.pinocchio.arm_model import ArmModel, se3
from skiros_py.motion.pinocchio.collision import Checker, CollisionScene
from skiros_py.motion.pinocchio.kinematics import solutions
from skiros_py.motion.timing import round_corners
from skiros_py.ports.kinematics import InverseKinematics
from skiros_py.ports.motion import JointMove, LineMove, Move, PoseMove, Route

_STEP = 0.005  # [m] between postures
_TURN_STEP = math.radians(2.0)  # [rad] between postures
_LARGEST_JUMP = 0.15  # [rad] of one joint between postures; more means the arm would have to flip
_CENTRING = 0.01  # share of the way to the middle of the joints' ranges made up with each step
_ITERATIONS = 12


def _shares(origin: pin.SE3, goal: pin.SE3, length: float) -> Array:
    angle = float(np.linalg.norm(pin.log3(origin.rotation.T @ goal.rotation)))
    steps = max(1, math.ceil(length / _STEP), math.ceil(angle / _TURN_STEP))
    return np.linspace(0.0, 1.0, steps + 1)[1:]


def _between(origin: pin.SE3, goal: pin.SE3, share: float) -> pin.SE3:
    rotation = origin.rotation @ pin.exp3(share * pin.log3(origin.rotation.T @ goal.rotation))
    return pin.SE3(rotation, (1.0 - share) * origin.translation + share * goal.translation)


_FINE = 0.01  # [m] the arm moves at most about this far between two checked postures
_COARSE = 0.03  # [m] the same while searching; what is found is checked finely afterwards
_EXTEND = 0.35  # [rad] length of one branch
_SHORT_CUTS = 60
_LOCAL = 0.5  # share of samples drawn around the straight line
_SPREAD = 0.6  # [rad] standard deviation of those


class FreeMoves:
    """Plans free motions.

    Args:
        arm: The kinematic model.
        checker: Checks for collisions.
        rng: Source of the random choices.
        effort: How many postures may be checked; planning is bounded by this and not by time, so that it is repeatable.

    Attributes:
        effort: How many may still be checked.
    """

    def __init__(self, arm: ArmModel, checker: Checker, rng: np.random.Generator, effort: int) -> None:
        self._arm = arm
        self.effort = effort
        self._checker = checker
        self._rng = rng
        # What a joint moves sweeps at most the rest of the arm: the nearer to the tip, the less.
        self._lever = arm.reach * np.linspace(1.0, 0.25, len(arm.lower))

    def straight(self, start: Array, goal: Array, step: float = _FINE) -> bool:
        """Returns True when the straight line in joint space is clear, its ends included, checked every step [m]."""
        way = float(np.abs(goal - start) @ self._lever)
        count = max(2, int(np.ceil(way / step)) + 1)
        return all(self._clear(start + share * (goal - start)) for share in _bisecting(count))

    def around(self, start: Array, goal: Array) -> list[Array] | None:
        """Returns way points from start to goal with clear straight lines in between, or None: not found."""
        path = self._connect(start, goal)
        path = self._shorten(path) if path else None
        return path if path and all(self.straight(a, b) for a, b in pairwise(path)) else None

    def _clear(self, posture: Array) -> bool:
        self.effort -= 1
        return self._checker.clear(posture)

    def _connect(self, start: Array, goal: Array) -> list[Array] | None:
        here, there = _Tree(start), _Tree(goal)
        while self.effort > 0:
            sample = self._sample(start, goal)
            leaf = self._extend(here, sample)
            if leaf is not None:
                other = self._reach(there, here.postures[leaf])
                if other is not None:
                    path = here.path(leaf)[::-1] + there.path(other)[1:]
                    return path if np.array_equal(path[0], start) else path[::-1]
            here, there = there, here
        return None

    def _sample(self, start: Array, goal: Array) -> Array:
        if self._rng.random() >= _LOCAL:
            return self._rng.uniform(self._arm.lower, self._arm.upper)
        middle = start + self._rng.random() * (goal - start)
        return np.clip(middle + self._rng.normal(0.0, _SPREAD, len(start)), self._arm.lower, self._arm.upper)

    def _extend(self, tree: _Tree, target: Array) -> int | None:
        nearest = tree.nearest(target)
        origin = tree.postures[nearest]
        way = float(np.linalg.norm(target - origin))
        if way < 1e-9:
            return nearest
        posture = target if way <= _EXTEND else origin + (_EXTEND / way) * (target - origin)
        return tree.add(posture, nearest) if self.straight(origin, posture, _COARSE) else None

    def _reach(self, tree: _Tree, target: Array) -> int | None:
        leaf = self._extend(tree, target)
        while leaf is not None and not np.array_equal(tree.postures[leaf], target):
            leaf = self._extend(tree, target)
        return leaf

    def _shorten(self, path: list[Array]) -> list[Array]:
        for _ in range(_SHORT_CUTS):
            if len(path) < 3:
                break
            first, last = sorted(self._rng.uniform(0.0, len(path) - 1.0, 2))
            path = self._cut(path, float(first), float(last))
        return path

    def _cut(self, path: list[Array], first: float, last: float) -> list[Array]:
        """Replaces the way between two places on the path (index + share) by the straight line if that is clear."""
        i, j = int(first), int(last)
        if i == j:
            return path
        start, goal = _at(path, first), _at(path, last)
        if not self.straight(start, goal):
            return path
        return [*path[: i + 1], start, goal, *path[j + 1 :]]


class _Tree:
    def __init__(self, root: Array) -> None:
        self.postures: list[Array] = [root]
        self._parents: list[int] = [-1]
        self._stack = np.empty((256, len(root)))
        self._stack[0] = root

    def add(self, posture: Array, parent: int) -> int:
        if len(self.postures) == len(self._stack):
            self._stack = np.vstack([self._stack, np.empty_like(self._stack)])
        self._stack[len(self.postures)] = posture
        self.postures.append(posture)
        self._parents.append(parent)
        return len(self.postures) - 1

    def nearest(self, target: Array) -> int:
        known = self._stack[: len(self.postures)]
        return int(np.argmin(((known - target) ** 2).sum(axis=1)))

    def path(self, leaf: int) -> list[Array]:
        """Returns the way from a leaf back to the root."""
        way = []
        while leaf >= 0:
            way.append(self.postures[leaf])
            leaf = self._parents[leaf]
        return way


def _at(path: Sequence[Array], place: float) -> Array:
    index = min(int(place), len(path) - 2)
    return path[index] + (place - index) * (path[index + 1] - path[index])


def _bisecting(count: int) -> Array:
    """Returns shares 0 to 1, ends first, then coarse to fine: a collision is met early."""
    shares = np.linspace(0.0, 1.0, count)
    order = sorted(range(count), key=lambda i: (-((i & -i) if 0 < i < count - 1 else count), i))
    return shares[order]


_FREE_MARGIN = 0.005  # [m] kept from everything on free moves
_LINE_MARGIN = 0.002  # [m] on lines, which go where it is narrow
_POSTURES = 6  # tried per pose
_SEEDS = 24  # for inverse kinematics per pose
_BEAM = 4  # chains of one route kept after each move
_STRAIGHT_TRIES = 8  # chains whose free moves are tried straight before any is planned around things
_AROUND_TRIES = 3  # chains whose free moves are planned around things
_EFFORT = 12000  # postures checked for each of them at most


@dataclass(frozen=True, slots=True, eq=False)
class Leg:
    """One move.

    Attributes:
        goal: Joint angles at its end [rad].
        pieces: Joint angles [rad] at even steps along the path, each of shape (n, joints), n >= 2; the arm rests
            between pieces. None for a free move that is not planned yet.
        rate: Greatest rate of the path parameter [1/s]: tip speed over tip way for a straight line.
    """

    goal: Array
    pieces: tuple[Array, ...] = ()
    rate: float = math.inf


@dataclass(frozen=True, slots=True, eq=False)
class Chain:
    """Legs for the first moves of a route and their joint motion [rad]."""

    route: int
    start: Array
    legs: tuple[Leg, ...] = ()
    cost: float = 0.0

    @property
    def end(self) -> Array:
        """Joint angles after the last leg [rad]."""
        return self.legs[-1].goal if self.legs else self.start

    def then(self, leg: Leg) -> Chain:
        """Returns the chain with one leg more."""
        return replace(self, legs=(*self.legs, leg), cost=self.cost + float(np.linalg.norm(leg.goal - self.end)))


@dataclass(frozen=True, slots=True)
class Refusal:
    """Why a route is not possible: at which of its moves (from 0), what kind of move that is, and the reason."""

    route: int
    move: int
    kind: str
    reason: str

    def text(self, routes: int) -> str:
        """Returns the reason for a person."""
        place = f"way {self.route + 1} of {routes}, " if routes > 1 else ""
        return f"{place}move {self.move + 1} ({self.kind}): {self.reason}"


_NOTHING = Refusal(0, 0, "none", "there is no move to make")
_NO_WAY = "no way around what stands there was found"


class RouteSearch:
    """Finds the best feasible route of one request.

    Args:
        arm: The kinematic model.
        solver: Inverse kinematics.
        scene: Robot and obstacles.
        base: Pose of the robot's base in the map.
        seed: Of all random choices.
    """

    def __init__(self, arm: ArmModel, solver: InverseKinematics, scene: CollisionScene, base: Pose, seed: int) -> None:
        self._arm = arm
        self._solver = solver
        self._scene = scene
        self._to_base = se3(base.inverse())
        self._rng = np.random.default_rng(seed)
        self._middle = (arm.lower + arm.upper) / 2.0
        self._free = scene.checker(_FREE_MARGIN)
        self._refusals: list[Refusal] = []
        self._known: dict[Pose, list[Array]] = {}

    def find(self, start: Array, routes: tuple[Route, ...]) -> Chain | Refusal:
        """Returns the feasible chain with the least joint motion of those tried, or why the best one failed.

        Args:
            start: Joint angles now [rad].
            routes: The alternatives.
        """
        chains = [chain for index, route in enumerate(routes) for chain in self._chains(index, start, route)]
        chains.sort(key=lambda chain: chain.cost)
        for chain in chains[:_STRAIGHT_TRIES]:
            if (planned := self._planned(chain, around=False)) is not None:
                return planned
        for chain in _spread(chains, _AROUND_TRIES):
            if (planned := self._planned(chain, around=True)) is not None:
                return planned
        return max(self._refusals, key=lambda refusal: refusal.move, default=_NOTHING)

    def _chains(self, index: int, start: Array, route: Route) -> list[Chain]:
        """Returns chains of postures for a whole route, lines checked, free moves only guessed."""
        chains = [Chain(index, start)]
        for number, move in enumerate(route):
            longer: list[Chain] = []
            for chain in chains:
                legs = self._legs(chain, move, first=number == 0)
                if isinstance(legs, str):
                    self._refusals.append(Refusal(index, number, _kind(move), legs))
                else:
                    longer.extend(chain.then(leg) for leg in legs)
            # Postures are cut only when a free move follows: which of them can do the lines is not known before.
            ends_segment = number + 1 == len(route) or not isinstance(route[number + 1], LineMove)
            longer.sort(key=lambda chain: chain.cost)
            chains = longer[:_BEAM] if ends_segment else longer
        return chains if route else []

    def _legs(self, chain: Chain, move: Move, *, first: bool) -> Iterable[Leg] | str:
        if isinstance(move, LineMove):
            checker = self._scene.checker(_LINE_MARGIN, move.touching, chain.end if first else None)
            return self._line(chain.end, self._in_base(move.pose), move.speed, checker)
        goals = self._goals(chain, move)
        return goals if isinstance(goals, str) else [Leg(goal) for goal in goals]

    def _line(self, start: Array, goal: pin.SE3, speed: float, checker: Checker) -> list[Leg] | str:
        """Follows the line from where the tip is at ``start``, each posture from the one before; or says why not."""
        origin = self._arm.tip_pose(start)
        length = float(np.linalg.norm(goal.translation - origin.translation))
        postures = [start]
        for share in _shares(origin, goal, length):
            posture = self._next(postures[-1], _between(origin, goal, share), checker)
            if isinstance(posture, str):
                return f"{posture}, {1000 * share * length:.0f} mm after its start"
            postures.append(posture)
        return [Leg(postures[-1], (np.array(postures),), speed / max(length, 1e-9))]

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

    def _goals(self, chain: Chain, move: JointMove | PoseMove) -> list[Array] | str:
        """Returns the postures that end a free move, the nearest first."""
        if isinstance(move, JointMove):
            postures = [np.array(move.positions)]
            if np.any(postures[0] < self._arm.lower) or np.any(postures[0] > self._arm.upper):
                return "the joint angles are outside the limits"
        else:
            target = self._in_base(move.pose)
            postures = self._postures(move.pose, target, chain.end)
            if not postures:
                return self._unreachable(target)
        clear = [posture for posture in postures if self._free.clear(posture)]
        return clear or str(self._free.contact(postures[0]))

    def _postures(self, pose: Pose, target: pin.SE3, end: Array) -> list[Array]:
        """Returns postures for a pose; those from random seeds are found once, whatever chain leads there."""
        if pose not in self._known:
            limits = self._arm.lower, self._arm.upper
            self._known[pose] = solutions(
                self._solver, target.homogeneous, end, limits, self._rng, count=_POSTURES, restarts=_SEEDS
            )
        near = self._solver.solve(target.homogeneous, end)
        found = self._known[pose] if near is None else [near, *self._known[pose]]
        return sorted(found, key=lambda posture: float(np.linalg.norm(posture - end)))[:_POSTURES]

    def _unreachable(self, target: pin.SE3) -> str:
        away = float(np.linalg.norm(target.translation - self._arm.shoulder))
        if away > self._arm.reach:
            return f"out of reach, {away:.2f} m from the shoulder of an arm that is {self._arm.reach:.2f} m long"
        return f"no joint angles within the limits reach it ({away:.2f} m from the shoulder, {_SEEDS} attempts)"

    def _in_base(self, pose: Pose) -> pin.SE3:
        return self._to_base * se3(pose)

    def _planned(self, chain: Chain, *, around: bool) -> Chain | None:
        """Returns the chain with its free moves planned, or None."""
        legs: list[Leg] = []
        here, effort = chain.start, _EFFORT
        for number, leg in enumerate(chain.legs):
            if not leg.pieces:
                checker = self._scene.checker(_FREE_MARGIN, start=here)
                moves = FreeMoves(self._arm, checker, self._rng, effort)
                pieces = _free_path(moves, checker, here, leg.goal, around=around)
                if not pieces:
                    self._refusals.append(Refusal(chain.route, number, "free move", _NO_WAY))
                    return None
                leg, effort = replace(leg, pieces=pieces), moves.effort
            legs.append(leg)
            here = leg.goal
        return replace(chain, legs=tuple(legs))


def _free_path(moves: FreeMoves, checker: Checker, start: Array, goal: Array, *, around: bool) -> tuple[Array, ...]:
    """Returns the pieces of a free path; none where it is not found."""
    if moves.straight(start, goal):
        return (np.linspace(start, goal, 5),)
    way_points = moves.around(start, goal) if around else None
    if not way_points:
        return ()
    rounded = round_corners(way_points, checker.clear)
    return (rounded,) if rounded is not None else tuple(np.linspace(a, b, 5) for a, b in pairwise(way_points))


def _spread(chains: list[Chain], count: int) -> list[Chain]:
    """Returns the best chain of each route before second ones: another route is the better second try."""
    seen: dict[int, int] = {}
    ranked = []
    for chain in chains:
        rank = seen.get(chain.route, 0)
        seen[chain.route] = rank + 1
        ranked.append((rank, chain.cost, chain))
    return [chain for _, _, chain in sorted(ranked, key=lambda entry: entry[:2])][:count]


def _kind(move: Move) -> str:
    return {JointMove: "to joint angles", PoseMove: "to a pose", LineMove: "straight line"}[type(move)]
