"""A depth image seen from a frame of interest: its points there, and what the camera saw along a ray."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage
from scipy.spatial.transform import Rotation

from skiros_py.geometry import Array, Pose
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
        depth = _usable(image)
        nearest = ndimage.minimum_filter(depth, size=3, mode="nearest")
        return cls(camera.apply(_deproject(depth, image.intrinsics)), camera, image.intrinsics, depth, nearest)

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


def _usable(image: DepthImage) -> NDArray[np.float32]:
    depth = np.nan_to_num(image.depth, nan=0.0, posinf=0.0, neginf=0.0)
    k = image.intrinsics
    return np.where((depth >= k.near) & (depth <= k.far), depth, np.float32(0.0)).astype(np.float32)


def _deproject(depth: NDArray[np.float32], k: CameraIntrinsics) -> Array:
    v, u = np.nonzero(depth)
    z = depth[v, u].astype(np.float64)
    return np.column_stack([(u - k.cx) / k.fx * z, (v - k.cy) / k.fy * z, z])
