"""Groups the cells of a surface into objects."""

from __future__ import annotations

import numpy as np
import open3d as o3d
from numpy.typing import NDArray

from skiros_py.geometry import Array
from skiros_py.perception.elevation import CELL, ElevationMap

_LOWEST = 0.008
_EPS = 0.014
_TOUCHING_EPS = 0.0065
_FEWEST_NEIGHBOURS = 6
_HEIGHT_WEIGHT = 0.2
_FEWEST_CELLS = 25
_NARROWEST = 0.008
_BORDER = 0.004


def clusters_of(elevation: ElevationMap, half_extents: tuple[float, float]) -> list[NDArray[np.int64]]:
    """Groups the raised cells within a rectangle around the map's middle.

    Height counts a fifth: a step of 30 mm hides half as much behind it and must not split a part in two.

    Args:
        elevation: The look.
        half_extents: Of the rectangle along x and y [m]; a narrow band inside its border is left out, since a wall
            around it reaches in by the error of its pose.

    Returns:
        Indices of the cells of each cluster, largest cluster first.
    """
    inside = np.abs(elevation.x) <= half_extents[0] - _BORDER
    inside &= np.abs(elevation.y) <= half_extents[1] - _BORDER
    raised = np.flatnonzero(inside & elevation.seen & (elevation.height >= _LOWEST))
    if len(raised) == 0:
        return []
    return _groups(elevation, raised, _EPS)


def pieces_of(elevation: ElevationMap, cluster: NDArray[np.int64]) -> list[NDArray[np.int64]]:
    """Splits a cluster where it hangs together by less than two cells: parts that nearly touch."""
    return _groups(elevation, cluster, _TOUCHING_EPS)


def outline(elevation: ElevationMap, cells: NDArray[np.int64]) -> tuple[float, float, float, float, float]:
    """Returns the box around cells: middle x, middle y [m], yaw of its long side [rad], length and width [m]."""
    points = np.column_stack([elevation.x[cells], elevation.y[cells]]).astype(np.float64)
    angles = np.deg2rad(np.arange(0.0, 90.0, 1.0))
    axes = np.stack([np.cos(angles), np.sin(angles)], axis=0)
    along = points @ axes
    across = points @ np.stack([-axes[1], axes[0]], axis=0)
    spans = np.stack([np.ptp(along, axis=0), np.ptp(across, axis=0)]) + CELL
    best = int((spans[0] * spans[1]).argmin())
    middle_u = (along[:, best].max() + along[:, best].min()) / 2.0
    middle_v = (across[:, best].max() + across[:, best].min()) / 2.0
    yaw, (length, width) = float(angles[best]), spans[:, best]
    cos, sin = np.cos(yaw), np.sin(yaw)
    x, y = cos * middle_u - sin * middle_v, sin * middle_u + cos * middle_v
    if width > length:
        yaw, length, width = yaw + np.pi / 2.0, width, length
    return float(x), float(y), float(yaw), float(length), float(width)


def _groups(elevation: ElevationMap, cells: NDArray[np.int64], eps: float) -> list[NDArray[np.int64]]:
    labels = _labels(elevation, cells, eps)
    groups = [cells[labels == label] for label in range(labels.max() + 1)]
    things = [group for group in groups if len(group) >= _FEWEST_CELLS and _is_thing(elevation, group)]
    return sorted(things, key=lambda group: (-len(group), int(group[0])))


def _labels(elevation: ElevationMap, cells: NDArray[np.int64], eps: float) -> NDArray[np.int64]:
    columns = [elevation.x[cells], elevation.y[cells], _HEIGHT_WEIGHT * elevation.height[cells]]
    points: Array = np.column_stack(columns).astype(np.float64)
    cloud = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(points))
    return np.asarray(cloud.cluster_dbscan(eps, _FEWEST_NEIGHBOURS), dtype=np.int64)


def _is_thing(elevation: ElevationMap, cells: NDArray[np.int64]) -> bool:
    """False for slivers: the face of a wall seen through an inexact border."""
    return outline(elevation, cells)[4] >= _NARROWEST
