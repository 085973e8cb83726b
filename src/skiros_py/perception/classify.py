"""Finds the type and pose of a part that best explain a cluster of raised cells, to the last millimetre."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache, partial

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from skiros_py.geometry import Array
from skiros_py.perception.elevation import ElevationMap
from skiros_py.perception.heightmaps import Floats, HeightMap, height_map
from skiros_py.ports.perception import PartModel

_COMPASS = np.vstack([np.eye(3), -np.eye(3)]).astype(np.float32)


def compass_search(
    cost: Callable[[Floats], Floats], starts: Floats, *, step: tuple[float, float], halvings: int, rounds: int
) -> tuple[Floats, Floats]:
    """Walks every start downhill in x, y and yaw, halving its steps where no neighbour is better.

    Args:
        cost: Costs of poses (x, y, yaw) of shape (m, 3).
        starts: Poses (x, y, yaw) [m, rad], shape (n, 3).
        step: First step in x and y [m], and in yaw [rad].
        halvings: How often the steps may be halved.
        rounds: Greatest number of steps tried for each start.

    Returns:
        The poses reached and their costs.
    """
    poses, costs = starts.astype(np.float32), cost(starts)
    unit = np.array([step[0], step[0], step[1]], dtype=np.float32)
    level = np.zeros(len(poses), dtype=np.int64)
    for _ in range(rounds):
        active = np.flatnonzero(level <= halvings)
        if len(active) == 0:
            break
        scale = (0.5 ** level[active]).astype(np.float32)
        neighbours = poses[active, None, :] + scale[:, None, None] * (_COMPASS * unit)[None]
        tried = cost(neighbours.reshape(-1, 3)).reshape(len(active), len(_COMPASS))
        best = tried.argmin(axis=1)
        better = tried[np.arange(len(active)), best] < costs[active]
        poses[active[better]] = neighbours[better, best[better]]
        costs[active[better]] = tried[better, best[better]]
        level[active[~better]] += 1
    return poses, costs


_POLISH_CLIP = np.float32(0.015)
_BESIDE = 0.008
_SMOOTH = 3
_DOUBT = 2
_STEP = (0.002, math.radians(0.8))
_HALVINGS = 4
_ROUNDS = 30


def polish(template: HeightMap, points: Array, start: Floats, *, lowest: float) -> Floats:
    """Moves a pose to where the template's heights agree best with points on and beside the body's raised parts.

    Args:
        template: The body.
        points: x, y and height above the body's support [m], shape (n, 3).
        start: Pose (x, y, yaw) [m, rad].
        lowest: From which height on a part of the body counts as raised [m].

    Returns:
        The pose (x, y, yaw).
    """
    x, y, height = (points[:, k].astype(np.float32) for k in range(3))
    near = _widened(template).placed(x, y, start[None, :])[0] >= lowest
    if not near.any():
        return start
    x, y, height = x[near], y[near], height[near]
    soft = _softened(template)

    def cost(poses: Floats) -> Floats:
        misfit = np.abs(soft.placed(x, y, poses) - height)
        return np.asarray(np.minimum(misfit, _POLISH_CLIP).mean(axis=1))

    poses, _ = compass_search(cost, start[None, :], step=_STEP, halvings=_HALVINGS, rounds=_ROUNDS)
    return np.asarray(poses[0])


def misfits(template: HeightMap, elevation: ElevationMap, pose: Floats) -> Floats:
    """Returns by how much each cell contradicts a body at a pose (x, y, yaw), beyond the doubt about its edges [m]."""
    low, high = (bound.placed(elevation.x, elevation.y, pose[None, :])[0] for bound in _bounds(template))
    measured = np.where(elevation.seen, elevation.height - high, np.float32(0.0))
    return np.asarray(np.maximum(np.maximum(low - elevation.ceiling, measured), np.float32(0.0)))


def least_heights(template: HeightMap, elevation: ElevationMap, pose: Floats) -> Floats:
    """Returns how high a body at a pose (x, y, yaw) is in each cell at least, at the doubtful edges too [m]."""
    return np.asarray(_bounds(template)[0].placed(elevation.x, elevation.y, pose[None, :])[0])


@lru_cache(maxsize=256)
def _bounds(template: HeightMap) -> tuple[HeightMap, HeightMap]:
    """The least and the greatest height within half a cell."""
    size = 2 * _DOUBT + 1
    low, high = (partial(one, size=size) for one in (ndimage.minimum_filter, ndimage.maximum_filter))
    return _filtered(template, _DOUBT, low), _filtered(template, _DOUBT, high)


@lru_cache(maxsize=256)
def _softened(template: HeightMap) -> HeightMap:
    """Edges as slopes as wide as a point's place is in doubt, so that a shift of less than a pixel changes the fit."""
    return _filtered(template, _SMOOTH, partial(ndimage.uniform_filter, size=_SMOOTH))


@lru_cache(maxsize=256)
def _widened(template: HeightMap) -> HeightMap:
    reach = round(_BESIDE / template.resolution)
    return _filtered(template, reach + 1, partial(ndimage.maximum_filter, size=2 * reach + 1))


def _filtered(template: HeightMap, border: int, apply: Callable[[Floats], Floats]) -> HeightMap:
    """Applies a filter to a template, widened by a border of some entries."""
    x, y = template.origin
    origin = x - border * template.resolution, y - border * template.resolution
    return HeightMap(apply(np.pad(template.heights, border)), origin, template.resolution)


_CLIP = np.float32(0.030)
_RAISED = np.float32(0.008)
_WINDOW = 0.027
_YAWS = np.deg2rad(np.arange(0.0, 360.0, 15.0))
_SHIFTS = (-0.012, 0.0, 0.012)
_COARSE_STRIDE = 2
_RIVAL = 0.004
_HOPELESS = 0.010


@dataclass(frozen=True, slots=True)
class Fit:
    """How well one type explains a cluster.

    Attributes:
        type: The type.
        x, y, yaw: Where it would stand, in the frame of the look [m, rad].
        cost: Mean misfit over its cells and the cluster's [m].
        seen: Share of its own cells that the camera saw.
    """

    type: str
    x: float
    y: float
    yaw: float
    cost: float
    seen: float


@dataclass(frozen=True, slots=True, eq=False)
class Surroundings:
    """The cells in and around a cluster, as what they ask of an explanation.

    Attributes:
        x: Middle of the cells [m], shape (n,).
        y: Likewise.
        own: True for the cluster's cells.
        seen: True for cells that the camera saw.
        low: Least height that an explanation must have there [m].
        high: Greatest height that it may have there [m].
    """

    x: Floats
    y: Floats
    own: NDArray[np.bool_]
    seen: NDArray[np.bool_]
    low: Floats
    high: Floats

    @classmethod
    def of(cls, elevation: ElevationMap, cluster: NDArray[np.int64], *, stride: int = 1) -> Surroundings:
        """Cuts out a window around a cluster, taking every ``stride``-th cell in both directions."""
        own = np.zeros(len(elevation.x), dtype=np.bool_)
        own[cluster] = True
        cells = _window(elevation, cluster, stride)
        low = np.where(own, elevation.height, np.float32(0.0))
        return cls(
            x=elevation.x[cells],
            y=elevation.y[cells],
            own=own[cells],
            seen=elevation.seen[cells],
            low=low[cells],
            high=elevation.ceiling[cells],
        )

    def costs(self, template: HeightMap, poses: Floats) -> Floats:
        """Returns the misfit of a template at poses (x, y, yaw) [m], shape (m,).

        Per cell of the template or the cluster it is the height by which the explanation is lower than what was
        seen, or higher than what the look leaves possible, up to 30 mm; a cell that only one of them covers counts
        30 mm more.
        Cells that the camera could not see ask nothing, so they neither speak for a type nor against it.
        """
        there = template.placed(self.x, self.y, poses)
        misfit = self.low - there
        np.maximum(misfit, there - self.high, out=misfit)
        np.maximum(misfit, np.float32(0.0), out=misfit)
        covered = there > _RAISED
        alone = (self.own & ~covered) | (covered & (self.high < _RAISED))
        counted = self.own | (covered & (self.seen | (misfit > 0.0)))
        np.minimum(misfit, _CLIP, out=misfit)
        misfit += _CLIP * alone
        misfit *= counted
        return np.asarray(misfit.sum(axis=1) / np.maximum(counted.sum(axis=1), 1), dtype=np.float32)

    def seen_share(self, template: HeightMap, pose: Floats) -> float:
        """Returns the share of a template's cells that the camera saw."""
        covered = template.placed(self.x, self.y, pose[None, :])[0] > _RAISED
        return float(self.seen[covered].mean()) if covered.any() else 0.0


def best_fits(elevation: ElevationMap, cluster: NDArray[np.int64], models: Sequence[PartModel]) -> list[Fit]:
    """Fits every type to a cluster; best first."""
    coarse = Surroundings.of(elevation, cluster, stride=_COARSE_STRIDE)
    fine = Surroundings.of(elevation, cluster)
    templates = [height_map(model.solid) for model in models]
    rough = []
    for template in templates:
        cost = partial(coarse.costs, template)
        starts = _starts(template, coarse)
        rough.append(compass_search(cost, starts, step=(0.006, np.deg2rad(8.0)), halvings=1, rounds=8))
    least = min((float(costs.min()) for _, costs in rough), default=0.0)
    fits = []
    for model, template, (poses, costs) in zip(models, templates, rough, strict=True):
        poses, cost = poses[costs <= costs.min() + _RIVAL], partial(fine.costs, template)
        if costs.min() <= least + _HOPELESS:
            poses, _ = compass_search(cost, poses, step=(0.003, np.deg2rad(4.0)), halvings=3, rounds=14)
        exact = cost(poses)
        best = int(exact.argmin())
        x, y, yaw = (float(value) for value in poses[best])
        fits.append(Fit(model.type, x, y, yaw, float(exact[best]), fine.seen_share(template, poses[best])))
    return sorted(fits, key=lambda fit: (fit.cost, fit.type))


def _starts(template: HeightMap, cells: Surroundings) -> Floats:
    """The most promising poses of a raster around the cluster's middle."""
    middle = [(axis[cells.own].max() + axis[cells.own].min()) / 2.0 for axis in (cells.x, cells.y)]
    x, y, yaw = np.meshgrid(*(np.asarray(_SHIFTS) + value for value in middle), _YAWS, indexing="ij")
    raster = np.column_stack([x.ravel(), y.ravel(), yaw.ravel()]).astype(np.float32)
    costs = cells.costs(template, raster)
    best = raster[costs.argmin()]
    turn = np.abs(np.angle(np.exp(1j * (raster[:, 2] - best[2]))))
    costs[turn < np.deg2rad(50.0)] = np.inf  # the second start faces another way: most shapes fit almost as well turned
    return np.stack([best, raster[costs.argmin()]])


def _window(elevation: ElevationMap, cluster: NDArray[np.int64], stride: int) -> NDArray[np.int64]:
    nx, ny = elevation.shape
    margin = int(_WINDOW / abs(float(elevation.y[1] - elevation.y[0])))
    i, j = np.divmod(cluster, ny)
    rows = np.arange(max(i.min() - margin, 0), min(i.max() + margin + 1, nx), stride)
    columns = np.arange(max(j.min() - margin, 0), min(j.max() + margin + 1, ny), stride)
    return np.asarray((rows[:, None] * ny + columns[None, :]).ravel())
