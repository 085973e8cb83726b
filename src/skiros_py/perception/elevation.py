"""One look at a surface: the points that the camera saw, the support plane, heights over it, and what was visible."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage
from scipy.spatial.transform import Rotation

from skiros_py.geometry import Array, Pose
from skiros_py.open3d import pybind as o3d
from skiros_py.perception.heightmaps import Floats
from skiros_py.ports.values import CameraIntrinsics, DepthImage


@dataclass(frozen=True, slots=True, eq=False)
class View:
    """One shot, expressed in a frame.

    Attributes:
        points: What was measured, in the frame [m], shape (n, 3).
        camera: Pose of the optical frame in the frame.
    """

    points: Array
    camera: Pose
    _intrinsics: CameraIntrinsics
    _depth: NDArray[np.float32]
    _nearest: NDArray[np.float32]

    @classmethod
    def of(cls, image: DepthImage, camera_pose: Pose, frame: Pose) -> View:
        """Expresses a shot in a frame.

        Args:
            image: The shot.
            camera_pose: Pose of the optical frame in the map.
            frame: Pose of the frame of interest in the map.
        """
        camera = frame.inverse() @ camera_pose
        k, depth = image.intrinsics, np.nan_to_num(image.depth, nan=0.0, posinf=0.0, neginf=0.0)
        depth = np.where((depth >= k.near) & (depth <= k.far), depth, np.float32(0.0)).astype(np.float32)
        nearest = ndimage.minimum_filter(depth, size=3, mode="nearest")
        return cls(camera.apply(replace(image, depth=depth).points()), camera, k, depth, nearest)

    def measured(self, points: Array) -> tuple[Array, Array]:
        """Returns, for each point, its depth and the depth that the camera measured in its direction [m].

        The measured depth is 0 where the point lies outside the image or nothing was measured.
        """
        return self._look_up(self._depth, points)

    def free(self, points: Array, *, tolerance: float) -> NDArray[np.bool_]:
        """Returns which points the camera saw through.

        The nearest of the neighbouring pixels decides, so a point beside an edge is not called free by half a pixel.

        Args:
            points: In the frame [m], shape (n, 3).
            tolerance: How far behind a point the camera must have seen [m].
        """
        expected, measured = self._look_up(self._nearest, points)
        return np.asarray(measured > expected + tolerance)

    def hits(self, expected: Array, measured: Array, points: Array) -> Array:
        """Returns what the camera saw in the direction of each point, in the frame [m], shape (n, 3).

        Args:
            expected: Depths of the points, from :meth:`measured` [m].
            measured: Depths measured, likewise [m].
            points: The points [m], shape (n, 3).
        """
        eye = np.asarray(self.camera.position)
        return np.asarray(eye + (points - eye) * (measured / expected)[:, None])

    def _look_up(self, depth: NDArray[np.float32], points: Array) -> tuple[Array, Array]:
        k = self._intrinsics
        rotation = Rotation.from_quat(self.camera.orientation).as_matrix()
        optical = (points - np.asarray(self.camera.position)) @ rotation
        z = np.maximum(optical[:, 2], 1e-6)
        u = np.rint(optical[:, 0] / z * k.fx + k.cx).astype(np.int64)
        v = np.rint(optical[:, 1] / z * k.fy + k.cy).astype(np.int64)
        inside = (optical[:, 2] > k.near) & (u >= 0) & (u < k.width) & (v >= 0) & (v < k.height)
        measured = np.zeros(len(points))
        measured[inside] = depth[v[inside], u[inside]]
        return z, measured


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
    cloud = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(points))
    voxels = np.asarray(cloud.voxel_down_sample(_VOXEL).points)
    fewest = max(_LEAST_VOXELS, _LEAST_SHARE_BELOW * len(voxels))
    found: Plane | None = None
    while len(voxels) >= fewest:
        plane = _largest(voxels)
        if plane is None:
            break
        found = plane
        voxels = voxels[plane.heights(voxels) < -_BELOW]
    return None if found is None else _refined(found, points)


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


CELL = 0.003
"""Edge of a cell [m]; a pixel covers about 2 mm."""
HIGHEST = 0.120
"""No part is higher above its support than this [m]."""

_BAND = 0.006
_LEVELS = np.arange(0.004, HIGHEST + 0.001, 0.004)
_FREE_TOLERANCE = 0.004


@dataclass(frozen=True, slots=True, eq=False)
class ElevationMap:
    """Heights above a support surface, cell by cell; all arrays have one entry per cell, x-major.

    Attributes:
        shape: Number of cells along x and y.
        x: Middle of the cell in the frame of the look [m].
        y: Likewise.
        seen: True where the camera measured something not higher than a part may be.
        height: Height of what was seen [m]; 0 where nothing was.
        ceiling: Greatest height that the look leaves possible [m]: what was seen; in the shadow of something, the
            height from which on the camera looked through; infinite where it could not see at all.
    """

    shape: tuple[int, int]
    x: Floats
    y: Floats
    seen: NDArray[np.bool_]
    height: Floats
    ceiling: Floats


def elevation_map(view: View, plane: Plane, half_extents: tuple[float, float]) -> ElevationMap:
    """Maps a rectangle around the frame's origin.

    Args:
        view: The look, in the frame of the rectangle.
        plane: The support surface in that frame.
        half_extents: Of the rectangle along x and y [m].
    """
    nx, ny = (int(np.ceil(2.0 * half / CELL)) for half in half_extents)
    x = (np.arange(nx) - (nx - 1) / 2.0) * CELL
    y = (np.arange(ny) - (ny - 1) / 2.0) * CELL
    grid_x, grid_y = (axis.ravel() for axis in np.meshgrid(x, y, indexing="ij"))
    height, seen = _heights(view.points, plane, (nx, ny))
    ceiling = np.where(seen, height, np.inf)
    hidden = np.flatnonzero(~seen)
    x, y = grid_x[hidden], grid_y[hidden]
    _, measured = view.measured(np.column_stack([x, y, plane.z(x, y)]))
    hidden = hidden[measured > 0.0]  # what lies beyond the image stays unknown
    ceiling[hidden] = _ceilings(view, plane, grid_x[hidden], grid_y[hidden])
    return ElevationMap(
        shape=(nx, ny),
        x=grid_x.astype(np.float32),
        y=grid_y.astype(np.float32),
        seen=seen,
        height=height.astype(np.float32),
        ceiling=ceiling.astype(np.float32),
    )


def _heights(points: Array, plane: Plane, shape: tuple[int, int]) -> tuple[Array, NDArray[np.bool_]]:
    """Mean height of each cell's topmost points; the topmost alone would read high by the noise."""
    nx, ny = shape
    i = np.floor(points[:, 0] / CELL + nx / 2.0).astype(np.int64)
    j = np.floor(points[:, 1] / CELL + ny / 2.0).astype(np.int64)
    heights = plane.heights(points)
    inside = (i >= 0) & (i < nx) & (j >= 0) & (j < ny) & (heights <= HIGHEST)
    cell, heights = (i * ny + j)[inside], heights[inside]
    top = np.full(nx * ny, -np.inf)
    np.maximum.at(top, cell, heights)
    upper = heights >= top[cell] - _BAND
    count = np.bincount(cell[upper], minlength=nx * ny)
    total = np.bincount(cell[upper], weights=heights[upper], minlength=nx * ny)
    return np.maximum(total / np.maximum(count, 1), 0.0), count > 0


def _ceilings(view: View, plane: Plane, x: Array, y: Array) -> Array:
    """Lowest height above which the camera looked through everything; infinite where not even the top is free."""
    if len(x) == 0:
        return np.zeros(0)
    ground = plane.z(x, y)
    columns = np.stack(
        [np.repeat(x, len(_LEVELS)), np.repeat(y, len(_LEVELS)), (ground[:, None] + _LEVELS).ravel()], axis=-1
    )
    free = view.free(columns, tolerance=_FREE_TOLERANCE).reshape(len(x), len(_LEVELS))
    free_from_top = np.cumprod(free[:, ::-1], axis=1).sum(axis=1)
    bounds = np.concatenate([[0.0], _LEVELS[:-1], [np.inf]])
    return np.asarray(bounds[len(_LEVELS) - free_from_top])


_CELL = 0.005
_BESIDE = 0.020
_SHADOW = 0.085
"""What hides a place from farther in front of it may hide a whole part there [m]."""


def visible_share(view: View, plane: Plane, half_extents: tuple[float, float]) -> float:
    """Returns the share of a region's cells that the camera saw, 0 to 1.

    A cell is seen when its ray lies inside the image and ends on the surface or on something on it that may be a
    part: not higher than any part, inside the region or just beside it, and not far from the cell. What hides it from
    farther off is an occluder; where the camera looks aslant, a high part is one for what lies behind it.

    Args:
        view: The look, in the region's frame.
        plane: The support surface in that frame.
        half_extents: Of the region [m].
    """
    axes = [np.arange(-half + _CELL / 2.0, half, _CELL) for half in half_extents]
    x, y = (axis.ravel() for axis in np.meshgrid(*axes, indexing="ij"))
    cells = np.column_stack([x, y, plane.z(x, y)])
    expected, measured = view.measured(cells)
    hits = view.hits(expected, measured, cells)
    low = plane.heights(hits) <= HIGHEST
    near = np.all(np.abs(hits[:, :2]) <= np.asarray(half_extents) + _BESIDE, axis=1)
    near &= np.linalg.norm(hits[:, :2] - cells[:, :2], axis=1) <= _SHADOW
    reached = measured >= expected  # a ray that went on below the surface met nothing on its way
    return float(np.mean((measured > 0.0) & (reached | (low & near))))
