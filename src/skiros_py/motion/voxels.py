"""What cameras see and nothing that is known explains, as voxels in the map: a sparse grid with a counter in each.

A voxel that the points of a picture are in gains, and one that a picture sees through loses. Only occupied voxels are
kept: what is not among them is free or was never seen.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from skiros_py.geometry import Array, Pose, Primitive, Solid
from skiros_py.ports.motion import DepthView, Obstacle

SIZE = 0.02
"""Length of the sides of a voxel [m]."""
_FARTHEST = 1.2
"""Depth beyond which points are too coarse and noisy [m]."""
_LOWEST = 0.05
"""What is lower is the floor [m]."""
_EXPLAINED = 0.025
"""What is this near to something known belongs to it [m]: depth, calibration and joints are not exact."""
_ABOVE = 0.015
"""What is higher than this above it does not [m]: where something stands is uncertain, but not how high it is."""
_SHARE = 0.3
"""Share of the points on a whole side of a voxel that show that it is occupied ..."""
_FEWEST = 3
"""... and number of them in any case."""
_FEWEST_BESIDE = 2
"""Number of occupied voxels around one that is new: one that is alone is noise."""
_SEEN, _SEEN_THROUGH, _MOST = 1, 2, 4
"""What a picture adds to the counter of a voxel, or takes from it, and the greatest counter."""
_BEHIND = 0.02
"""A ray that ends so far behind a voxel has passed through it [m]."""
_FORGOTTEN = 300.0
"""Time after which a voxel that was not seen again is forgotten [s]."""
_KEPT = 2000
"""Greatest number of voxels; those are forgotten that were not seen for longest."""
_BELOW = 20
"""So many voxels below one that was seen count as occupied, too: a camera that looks down sees only what is on top."""
_TOGETHER = 5
"""Voxels that are less than this number of them apart along each axis belong to one thing, about."""
_OFFSET = 1 << 20
"""Added to the number of a voxel along each axis, so that it is positive."""

Keys = NDArray[np.int64]
Flags = NDArray[np.bool_]


@dataclass(frozen=True, slots=True, eq=False)
class Voxels:
    """Space in which something was seen that nothing known explains.

    Attributes:
        centres: The middles of cubes in the map [m], shape (n, 3).
        size: Length of their sides, which are parallel to the axes of the map [m].
        only_middles: True where cubes of half the size count, as what was seen fills each only in part.
    """

    centres: Array
    size: float = SIZE
    only_middles: bool = False


class VoxelMap:
    """The voxels that are occupied, from picture to picture."""

    def __init__(self) -> None:
        self._keys: Keys = np.empty(0, np.int64)
        self._counts: NDArray[np.int64] = np.empty(0, np.int64)
        self._times: Array = np.empty(0)

    @property
    def occupied(self) -> Voxels:
        """The voxels that are occupied now, with what is hidden below them."""
        centres = _centres(np.unique(self._keys[:, None] - np.arange(1 + _BELOW)))
        return Voxels(centres[centres[:, 2] > 0.0])

    def see(self, view: DepthView) -> None:
        """Takes in a picture."""
        gone = _seen_through(view, _centres(self._keys))
        self._counts[gone] -= _SEEN_THROUGH
        known = explained(_centres(self._keys), view.known)
        self._keep((self._counts > 0) & ~known & (self._times > view.time - _FORGOTTEN))
        self._add(self._new(view), view.time)

    def _new(self, view: DepthView) -> Keys:
        """Returns the voxels in which a picture shows something that nothing known explains."""
        points, depths = _points(view)
        high = points[:, 2] > _LOWEST
        keys, which, counts = np.unique(_keys(points[high]), return_inverse=True, return_counts=True)
        if not len(keys):
            return keys
        sums = [np.bincount(which, weights=column) for column in (*points[high].T, depths[high])]
        *middles, depth = (total / counts for total in sums)
        whole = (SIZE * view.intrinsics.fx / depth) ** 2
        many = counts >= np.maximum(_FEWEST, _SHARE * whole)
        keys, middles_of = keys[many], np.column_stack(middles)[many]
        keys = keys[~explained(middles_of, (*view.known, *view.moving))]
        together = np.union1d(keys, self._keys)
        beside = sum(np.isin(keys + step, together).astype(int) for step in _STEPS)
        return keys[beside >= _FEWEST_BESIDE]

    def _add(self, keys: Keys, time: float) -> None:
        old = np.isin(self._keys, keys)
        self._counts[old] = np.minimum(self._counts[old] + _SEEN, _MOST)
        self._times[old] = time
        new = np.setdiff1d(keys, self._keys)
        self._keys = np.concatenate([self._keys, new])
        self._counts = np.concatenate([self._counts, np.full(len(new), _SEEN)])
        self._times = np.concatenate([self._times, np.full(len(new), time)])
        if len(self._keys) > _KEPT:
            self._keep(np.argsort(-self._times, kind="stable")[:_KEPT])

    def _keep(self, which: Flags | Keys) -> None:
        self._keys, self._counts, self._times = self._keys[which], self._counts[which], self._times[which]


def _keys(points: Array) -> Keys:
    """Returns the numbers of the voxels that points are in."""
    cells = np.floor(points / SIZE).astype(np.int64) + _OFFSET
    return np.asarray((cells[:, 0] << 42) | (cells[:, 1] << 21) | cells[:, 2])


_STEPS = [(x << 42) + (y << 21) + z for x, y, z in itertools.product((-1, 0, 1), repeat=3) if (x, y, z) != (0, 0, 0)]
"""From a voxel to those around it."""


def _centres(keys: Keys) -> Array:
    mask = (1 << 21) - 1
    cells = np.column_stack([keys >> 42, (keys >> 21) & mask, keys & mask]) - _OFFSET
    return np.asarray((cells + 0.5) * SIZE)


def _points(view: DepthView) -> tuple[Array, Array]:
    """Returns what a picture shows, in the map, and its depths [m]."""
    k = view.intrinsics
    v, u = np.nonzero((view.depth > k.near) & (view.depth < min(k.far, _FARTHEST)))
    z = view.depth[v, u].astype(np.float64)
    return view.camera_pose.apply(np.column_stack([(u - k.cx) / k.fx * z, (v - k.cy) / k.fy * z, z])), z


def _seen_through(view: DepthView, centres: Array) -> Flags:
    """Returns through which voxels a picture sees: its rays at their middle and corners all end behind them."""
    k = view.intrinsics
    corners = np.array([(0.0, 0.0, 0.0), *itertools.product((-SIZE / 2.0, SIZE / 2.0), repeat=3)])
    points = view.camera_pose.inverse().apply((centres[:, None] + corners).reshape(-1, 3))
    z = np.maximum(points[:, 2], 1e-9)
    u, v = (np.rint(f * points[:, n] / z + c).astype(np.int64) for n, f, c in ((0, k.fx, k.cx), (1, k.fy, k.cy)))
    inside = (points[:, 2] > k.near) & (u >= 0) & (u < k.width) & (v >= 0) & (v < k.height)
    through = np.zeros(len(points), np.bool_)
    through[inside] = view.depth[v[inside], u[inside]] > z[inside] + _BEHIND
    return np.asarray(through.reshape(len(centres), len(corners)).all(axis=1))


def explained(points: Array, known: Iterable[Obstacle]) -> Flags:
    """Returns which points in the map are at something known, or as near to it as its place is uncertain."""
    found = np.zeros(len(points), np.bool_)
    for one in known:
        margin = _EXPLAINED + one.error
        left = np.flatnonzero(~found & _around(points, one, margin))
        for block in one.solid.primitives if len(left) else ():
            near = block.outside(one.pose.inverse().apply(points[left])) < margin
            found[left] |= near & (points[left, 2] < _top(one.pose @ block.pose, block) + _ABOVE)
    return found


def _around(points: Array, one: Obstacle, margin: float) -> Flags:
    """Returns which points are in the ball around a body, enlarged by a margin [m]."""
    low, high = one.solid.bounds()
    away = points - one.pose.apply((low + high) / 2.0)
    return np.asarray((away**2).sum(axis=1) < (float(np.linalg.norm(high - low)) / 2.0 + margin) ** 2)


def _top(pose: Pose, block: Primitive) -> float:
    """Returns the height of the highest point of a block at a pose in the map [m]."""
    x, y, z = pose.matrix()[2, :3].tolist()
    if block.kind == "box":
        length, width, height = block.size
        return float(pose.position[2] + (abs(x) * length + abs(y) * width + abs(z) * height) / 2.0)
    radius, height = block.size
    return float(pose.position[2] + math.hypot(x, y) * radius + abs(z) * height / 2.0)


def things(voxels: Voxels) -> Iterator[tuple[Pose, Solid]]:
    """Yields a block around each thing that voxels show: its pose in the map, and its shape."""
    cells = np.floor(voxels.centres / (_TOGETHER * voxels.size)).astype(int)
    left = {cell: voxels.centres[(cells == cell).all(axis=1)] for cell in map(tuple, np.unique(cells, axis=0).tolist())}
    while left:
        waiting, points = [next(iter(left))], list[Array]()
        while waiting:
            cell = waiting.pop()
            if cell in left:
                points.append(left.pop(cell))
                waiting += [tuple(np.add(cell, step).tolist()) for step in itertools.product((-1, 0, 1), repeat=3)]
        low, high = (edge(np.concatenate(points), axis=0) for edge in (np.min, np.max))
        x, y, _ = ((low + high) / 2.0).tolist()
        yield Pose((x, y, float(low[2]) - voxels.size / 2.0)), Solid.box(*(high - low + voxels.size).tolist())


def boxes(voxels: Voxels) -> Solid:
    """Returns voxels as a solid of few boxes in the map, for what knows no voxels."""
    cells = sorted(map(tuple, np.floor(voxels.centres / voxels.size).astype(int).tolist()))
    runs: list[Run] = [(cell, (1, 1, 1)) for cell in cells]
    for axis in (2, 1, 0):
        runs = _joined(runs, axis)
    found = []
    for low, size in runs:
        middle = [voxels.size * (first + count / 2.0) for first, count in zip(low, size, strict=True)]
        x, y, z = middle
        found.append(Primitive("box", tuple(voxels.size * count for count in size), Pose((x, y, z))))
    return Solid(tuple(found))


Run = tuple[tuple[int, ...], tuple[int, ...]]
"""The first voxel of a block, and how many it has along each axis."""


def _joined(runs: Sequence[Run], axis: int) -> list[Run]:
    """Returns blocks, those joined that are alike and follow each other along an axis."""
    others = [other for other in range(3) if other != axis]

    def alike(run: Run) -> tuple[int, ...]:
        low, size = run
        return (*(size[other] for other in others), *(low[other] for other in others))

    found: list[Run] = []
    for run in sorted(runs, key=lambda run: (alike(run), run[0][axis])):
        low, size = found[-1] if found else run
        if found and alike(found[-1]) == alike(run) and low[axis] + size[axis] == run[0][axis]:
            found[-1] = low, tuple(n + run[1][axis] if at == axis else n for at, n in enumerate(size))
        else:
            found.append(run)
    return found
