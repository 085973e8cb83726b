"""Finds the type and pose of a part that best explain a cluster of raised cells."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from skiros_py.perception.elevation import ElevationMap
from skiros_py.perception.heightmaps import Floats, HeightMap, height_map
from skiros_py.perception.search import compass_search
from skiros_py.ports.perception import PartModel

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
    rough = [_roughly(height_map(model.solid), coarse) for model in models]
    least = min((float(costs.min()) for _, costs in rough), default=0.0)
    fits = []
    for model, (poses, costs) in zip(models, rough, strict=True):
        template = height_map(model.solid)
        poses = poses[costs <= costs.min() + _RIVAL]
        if costs.min() <= least + _HOPELESS:
            poses = _exactly(template, fine, poses)
        fits.append(_fit(model.type, template, fine, poses))
    return sorted(fits, key=lambda fit: (fit.cost, fit.type))


def _roughly(template: HeightMap, cells: Surroundings) -> tuple[Floats, Floats]:
    starts = _starts(template, cells)
    return compass_search(
        lambda poses: cells.costs(template, poses), starts, step=(0.006, np.deg2rad(8.0)), halvings=1, rounds=8
    )


def _exactly(template: HeightMap, cells: Surroundings, starts: Floats) -> Floats:
    poses, _ = compass_search(
        lambda poses: cells.costs(template, poses), starts, step=(0.003, np.deg2rad(4.0)), halvings=3, rounds=14
    )
    return poses


def _fit(type_name: str, template: HeightMap, cells: Surroundings, poses: Floats) -> Fit:
    costs = cells.costs(template, poses)
    best = int(costs.argmin())
    x, y, yaw = (float(value) for value in poses[best])
    return Fit(type_name, x, y, yaw, float(costs[best]), cells.seen_share(template, poses[best]))


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
