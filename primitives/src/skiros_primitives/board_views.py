"""From where to look at a printed board, so that its pictures tell where the camera is on its carrier."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import count

import numpy as np

from skiros_py.geometry import Pose
from skiros_py.ports.calibration import MarkerBoard
from skiros_py.ports.values import CameraIntrinsics

_FILLED = 1.1, 0.6
"""Shares of the height of a picture that the board's diagonal fills, in turn."""
_TILTS = tuple(math.radians(tilt) for tilt in (55.0, 15.0, 45.0))
"""Angles from straight above the board, in turn."""
_GOLDEN = math.pi * (3.0 - math.sqrt(5.0))
"""Sides to look from that are this far apart never repeat."""
_ROLL = math.radians(110.0)
"""The camera is turned about its axis by so much from view to view: what does not turn cannot be told apart."""


def centre_of(board: MarkerBoard) -> Pose:
    """Returns the middle of a board in its frame, with its z axis into the printed face, away from who looks at it."""
    return Pose((board.columns * board.square / 2.0, board.rows * board.square / 2.0, 0.0))


def board_views(board: MarkerBoard, pose: Pose, k: CameraIntrinsics) -> Iterator[Pose]:
    """Yields poses of a camera around a board without end, each different enough from those before.

    Args:
        board: The board.
        pose: The board, whose z axis points away from who looks at it.
        k: The camera's model.
    """
    diagonal = math.hypot(board.columns, board.rows) * board.square
    middle, height = pose @ centre_of(board), min(k.height, k.width)
    for number in count():
        far = k.fy * diagonal / (_FILLED[number % len(_FILLED)] * height)
        tilt, side, roll = _TILTS[number % len(_TILTS)], number * _GOLDEN, number * _ROLL
        yield middle @ _looking(far, tilt, side, roll)


def _looking(far: float, tilt: float, side: float, roll: float) -> Pose:
    """Returns the pose of a camera that looks at the origin, from -z [m, rad]."""
    axis = np.array([math.sin(tilt) * math.cos(side), math.sin(tilt) * math.sin(side), math.cos(tilt)])
    across = np.cross((0.0, 1.0, 0.0), axis)
    across /= np.linalg.norm(across)
    matrix = np.eye(4)
    matrix[:3, :3] = np.column_stack([across, np.cross(axis, across), axis])
    matrix[:3, 3] = -far * axis
    return Pose.from_matrix(matrix) @ Pose.of(0.0, 0.0, 0.0, yaw=roll)
