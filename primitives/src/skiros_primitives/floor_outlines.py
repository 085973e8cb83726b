"""Floor area covered by things, seen from above."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from skiros_py.geometry import Array, Pose, Primitive
from skiros_py.ports.motion import Obstacle

_TALLEST = 1.6
"""Things above this height do not obstruct a base [m]."""


def covered(obstacle: Obstacle) -> BaseGeometry:
    """Returns the floor area covered by an obstacle [m, map frame]; for round blocks, the enclosing square."""
    corners = [(obstacle.pose @ block.pose).apply(_corners(block)) for block in obstacle.solid.primitives]
    outlines = [shapely.MultiPoint(block[:, :2]).convex_hull for block in corners if block[:, 2].min() < _TALLEST]
    return shapely.union_all(outlines)


def placed(outline: Sequence[tuple[float, float]], base: Pose) -> BaseGeometry:
    """Returns the area covered by an outline in the frame of a base at a given pose [m, map frame]."""
    points = base.apply(np.array([(x, y, 0.0) for x, y in outline]))
    return shapely.MultiPoint(points[:, :2]).convex_hull


def _corners(block: Primitive) -> Array:
    if block.kind == "box":
        half = np.array(block.size) / 2.0
    else:
        radius, length = block.size
        half = np.array([radius, radius, length / 2.0])
    corners: Array = half * np.array(list(product((-1.0, 1.0), repeat=3)))
    return corners
