"""Free motions between two postures: two reflexes first, then paths kept from before, then a search by samples.

Joint interpolation turns each joint as little as possible; it may pass a singular posture, where a line of the tip may
not, since it gives each joint its speed.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Sequence
from functools import cache
from itertools import pairwise

import numpy as np

from skiros_py.geometry import Array
from skiros_py.motion.pinocchio.arm_model import ArmModel
from skiros_py.motion.pinocchio.collision import Checker, CollisionScene, Fault
from skiros_py.motion.pinocchio.lines import Lines
from skiros_py.motion.timing import round_corners
from skiros_py.ports.motion import SamplingPlanner, SearchTask

FREE_MARGIN = 0.005
"""Distance kept from everything on free moves [m]."""
_FINE = 0.01  # [m] the arm moves at most about this far between two checked postures
_ROWS = 25  # postures that stand for a straight motion of the joints
_COARSE = 0.03  # [m] the same while searching; what is found is checked finely afterwards
_SHORT_CUTS = 60
_SAMPLES = 3000  # drawn by a search at most
_KEPT = 500  # places between which paths are kept
_ALTERNATIVES = 3  # paths kept between two places

Pieces = tuple[Array, ...]
"""Joint angles [rad] at even steps along a path, each of shape (n, joints); the arm rests between pieces."""


class KeptPaths:
    """Searched paths of one arm, by where they begin and end and what stands there; checked again before reuse.

    None is replaced by a later one, so that equal requests have equal answers.
    """

    def __init__(self) -> None:
        self._paths: dict[Hashable, list[list[Array]]] = {}

    def between(self, start: Array, goal: Array, things: Hashable) -> list[list[Array]]:
        """Returns the paths between two places, within 0.1 rad; new ones are put into this list."""
        key = tuple(np.round(start, 1).tolist()), tuple(np.round(goal, 1).tolist()), things
        if len(self._paths) >= _KEPT:
            return self._paths.get(key, [])
        return self._paths.setdefault(key, [])


class FreeMoves:
    """Plans free motions in one scene.

    Args:
        arm: The kinematic model.
        scene: Robot and obstacles.
        lines: Follows lines of the tip.
        planner: Searches where neither reflex does.
        kept: Paths found before.
        seed: Of all random choices.
        reflexes: False to search at once, for comparisons.

    Attributes:
        ways: The ways of moving by name, in the order in which they are tried.
    """

    def __init__(
        self,
        arm: ArmModel,
        scene: CollisionScene,
        lines: Lines,
        planner: SamplingPlanner,
        kept: KeptPaths,
        seed: int,
        *,
        reflexes: bool = True,
    ) -> None:
        self._arm, self._scene, self._lines, self._planner, self._kept = arm, scene, lines, planner, kept
        self._seed = seed
        self._things = (frozenset(one.id for one in scene.near), scene.held is None)
        # What a joint moves sweeps at most the rest of the arm: the nearer to the tip, the less.
        self._lever = arm.reach * np.linspace(1.0, 0.25, len(arm.lower))
        ways: dict[str, Callable[[Array, Array], Pieces | Fault]] = {
            "joint interpolation": self._interpolated,
            "straight line": self._lined,
            "kept path": self._reused,
            planner.name: self._searched,
        }
        self._ways = ways if reflexes else {planner.name: self._searched}
        self._known: dict[tuple[str, bytes, bytes], Pieces | Fault] = {}
        self._checkers: dict[bytes, Checker] = {}

    @property
    def ways(self) -> tuple[str, ...]:
        """The names of the ways of moving."""
        return tuple(self._ways)

    def plan(self, way: str, start: Array, goal: Array) -> Pieces | Fault:
        """Plans one motion in one way, once; returns why that is not possible.

        Args:
            way: Name of the way of moving.
            start: Where it begins [rad]; what is too near there only must not come nearer.
            goal: Where it ends [rad].
        """
        key = way, start.tobytes(), goal.tobytes()
        if key not in self._known:
            self._known[key] = self._ways[way](start, goal)
        return self._known[key]

    def _checker(self, start: Array) -> Checker:
        key = start.tobytes()
        if key not in self._checkers:
            self._checkers[key] = self._scene.checker(FREE_MARGIN, start=start)
        return self._checkers[key]

    def _interpolated(self, start: Array, goal: Array) -> Pieces | Fault:
        checker = self._checker(start)
        faults = (checker.fault(posture) for posture in self._postures(start, goal, _FINE))
        fault = next((fault for fault in faults if fault is not None), None)
        return fault or (np.linspace(start, goal, _ROWS),)

    def _lined(self, start: Array, goal: Array) -> Pieces | Fault:
        postures = self._lines.between(start, goal, self._checker(start))
        return postures if isinstance(postures, Fault) else (postures,)

    def _reused(self, start: Array, goal: Array) -> Pieces | Fault:
        checker = self._checker(start)
        for path in self._kept.between(start, goal, self._things):
            again = [start, *path[1:-1], goal]
            if self._clear(checker, again):
                return _pieces(again, checker)
        return Fault("not found", "no path that is kept leads there")

    def _searched(self, start: Array, goal: Array) -> Pieces | Fault:
        checker = self._checker(start)
        found = self._planner.search(
            SearchTask(
                start=start,
                goal=goal,
                lower=self._arm.lower,
                upper=self._arm.upper,
                clear=checker.clear,
                straight=lambda one, other: self._straight(checker, one, other, _COARSE),
                project=checker.project,
                constrained=bool(self._scene.cones),
                obstacles=(*self._scene.near, *self._scene.seen),
                held=self._scene.held,
                gap=self._scene.gap,
                margin=FREE_MARGIN,
                iterations=_SAMPLES,
                seed=self._seed,
            )
        )
        path = None if found is None else self._shortened([start, *list(found)[1:-1], goal], checker)
        if path is None:
            return Fault("not found", "no way around what stands there was found")
        kept = self._kept.between(start, goal, self._things)
        if len(kept) < _ALTERNATIVES:
            kept.append(path)
        return _pieces(path, checker)

    def _postures(self, start: Array, goal: Array, step: float) -> Array:
        """Returns postures between two, ends first, then coarse to fine, one every step of the arm's way [m]."""
        way = float(np.abs(goal - start) @ self._lever)
        shares = _bisecting(max(2, int(np.ceil(way / step)) + 1))
        return np.asarray(start + shares[:, None] * (goal - start))

    def _straight(self, checker: Checker, start: Array, goal: Array, step: float) -> bool:
        return all(map(checker.clear, self._postures(start, goal, step)))

    def _clear(self, checker: Checker, path: Sequence[Array]) -> bool:
        return all(self._straight(checker, a, b, _FINE) for a, b in pairwise(path))

    def _shortened(self, path: list[Array], checker: Checker) -> list[Array] | None:
        """Shortens a path by random short cuts; None where it is not clear in small steps."""
        for step in (_COARSE, _FINE):
            rng, short = np.random.default_rng(self._seed), path
            for _ in range(_SHORT_CUTS if len(path) > 2 else 0):
                first, last = sorted(rng.uniform(0.0, len(short) - 1.0, 2))
                i, j = int(first), int(last)
                start, goal = _at(short, first), _at(short, last)
                if i != j and self._straight(checker, start, goal, step):
                    short = [*short[: i + 1], start, goal, *short[j + 1 :]]
            if self._clear(checker, short):
                return short
        return None


def _pieces(path: Sequence[Array], checker: Checker) -> Pieces:
    rounded = round_corners(path, checker.clear)
    return (rounded,) if rounded is not None else tuple(np.linspace(a, b, _ROWS) for a, b in pairwise(path))


def _at(path: Sequence[Array], place: float) -> Array:
    index = min(int(place), len(path) - 2)
    return path[index] + (place - index) * (path[index + 1] - path[index])


@cache
def _bisecting(count: int) -> Array:
    """Returns shares 0 to 1, ends first, then coarse to fine: a collision is met early."""
    shares = np.linspace(0.0, 1.0, count)
    order = sorted(range(count), key=lambda i: (-((i & -i) if 0 < i < count - 1 else count), i))
    return shares[order]
