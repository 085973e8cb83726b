"""The share of a region that the camera really saw."""

from __future__ import annotations

import numpy as np

from skiros_py.perception.elevation import HIGHEST
from skiros_py.perception.plane import Plane
from skiros_py.perception.view import View

_CELL = 0.005
_BESIDE = 0.020


def visible_share(view: View, plane: Plane, half_extents: tuple[float, float]) -> float:
    """Returns the share of a region's cells that the camera saw, 0 to 1.

    A cell is seen when its ray lies inside the image and ends on the surface or on something on it that may be a
    part: not higher than any part, and inside the region or just beside it. What hides the region from farther off
    is an occluder.

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
    reached = measured >= expected  # a ray that went on below the surface met nothing on its way
    return float(np.mean((measured > 0.0) & (reached | (low & near))))
