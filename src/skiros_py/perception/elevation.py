"""The result of one look for each cell of a support surface: its measured height and its maximum possible height."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from skiros_py.geometry import Array
from skiros_py.perception.heightmaps import Floats
from skiros_py.perception.plane import Plane
from skiros_py.perception.view import View

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
