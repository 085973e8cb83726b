"""The exact pose of a known body: its raised walls, seen from above, matched to points near its believed pose.

All happens in the frame of the guess; ``lift`` is how far the body stands above it.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from skiros_py.geometry import Array, Pose
from skiros_py.perception.elevation import ElevationMap, elevation_map
from skiros_py.perception.heightmaps import Floats, HeightMap, height_map
from skiros_py.perception.pattern import align, wall_pattern
from skiros_py.perception.plane import Plane
from skiros_py.perception.polish import least_heights, misfits, polish
from skiros_py.perception.view import View
from skiros_py.ports.perception import RegistrationRequest, RegistrationResult

_REACH = 0.035
_RAISED = 0.45
_HEADROOM = 0.006
_FEWEST_POINTS = 200
_LEAST_SEEN = 0.4
_LEAST_COVERED = 0.75
_WORST_COST = 0.005
_AGREES = 0.006
_LEVEL_BIN = 0.002
_LEVEL_BAND = 0.004
_LEVEL_SEARCH = 0.035
_RIM = 0.001


def register(request: RegistrationRequest) -> RegistrationResult:
    """Finds a body near a guess."""
    view = View.of(request.image, request.camera_pose, request.guess)
    template = height_map(request.solid)
    near = view.points[_footprint(view.points, template, _REACH)]
    lift = _level(near, template)
    raised = near[_is_raised(near[:, 2] - lift, template)]
    if len(raised) < _FEWEST_POINTS:
        return RegistrationResult(None, math.inf, f"only {len(raised)} points are as high as the body's walls")
    start = align(wall_pattern(template, _RAISED * template.top), raised[:, :2])
    half = (template.radius + _REACH,) * 2
    elevation = elevation_map(view, Plane(0.0, 0.0, lift), half)
    pose = polish(template, near - (0.0, 0.0, lift), start, lowest=_RAISED * template.top)
    cost, fault = _judged(elevation, template, pose)
    if fault:
        return RegistrationResult(None, cost, fault)
    x, y, yaw = (float(value) for value in pose)
    z = _rim_lift(near, template, pose, lift)
    return RegistrationResult(request.guess @ Pose.of(x, y, z, yaw=yaw), cost)


def _footprint(points: Array, template: HeightMap, margin: float) -> NDArray[np.bool_]:
    """Points over the body's box at the guess, widened by a margin (or narrowed, where negative) [m]."""
    low = np.asarray(template.origin)
    high = low + (np.asarray(template.heights.shape) - 1) * template.resolution
    return np.asarray(np.all((points[:, :2] >= low - margin) & (points[:, :2] <= high + margin), axis=1))


def _level(points: Array, template: HeightMap) -> float:
    """How much higher than guessed the body's commonest level (the floors of its compartments) was seen [m]."""
    own = template.heights[template.heights > 0.0]
    common = _commonest(own.astype(np.float64), float(own.mean()), template.top)
    inner = points[_footprint(points, template, -_REACH), 2]
    return _commonest(inner, common, _LEVEL_SEARCH) - common


def _commonest(heights: Array, middle: float, reach: float) -> float:
    count, edges = np.histogram(heights, np.arange(middle - reach, middle + reach, _LEVEL_BIN))
    peak = float(edges[count.argmax()]) + _LEVEL_BIN / 2.0
    near = heights[np.abs(heights - peak) <= _LEVEL_BAND]
    return float(near.mean()) if len(near) else middle


def _is_raised(heights: Array, template: HeightMap) -> NDArray[np.bool_]:
    return np.asarray((heights >= _RAISED * template.top) & (heights <= template.top + _HEADROOM))


def _judged(elevation: ElevationMap, template: HeightMap, pose: Floats) -> tuple[float, str]:
    """Returns the mean misfit of the walls seen [m] and why the body is not there, or nothing."""
    wall = least_heights(template, elevation, pose) >= _RAISED * template.top
    misfit = misfits(template, elevation, pose)
    seen = wall & elevation.seen
    looked_through = wall & ~elevation.seen & (misfit > _AGREES)
    if seen.sum() + looked_through.sum() < _LEAST_SEEN * wall.sum():
        return math.inf, f"only {seen.sum() / wall.sum():.0%} of the body's walls can be seen"
    cost = float(misfit[seen | looked_through].mean())
    share = float(np.mean(misfit[seen | looked_through] <= _AGREES))
    if share < _LEAST_COVERED:
        return cost, f"only {share:.0%} of the walls seen are where the body has walls"
    if cost > _WORST_COST:
        return cost, f"the walls seen differ by {cost * 1000.0:.1f} mm on average"
    return cost, ""


def _rim_lift(points: Array, template: HeightMap, pose: Floats, lift: float) -> float:
    """The height at which the body stands by the upper side of its walls [m]; by its floors where no rim was seen."""
    inner = HeightMap(ndimage.minimum_filter(template.heights, size=3), template.origin, template.resolution)
    x, y = (points[:, k].astype(np.float32) for k in (0, 1))
    rim = inner.placed(x, y, pose[None, :])[0] >= template.top - _RIM
    above = points[:, 2] - lift - template.top
    level = above[rim & (np.abs(above) <= _LEVEL_BAND)]
    return lift + float(level.mean()) if len(level) >= _FEWEST_POINTS // 4 else lift
