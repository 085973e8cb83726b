"""Templates: the height of a solid over each point of its own frame, computed from its primitives."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from skiros_py.geometry import Array, Primitive, Solid

Floats = NDArray[np.float32]

_RESOLUTION = 0.001
_PARALLEL = 1e-9


@dataclass(frozen=True, slots=True, eq=False)
class HeightMap:
    """Heights of a solid's upper side above its frame; 0 beside it.

    Attributes:
        heights: [m], shape (nx, ny), with a border of zeros.
        origin: (x, y) of the middle of the first entry in the solid's frame [m].
        resolution: Distance between entries [m].
    """

    heights: Floats
    origin: tuple[float, float]
    resolution: float

    def placed(self, x: Floats, y: Floats, poses: Floats) -> Floats:
        """Returns the heights at places of a plane on which the solid stands.

        Args:
            x: Of the places [m], shape (n,).
            y: Likewise.
            poses: (x, y, yaw) of the solid in the plane [m, rad], shape (m, 3).

        Returns:
            Heights [m], shape (m, n).
        """
        places = np.stack([x, y, np.ones_like(x)])
        px, py, cos, sin = poses[:, 0], poses[:, 1], np.cos(poses[:, 2]), np.sin(poses[:, 2])
        i = self._entries(places, np.stack([cos, sin, -cos * px - sin * py], axis=1), axis=0)
        j = self._entries(places, np.stack([-sin, cos, sin * px - cos * py], axis=1), axis=1)
        i *= np.int32(self.heights.shape[1])
        i += j
        return np.asarray(self.heights.ravel().take(i))

    def _entries(self, places: Floats, rows: Floats, *, axis: int) -> NDArray[np.int32]:
        """Nearest entries along one axis; those at the border stand for all beyond.

        Args:
            places: x, y, 1 of the places, shape (3, n).
            rows: For each pose what makes the coordinate in the solid's frame of them, shape (m, 3).
            axis: 0 for x, 1 for y.
        """
        entries = rows * np.float32(1.0 / self.resolution) @ places
        entries += np.float32(0.5 - self.origin[axis] / self.resolution)
        np.maximum(entries, np.float32(0.0), out=entries)
        np.minimum(entries, np.float32(self.heights.shape[axis] - 1), out=entries)
        return np.asarray(entries, dtype=np.int32)

    @property
    def top(self) -> float:
        """Greatest height [m]."""
        return float(self.heights.max())

    @property
    def radius(self) -> float:
        """Distance of the farthest corner of the footprint's box from the frame [m]."""
        far = np.asarray(self.origin) + (np.asarray(self.heights.shape) - 1) * self.resolution
        return float(np.hypot(*np.maximum(np.abs(self.origin), np.abs(far))))


@lru_cache(maxsize=256)
def height_map(solid: Solid) -> HeightMap:
    """Computes the height map of a solid that stands on its frame."""
    low, high = solid.bounds()
    border = 2.5 * _RESOLUTION  # between the millimetres: an entry on an edge would fall to one side by rounding
    axes = [np.arange(low[k] - border, high[k] + border + _RESOLUTION, _RESOLUTION) for k in (0, 1)]
    x, y = np.meshgrid(axes[0], axes[1], indexing="ij")
    heights = np.zeros(x.shape)
    for block in solid.primitives:
        np.maximum(heights, _top(block, x, y), out=heights)
    return HeightMap(heights.astype(np.float32), (float(axes[0][0]), float(axes[1][0])), _RESOLUTION)


def _top(block: Primitive, x: Array, y: Array) -> Array:
    """Where vertical lines through (x, y) leave a block [m]; 0 where they miss it."""
    rotation = Rotation.from_quat(block.pose.orientation).as_matrix()
    start = np.stack([x, y, np.zeros_like(x)], axis=-1) - np.asarray(block.pose.position)
    start = start @ rotation
    direction = rotation[2]
    if block.kind == "box":
        spans = [_slab(start[..., k], direction[k], block.size[k] / 2.0) for k in range(3)]
    else:
        radius, length = block.size
        spans = [_slab(start[..., 2], direction[2], length / 2.0), _tube(start, direction, radius)]
    enter = np.maximum.reduce([span[0] for span in spans])
    leave = np.minimum.reduce([span[1] for span in spans])
    return np.where(leave >= enter, np.maximum(leave, 0.0), 0.0)


def _slab(start: Array, slope: float, half: float) -> tuple[Array, Array]:
    if abs(slope) < _PARALLEL:
        inside = np.abs(start) <= half
        return np.where(inside, -np.inf, np.inf), np.where(inside, np.inf, -np.inf)
    ends = np.stack([(-half - start) / slope, (half - start) / slope])
    return ends.min(axis=0), ends.max(axis=0)


def _tube(start: Array, direction: Array, radius: float) -> tuple[Array, Array]:
    x, y = start[..., 0], start[..., 1]
    a = float(direction[0] ** 2 + direction[1] ** 2)
    if a < _PARALLEL:
        inside = x**2 + y**2 <= radius**2
        return np.where(inside, -np.inf, np.inf), np.where(inside, np.inf, -np.inf)
    half_b = x * direction[0] + y * direction[1]
    root = half_b**2 - a * (x**2 + y**2 - radius**2)
    reach = np.sqrt(np.maximum(root, 0.0))
    hit = root >= 0.0
    return np.where(hit, (-half_b - reach) / a, np.inf), np.where(hit, (-half_b + reach) / a, -np.inf)
