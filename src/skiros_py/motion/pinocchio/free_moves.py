"""Free motions between two postures: straight in joint space if that is clear, else around things with RRT-Connect.

RRT-Connect is Kuffner and LaValle's (ICRA 2000); the result is shortened by random short cuts.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from skiros_py.geometry import Array
from skiros_py.motion.pinocchio.arm_model import ArmModel
from skiros_py.motion.pinocchio.collision import Checker

_FINE = 0.01  # [m] the arm moves at most about this far between two checked postures
_COARSE = 0.03  # [m] the same while searching; what is found is checked finely afterwards
_EXTEND = 0.35  # [rad] length of one branch
_SHORT_CUTS = 60
_LOCAL = 0.5  # share of samples drawn around the straight line
_SPREAD = 0.6  # [rad] standard deviation of those


class Effort:
    """How many postures may still be checked; planning is bounded by this and not by time, so that it is repeatable.

    Args:
        postures: The bound.
    """

    def __init__(self, postures: int) -> None:
        self._left = postures

    def spend(self) -> None:
        """Counts one posture."""
        self._left -= 1

    def spent(self) -> bool:
        """Returns True when planning must stop."""
        return self._left <= 0


class FreeMoves:
    """Plans free motions.

    Args:
        arm: The kinematic model.
        checker: Checks for collisions.
        rng: Source of the random choices.
        effort: Bound of planning around things.
    """

    def __init__(self, arm: ArmModel, checker: Checker, rng: np.random.Generator, effort: Effort) -> None:
        self._arm = arm
        self._effort = effort
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
        self._effort.spend()
        return self._checker.clear(posture)

    def _connect(self, start: Array, goal: Array) -> list[Array] | None:
        here, there = _Tree(start), _Tree(goal)
        while not self._effort.spent():
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
