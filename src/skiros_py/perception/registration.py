"""The exact pose of a known body: its raised walls, seen from above, matched to points near the believed pose.

All happens in the frame of the guess; ``lift`` is how far the body stands above it.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage
from scipy.spatial import cKDTree

from skiros_py.geometry import Array, Pose
from skiros_py.open3d import pybind as o3d
from skiros_py.perception.classify import least_heights, misfits, polish
from skiros_py.perception.elevation import ElevationMap, Plane, View, elevation_map
from skiros_py.perception.heightmaps import Floats, HeightMap, height_map
from skiros_py.ports.perception import RegistrationRequest, RegistrationResult

_STEP = 0.003
_SHIFTS = (-0.022, 0.0, 0.022)
_FAR = tuple(0.022 * step for step in range(-7, 8))
_TURNS = tuple(math.radians(turn) for turn in (-10.5, -7.0, -3.5, 0.0, 3.5, 7.0, 10.5))
_KEPT = 3
_RANKED_POINTS = 300
_STAGES = (0.020, 0.008, 0.005)
_ITERATIONS = 30


def wall_pattern(template: HeightMap, lowest: float) -> Array:
    """Returns places where a body is higher than ``lowest`` [m], every few millimetres, shape (n, 2)."""
    stride = round(_STEP / template.resolution)
    i, j = np.nonzero(template.heights[::stride, ::stride] >= lowest)
    return np.asarray(np.asarray(template.origin) + np.column_stack([i, j]) * _STEP)


def align(pattern: Array, points: Array, shifts: Sequence[float] = _SHIFTS) -> Floats:
    """Finds the pose of a pattern that brings it onto points.

    Several starts within some 3 cm and 10 degrees are ranked by distance; ICP takes the best ones further. The
    pattern is matched to the points and not the other way round, so what stands between the walls attracts nothing.

    Args:
        pattern: Places in the body's frame [m], shape (n, 2).
        points: What was seen at the height of the walls [m], shape (m, 2).
        shifts: The starts along x and y [m].

    Returns:
        Pose (x, y, yaw) [m, rad].
    """
    target = _cloud(points)
    starts = _promising(pattern, points, shifts)
    results = [_icp(_cloud(pattern), target, start) for start in starts]
    matrix = min(results, key=lambda result: (-result.fitness, result.inlier_rmse)).transformation
    yaw = math.atan2(matrix[1, 0], matrix[0, 0])
    return np.array([matrix[0, 3], matrix[1, 3], yaw], dtype=np.float32)


def _promising(pattern: Array, points: Array, shifts: Sequence[float]) -> list[Array]:
    tree = cKDTree(points)
    sample = pattern[:: max(1, len(pattern) // _RANKED_POINTS)]
    ranked: list[tuple[float, int, Array]] = []
    for x, y, yaw in itertools.product(shifts, shifts, _TURNS):
        matrix = _matrix(x, y, yaw)
        distance, _ = tree.query(sample @ matrix[:2, :2].T + matrix[:2, 3], distance_upper_bound=_STAGES[0])
        ranked.append((float(np.minimum(distance, _STAGES[0]).mean()), len(ranked), matrix))
    return [matrix for *_, matrix in sorted(ranked, key=lambda entry: entry[:2])[:_KEPT]]


def _icp(
    source: o3d.geometry.PointCloud, target: o3d.geometry.PointCloud, start: Array
) -> o3d.pipelines.registration.RegistrationResult:
    icp = o3d.pipelines.registration
    until = icp.ICPConvergenceCriteria(max_iteration=_ITERATIONS)
    matrix = start
    for reach in _STAGES:
        result = icp.registration_icp(source, target, reach, matrix, icp.TransformationEstimationPointToPoint(), until)
        matrix = result.transformation
    return result


def _cloud(places: Array) -> o3d.geometry.PointCloud:
    flat = np.column_stack([places, np.zeros(len(places))])
    return o3d.geometry.PointCloud(o3d.utility.Vector3dVector(flat))


def _matrix(x: float, y: float, yaw: float) -> Array:
    cos, sin = math.cos(yaw), math.sin(yaw)
    return np.array([[cos, -sin, 0.0, x], [sin, cos, 0.0, y], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]])


_REACH = 0.075
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
    """Finds a body near a guess; where it is not, within some 15 cm of it."""
    result = _registered(request)
    if result.pose is None and (guess := _elsewhere(request)) is not None:
        again = _registered(replace(request, guess=guess))
        result = again if again.pose is not None else result
    return result


def _registered(request: RegistrationRequest) -> RegistrationResult:
    view = View.of(request.image, request.camera_pose, request.guess)
    template = height_map(request.solid)
    near, lift, raised = _raised(view, template, _REACH)
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


def _elsewhere(request: RegistrationRequest) -> Pose | None:
    """Returns a better guess, from walls farther off."""
    view, template = View.of(request.image, request.camera_pose, request.guess), height_map(request.solid)
    _, _, raised = _raised(view, template, _FAR[-1])
    if len(raised) < _FEWEST_POINTS:
        return None
    x, y, yaw = (float(value) for value in align(wall_pattern(template, _RAISED * template.top), raised[:, :2], _FAR))
    return request.guess @ Pose.of(x, y, 0.0, yaw=yaw)


def _raised(view: View, template: HeightMap, reach: float) -> tuple[Array, float, Array]:
    """Returns the points about a body, how much higher than guessed it stands, and the points as high as its walls."""
    near = view.points[_footprint(view.points, template, reach)]
    lift = _level(near, template)
    heights = near[:, 2] - lift
    return near, lift, near[(heights >= _RAISED * template.top) & (heights <= template.top + _HEADROOM)]


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


def _judged(elevation: ElevationMap, template: HeightMap, pose: Floats) -> tuple[float, str]:
    """Returns the mean misfit of the walls seen [m] and why the body is not there, or nothing."""
    low = least_heights(template, elevation, pose)
    if low.max() < _RAISED * template.top:  # its walls are thinner than the doubt about where edges are
        low = template.placed(elevation.x, elevation.y, pose[None, :])[0]
    wall = low >= _RAISED * template.top
    misfit = np.maximum(misfits(template, elevation, pose), low - elevation.ceiling)
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
