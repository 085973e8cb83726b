"""Outlines on the floor of solids and of a base."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from skiros_py.geometry import Array, Pose, Primitive
from skiros_py.ports.motion import Obstacle

_TALLEST = 1.6  # [m] what begins higher does not stand in the way of a base with its arm folded
_CORNERS = 24  # of the polygon around a circle


def floor_outline(obstacle: Obstacle) -> BaseGeometry:
    """Returns the floor area of an obstacle [m in the map]: the union of its blocks' outlines below 1.6 m."""
    blocks = [_points(obstacle.pose @ block.pose, block) for block in obstacle.solid.primitives]
    outlines = [shapely.MultiPoint(points[:, :2]).convex_hull for points in blocks if points[:, 2].min() < _TALLEST]
    return shapely.union_all(outlines)


def placed(footprint: Sequence[tuple[float, float]], base: Pose) -> shapely.Polygon:
    """Returns the outline of a base standing at a pose [m in the map]."""
    corners = np.array([(x, y, 0.0) for x, y in footprint])
    return shapely.Polygon(base.apply(corners)[:, :2])


def swept(footprint: Sequence[tuple[float, float]], start: Pose, end: Pose) -> BaseGeometry:
    """Returns the area swept by a convex outline while driving straight, without turning, from start to end."""
    return shapely.union(placed(footprint, start), placed(footprint, end)).convex_hull


def _points(pose: Pose, block: Primitive) -> Array:
    if block.kind == "box":
        half = np.array(block.size) / 2.0
        signs = np.array(np.meshgrid([-1, 1], [-1, 1], [-1, 1])).reshape(3, -1).T
        return pose.apply(signs * half)
    radius, length = block.size
    angles = np.linspace(0.0, 2.0 * np.pi, _CORNERS, endpoint=False)
    rim = radius / np.cos(np.pi / _CORNERS) * np.column_stack([np.cos(angles), np.sin(angles)])
    ends = [np.column_stack([rim, np.full(_CORNERS, z)]) for z in (-length / 2.0, length / 2.0)]
    return pose.apply(np.vstack(ends))
