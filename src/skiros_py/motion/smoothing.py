"""Rounds the corners of a joint path so that the arm need not stop at its way points."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from skiros_py.geometry import Array

_STEP = 0.02  # [rad] between samples of the path
_WINDOWS = (0.5, 0.25, 0.12)  # [rad] lengths of path over which corners are rounded, widest first


def round_corners(way_points: Sequence[Array], clear: Callable[[Array], bool]) -> Array | None:
    """Rounds a path's corners as widely as its surroundings allow.

    Args:
        way_points: Joint angles [rad] with clear straight lines in between; at least two.
        clear: Returns whether a posture is free of collisions.

    Returns:
        Joint angles [rad] at even steps, shape (n, joints), from the first to the last way point; None when even the
        tightest rounding touches something.
    """
    path = _sampled(way_points)
    if len(way_points) == 2:
        return path
    for window in _WINDOWS:
        rounded = _averaged(path, max(1, round(window / _STEP / 2.0)))
        if all(clear(posture) for posture in rounded):
            return rounded
    return None


def _sampled(way_points: Sequence[Array]) -> Array:
    corners = np.array(way_points)
    lengths = np.linalg.norm(np.diff(corners, axis=0), axis=1)
    corners = corners[np.concatenate([[True], lengths > 1e-9])]
    along = np.concatenate([[0.0], np.cumsum(lengths[lengths > 1e-9])])
    places = np.linspace(0.0, along[-1], max(5, int(np.ceil(along[-1] / _STEP)) + 1))
    return np.column_stack([np.interp(places, along, column) for column in corners.T])


def _averaged(path: Array, half: int) -> Array:
    """Averages twice over a window; beyond its ends the path is mirrored through them, so they stay where they are."""
    half = min(half, (len(path) - 1) // 2)
    kernel = np.full(2 * half + 1, 1.0 / (2 * half + 1))
    for _ in range(2):
        before = 2.0 * path[0] - path[half:0:-1]
        after = 2.0 * path[-1] - path[-2 : -half - 2 : -1]
        extended = np.vstack([before, path, after])
        path = np.column_stack([np.convolve(column, kernel, mode="valid") for column in extended.T])
    return path
