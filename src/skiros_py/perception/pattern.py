"""The ground plan of a body's walls and its alignment with points by ICP."""

from __future__ import annotations

import itertools
import math

import numpy as np
import open3d as o3d
from scipy.spatial import cKDTree

from skiros_py.geometry import Array
from skiros_py.perception.heightmaps import Floats, HeightMap

_STEP = 0.003
_SHIFTS = (-0.022, 0.0, 0.022)
_TURNS = (-math.radians(3.5), 0.0, math.radians(3.5))
_KEPT = 3
_RANKED_POINTS = 300
_STAGES = (0.020, 0.008, 0.005)
_ITERATIONS = 30


def wall_pattern(template: HeightMap, lowest: float) -> Array:
    """Returns places where a body is higher than ``lowest`` [m], every few millimetres, shape (n, 2)."""
    stride = round(_STEP / template.resolution)
    i, j = np.nonzero(template.heights[::stride, ::stride] >= lowest)
    return np.asarray(np.asarray(template.origin) + np.column_stack([i, j]) * _STEP)


def align(pattern: Array, points: Array) -> Floats:
    """Finds the pose of a pattern that brings it onto points.

    Several starts within some 3 cm and 5 degrees are ranked by distance; ICP takes the best ones further. The
    pattern is matched to the points and not the other way round, so what stands between the walls attracts nothing.

    Args:
        pattern: Places in the body's frame [m], shape (n, 2).
        points: What was seen at the height of the walls [m], shape (m, 2).

    Returns:
        Pose (x, y, yaw) [m, rad].
    """
    target = _cloud(points)
    starts = _promising(pattern, points)
    results = [_icp(_cloud(pattern), target, start) for start in starts]
    matrix = min(results, key=lambda result: (-result.fitness, result.inlier_rmse)).transformation
    yaw = math.atan2(matrix[1, 0], matrix[0, 0])
    return np.array([matrix[0, 3], matrix[1, 3], yaw], dtype=np.float32)


def _promising(pattern: Array, points: Array) -> list[Array]:
    tree = cKDTree(points)
    sample = pattern[:: max(1, len(pattern) // _RANKED_POINTS)]
    ranked: list[tuple[float, int, Array]] = []
    for x, y, yaw in itertools.product(_SHIFTS, _SHIFTS, _TURNS):
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
