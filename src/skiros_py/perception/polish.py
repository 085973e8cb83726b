"""The last millimetre: fits a template to the points themselves, since cells blur where an edge is."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
from scipy import ndimage

from skiros_py.geometry import Array
from skiros_py.perception.elevation import ElevationMap
from skiros_py.perception.heightmaps import Floats, HeightMap
from skiros_py.perception.search import compass_search

_CLIP = np.float32(0.015)
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
        return np.asarray(np.minimum(misfit, _CLIP).mean(axis=1))

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
    heights, origin = np.pad(template.heights, _DOUBT), _outwards(template, _DOUBT)
    size = 2 * _DOUBT + 1
    low, high = ndimage.minimum_filter(heights, size=size), ndimage.maximum_filter(heights, size=size)
    return HeightMap(low, origin, template.resolution), HeightMap(high, origin, template.resolution)


@lru_cache(maxsize=256)
def _softened(template: HeightMap) -> HeightMap:
    """Edges as slopes as wide as a point's place is in doubt, so that a shift of less than a pixel changes the fit."""
    heights = ndimage.uniform_filter(np.pad(template.heights, _SMOOTH), size=_SMOOTH)
    return HeightMap(heights, _outwards(template, _SMOOTH), template.resolution)


@lru_cache(maxsize=256)
def _widened(template: HeightMap) -> HeightMap:
    reach = round(_BESIDE / template.resolution)
    heights = ndimage.maximum_filter(np.pad(template.heights, reach + 1), size=2 * reach + 1)
    return HeightMap(heights, _outwards(template, reach + 1), template.resolution)


def _outwards(template: HeightMap, entries: int) -> tuple[float, float]:
    x, y = template.origin
    return x - entries * template.resolution, y - entries * template.resolution
