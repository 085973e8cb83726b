"""Searches the postures with which a route of straight and free motions can be executed.

A free move to a pose leaves the choice of the posture, and the lines that follow it depend on that choice. So chains of
postures are built for all routes, the shortest first, each line followed and checked, the free moves only guessed as
straight; the free moves of those that are whole are planned: by joint interpolation, by a straight line, by a search.
"""

from __future__ import annotations

import heapq
import math
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import count, islice

import numpy as np
import pinocchio as pin

from skiros_py.geometry import Array, Pose
from skiros_py.motion.pinocchio.arm_model import ArmModel, se3
from skiros_py.motion.pinocchio.collision import CollisionScene, Fault
from skiros_py.motion.pinocchio.free_moves import FREE_MARGIN, FreeMoves, Pieces
from skiros_py.motion.pinocchio.lines import Lines
from skiros_py.ports.kinematics import InverseKinematics
from skiros_py.ports.motion import JointMove, LineMove, Move, PoseMove, Refusal, Route, furthest

_LINE = "straight line"
_ROOMY = (
    0.02,
    0.05,
)  # [m] a posture that comes nearer than one of these is taken only if it saves as much motion as ...
_TIGHT = 0.5  # [rad] ... this
_LINE_MARGIN = 0.002  # [m] on lines, which go where it is narrow
_POSTURES = 6  # tried per pose; where none of them is clear, all that the seeds lead to
_SEEDS = 24  # for inverse kinematics per pose
_BEAM = 4  # chains of one route kept after each move
_STRAIGHT_TRIES = 8  # chains whose free moves are tried by joint interpolation before any is planned otherwise
_OTHER_TRIES = 3  # chains whose free moves are planned otherwise


@dataclass(frozen=True, slots=True, eq=False)
class Leg:
    """One move.

    Attributes:
        goal: Joint angles at its end [rad].
        pieces: Joint angles [rad] at even steps along the path, each of shape (n, joints), n >= 2; the arm rests
            between pieces. None for a free move that is not planned yet.
        rate: Greatest rate of the path parameter [1/s]: tip speed over tip way for a straight line.
        planner: What found it.
        tight: How many of the distances that make a posture a roomy one its end does not keep.
    """

    goal: Array
    pieces: Pieces = ()
    rate: float = math.inf
    planner: str = _LINE
    tight: int = 0


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
        cost = float(np.linalg.norm(leg.goal - self.end)) + _TIGHT * leg.tight
        return replace(self, legs=(*self.legs, leg), cost=self.cost + cost)


class Postures:
    """Finds the postures for poses, whatever stands around; those from random seeds once for each pose.

    Args:
        arm: The kinematic model.
        solver: Inverse kinematics.
        base: Pose of the robot's base in the map.
        seed: Of all random choices.
    """

    def __init__(self, arm: ArmModel, solver: InverseKinematics, base: Pose, seed: int) -> None:
        self._arm, self._solver, self._limits = arm, solver, (arm.lower, arm.upper)
        self._to_base = se3(base.inverse())
        self._rng = np.random.default_rng(seed)
        self._known: dict[tuple[Pose, int], list[Array]] = {}

    def in_base(self, pose: Pose) -> pin.SE3:
        """Returns a pose in the map in the frame of the base."""
        return self._to_base * se3(pose)

    def near(self, pose: Pose, here: Array, count: int = _POSTURES) -> list[Array]:
        """Returns postures for a pose in the map, those first that are nearest to joint angles [rad].

        Args:
            pose: Where the tip shall be, in the map.
            here: The joint angles.
            count: Return at most as many.
        """
        target = self.in_base(pose).homogeneous
        if self._arm.is_beyond_reach(target):
            return []
        key = pose, count
        if key not in self._known:
            self._known[key] = self._solver.branches(
                target, here, self._limits, self._rng, count=count, restarts=_SEEDS
            )
        nearest = self._solver.solve(target, here)
        found = self._known[key] if nearest is None else [nearest, *self._known[key]]
        return sorted(found, key=lambda posture: float(np.linalg.norm(posture - here)))[:count]


class RouteSearch:
    """Finds the best feasible route of one request.

    Args:
        arm: The kinematic model.
        scene: Robot and obstacles.
        postures: Finds postures for poses.
        lines: Follows lines of the tip.
        moves: Plans the free moves.
    """

    def __init__(
        self, arm: ArmModel, scene: CollisionScene, postures: Postures, lines: Lines, moves: FreeMoves
    ) -> None:
        self._arm, self._scene, self._postures, self._lines, self._moves = arm, scene, postures, lines, moves
        self._free = scene.checker(FREE_MARGIN)
        self._roomy = [scene.checker(margin) for margin in _ROOMY]
        self._refusals: dict[Refusal, None] = {}

    @property
    def refusals(self) -> tuple[Refusal, ...]:
        """Why what was tried is not possible, each reason once, in the order of routes and moves."""
        return tuple(sorted(self._refusals, key=lambda one: (one.route, one.move)))

    def find(self, start: Array, routes: tuple[Route, ...]) -> Chain | None:
        """Returns the feasible chain with the least joint motion of those tried; None where none is.

        Args:
            start: Joint angles now [rad].
            routes: The alternatives.
        """
        chains, tried = self._chains(start, routes), list[Chain]()
        first, *others = self._moves.ways
        for chain in islice(chains, _STRAIGHT_TRIES):
            if (planned := self._planned(chain, [first])) is not None:
                return planned
            tried.append(chain)
        some = _spread([*tried, *chains], _OTHER_TRIES)
        again = (self._planned(chain, ways) for ways in ([first, *others[:1]], [first, *others]) for chain in some)
        return next((chain for chain in again if chain is not None), None)

    def reason(self, routes: tuple[Route, ...]) -> str:
        """Returns why the route that came furthest is not possible, for a person."""
        order = furthest(self.refusals)
        if order is None:
            return "there is no move to make"
        move = routes[order.route][order.move]
        kind = "free move" if order.planner and not isinstance(move, LineMove) else _kind(move)
        place = f"way {order.route + 1} of {len(routes)}, " if len(routes) > 1 else ""
        return f"{place}move {order.move + 1} ({kind}): {order.reason}"

    def _refuse(self, route: int, move: int, planner: str, fault: Fault) -> None:
        self._refusals[Refusal(route, move, planner, fault.cause, fault.reason, fault.touches)] = None

    def _chains(self, start: Array, routes: tuple[Route, ...]) -> Iterator[Chain]:
        """Yields chains of postures for whole routes, the shortest first, lines checked, free moves only guessed.

        Only what is shorter than a whole chain is looked at before that is returned.
        """
        number, kept = count(), Counter[tuple[int, int]]()
        waiting = [(0.0, next(number), Chain(index, start)) for index, route in enumerate(routes) if route]
        while waiting:
            _, _, chain = heapq.heappop(waiting)
            route, done = routes[chain.route], len(chain.legs)
            # Postures are cut only when a free move follows: which of them can do the lines is not known before.
            if done == len(route) or not isinstance(route[done], LineMove):
                kept[chain.route, done] += 1
                if kept[chain.route, done] > _BEAM:
                    continue
            if done == len(route):
                yield chain
                continue
            legs = self._legs(chain, route[done], first=done == 0)
            if isinstance(legs, Fault):
                self._refuse(chain.route, done, _LINE if isinstance(route[done], LineMove) else "", legs)
                continue
            for longer in map(chain.then, legs):
                heapq.heappush(waiting, (longer.cost, next(number), longer))

    def _legs(self, chain: Chain, move: Move, *, first: bool) -> Iterable[Leg] | Fault:
        if isinstance(move, LineMove):
            goal = self._postures.in_base(move.pose)
            lowest = min(float(pose.translation[2]) for pose in (goal, self._arm.tip_pose(chain.end)))
            checker = self._scene.checker(_LINE_MARGIN, move.touching, chain.end if first else None, lowest)
            postures = self._lines.follow(chain.end, goal, checker)
            if isinstance(postures, Fault):
                return postures
            return [Leg(postures[-1], (postures,), move.speed / max(self._lines.length(chain.end, goal), 1e-9))]
        goals = self._goals(chain, move)
        if isinstance(goals, Fault):
            return goals
        return [Leg(goal, tight=sum(not roomy.clear(goal) for roomy in self._roomy)) for goal in goals]

    def _goals(self, chain: Chain, move: JointMove | PoseMove) -> list[Array] | Fault:
        """Returns the postures that end a free move, the nearest first."""
        if isinstance(move, JointMove):
            posture = np.array(move.positions)
            if beyond := self._arm.beyond_limits(posture, 0.0):
                return Fault("limits", f"it would end with {beyond}")
            return self._free.fault(posture) or [posture]
        postures = self._postures.near(move.pose, chain.end)
        if not postures:
            return self._unreachable(self._postures.in_base(move.pose))
        fault = self._free.fault(postures[0])
        clear = list(filter(self._free.clear, postures))
        if not clear:
            more = self._postures.near(move.pose, chain.end, _SEEDS)
            clear = list(filter(self._free.clear, more))[:_POSTURES]
        return clear or fault or []

    def _unreachable(self, target: pin.SE3) -> Fault:
        away = float(np.linalg.norm(target.translation - self._arm.shoulder))
        if away > self._arm.reach:
            far = f"out of reach, {away:.2f} m from the shoulder of an arm that is {self._arm.reach:.2f} m long"
            return Fault("reach", far)
        if self._arm.is_beyond_reach(target.homogeneous):
            return Fault("reach", f"out of reach with the tip turned like this, {away:.2f} m from the shoulder")
        tried = f"({away:.2f} m from the shoulder, {_SEEDS} attempts)"
        return Fault("reach", f"no joint angles within the limits reach it {tried}")

    def _planned(self, chain: Chain, ways: Sequence[str]) -> Chain | None:
        """Returns the chain with its free moves planned, each in the first of some ways that does it; or None."""
        legs: list[Leg] = []
        here = chain.start
        for number, leg in enumerate(chain.legs):
            planned = leg if leg.pieces else self._free_leg(chain.route, number, here, leg, ways)
            if planned is None:
                return None
            legs.append(planned)
            here = leg.goal
        return replace(chain, legs=tuple(legs))

    def _free_leg(self, route: int, move: int, here: Array, leg: Leg, ways: Sequence[str]) -> Leg | None:
        for way in ways:
            pieces = self._moves.plan(way, here, leg.goal)
            if not isinstance(pieces, Fault):
                return replace(leg, pieces=pieces, planner=way)
            self._refuse(route, move, way, pieces)
        return None


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
