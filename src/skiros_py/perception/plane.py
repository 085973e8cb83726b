"""The support surface: the lowest large level plane among points."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import open3d as o3d

from skiros_py.geometry import Array

_VOXEL = 0.008
_INLIER = 0.005
_ITERATIONS = 200
_LEVEL = 0.98
_LEAST_VOXELS = 25
_LEAST_SHARE_BELOW = 0.15
_BELOW = 0.010


@dataclass(frozen=True, slots=True)
class Plane:
    """A level surface z = slope_x * x + slope_y * y + offset [m]."""

    slope_x: float
    slope_y: float
    offset: float

    def z(self, x: Array | float, y: Array | float) -> Array:
        """Returns the surface's z at places [m]."""
        return np.asarray(self.slope_x * x + self.slope_y * y + self.offset)

    def heights(self, points: Array) -> Array:
        """Returns how high points of shape (n, 3) are above the surface [m]."""
        return points[:, 2] - self.z(points[:, 0], points[:, 1])


def find_support(points: Array, *, seed: int) -> Plane | None:
    """Finds the surface that things stand on.

    A lid, a hand or the tops of many parts may be the largest plane; what they stand on is below them. So while a good
    share of the points lies below the plane found, the search goes on among those.

    Args:
        points: Candidates, cropped to where the surface may be [m], shape (n, 3).
        seed: Seed of the random choices.

    Returns:
        The plane, or None when the points hold no level plane.
    """
    o3d.utility.random.seed(seed % 2**31)
    voxels = _thin(points)
    fewest = max(_LEAST_VOXELS, _LEAST_SHARE_BELOW * len(voxels))
    found: Plane | None = None
    while len(voxels) >= fewest:
        plane = _largest(voxels)
        if plane is None:
            break
        found = plane
        voxels = voxels[plane.heights(voxels) < -_BELOW]
    return None if found is None else _refined(found, points)


def _thin(points: Array) -> Array:
    cloud = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(points))
    return np.asarray(cloud.voxel_down_sample(_VOXEL).points)


def _largest(voxels: Array) -> Plane | None:
    cloud = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(voxels))
    (a, b, c, d), inliers = cloud.segment_plane(_INLIER, 3, _ITERATIONS)
    if len(inliers) < _LEAST_VOXELS or abs(c) < _LEVEL:
        return None
    return Plane(-a / c, -b / c, -d / c)


def _refined(plane: Plane, points: Array) -> Plane:
    """Fits the plane to all its points; RANSAC's own fit knows the thinned ones only."""
    near = points[np.abs(plane.heights(points)) < _INLIER]
    design = np.column_stack([near[:, :2], np.ones(len(near))])
    (slope_x, slope_y, offset), *_ = np.linalg.lstsq(design, near[:, 2], rcond=None)
    return Plane(float(slope_x), float(slope_y), float(offset))
