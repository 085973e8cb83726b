"""Where a camera is on its carrier: the pose that explains best where the corners of a board were seen.

Camera and board are found together, by least squares over the distances of all corners in all pictures.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from skiros_py.geometry import Array, Pose
from skiros_py.messages import Message
from skiros_py.ports.calibration import CalibrationResult
from skiros_py.ports.values import CameraIntrinsics

_FEWEST_VIEWS = 5
_FEWEST_CORNERS = 6
"""A picture with fewer corners is left out."""
_LEAST_NOISE = 0.1
"""Corners are never taken to be seen better than this [px]."""
_WORST_RESIDUAL = 1.0
"""What fits worse is no such board, or it has moved [px]."""
_UNSURE, _TURNED = 0.001, math.radians(0.2)
"""Views that leave greater standard deviations than these are too much alike [m, rad]."""
_ROBUST = 1.0
"""Corners farther off than this count less [px]."""


@dataclass(frozen=True, slots=True, eq=False)
class SeenCorners:
    """The corners of a board in a picture.

    Attributes:
        corners: Their places in the frame of the board [m], shape (n, 3).
        pixels: Where they were seen [px], shape (n, 2).
        intrinsics: Of the camera.
        carrier: Pose of what carries the camera, in a frame in which the board stands still.
    """

    corners: Array
    pixels: Array
    intrinsics: CameraIntrinsics
    carrier: Pose


def solve(
    seen: Sequence[SeenCorners], camera: Pose, board: Pose, *, board_is_measured: bool = False
) -> CalibrationResult:
    """Finds the pose of a camera in the frame of its carrier.

    Args:
        seen: What each picture shows.
        camera: Believed pose of the camera in the frame of its carrier, best within 5 cm and 15 degrees.
        board: Believed pose of the board, best within 10 cm and 15 degrees.
        board_is_measured: True where that pose is exact.
    """
    views = [view for view in seen if len(view.corners) >= _FEWEST_CORNERS]
    if len(views) < _FEWEST_VIEWS:
        known = {"views": len(views), "needed": _FEWEST_VIEWS}
        why = Message("only {views} pictures show enough of the board, of {needed} that are needed", **known)
        return CalibrationResult(None, board, len(views), math.inf, math.inf, math.inf, why)

    def errors(change: Array) -> Array:
        own, there = _changed(camera, change[:6]), board if board_is_measured else _changed(board, change[6:])
        return np.concatenate([_errors(view, own, there) for view in views])

    found = least_squares(
        errors, np.zeros(6 if board_is_measured else 12), x_scale="jac", loss="huber", f_scale=_ROBUST
    )
    own, there = _changed(camera, found.x[:6]), board if board_is_measured else _changed(board, found.x[6:])
    residual = math.sqrt(2.0 * float(np.mean(np.square(errors(found.x)))))  # of both coordinates of a corner
    position, angle = _uncertainty(np.asarray(found.jac), max(residual / math.sqrt(2.0), _LEAST_NOISE))
    doubt = _doubt(residual, position, angle)
    return CalibrationResult(None if doubt else own, there, len(views), residual, position, angle, doubt)


def _doubt(residual: float, position: float, angle: float) -> str:
    """Returns why a solution is not to be used; nothing where it is."""
    if residual > _WORST_RESIDUAL:
        return Message("the corners of the board are {residual:.1f} px from where they should be", residual=residual)
    if position > _UNSURE or angle > _TURNED:
        known = {"position": min(1e3 * position, 1e3), "angle": min(math.degrees(angle), 180.0)}
        return Message(
            "the views are too much alike: they leave the camera uncertain by {position:.1f} mm and {angle:.2f} deg",
            **known,
        )
    return ""


def _changed(pose: Pose, change: Array) -> Pose:
    """Returns a pose moved and turned in its own frame by [m, rotation vector in rad]."""
    x, y, z = (float(value) for value in change[:3])
    qx, qy, qz, qw = (float(value) for value in Rotation.from_rotvec(change[3:]).as_quat())
    return pose @ Pose((x, y, z), (qx, qy, qz, qw))


def _errors(view: SeenCorners, camera: Pose, board: Pose) -> Array:
    """Returns how far corners were seen from where they should be, both coordinates of each [px]."""
    k = view.intrinsics
    x, y, z = ((view.carrier @ camera).inverse() @ board).apply(view.corners).T
    depth = np.maximum(z, 1e-3)  # behind the camera: far off, but a number
    expected = np.stack([k.fx * x / depth + k.cx, k.fy * y / depth + k.cy], axis=-1)
    return np.asarray((expected - view.pixels).ravel())


def _uncertainty(jacobian: Array, noise: float) -> tuple[float, float]:
    """Returns the standard deviations of the camera's position and orientation [m, rad]; infinite for what is open."""
    values, vectors = np.linalg.eigh(jacobian.T @ jacobian)
    if values[0] <= 1e-9 * values[-1]:
        return math.inf, math.inf
    variance = np.diag(noise**2 * (vectors / values) @ vectors.T)
    return math.sqrt(float(variance[:3].sum())), math.sqrt(float(variance[3:6].sum()))
