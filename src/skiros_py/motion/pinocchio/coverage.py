"""The floor area around its base that an arm covers while it moves."""

from __future__ import annotations

from itertools import product

import numpy as np
import shapely

from skiros_py.geometry import Array, Pose
from skiros_py.motion.pinocchio.arm_model import ArmModel
from skiros_py.ports.motion import Held

_THICK = 0.12
"""How far links, hand and camera stick out around the joints and the tip [m]."""
_STEP = 10
"""Every so many samples of a trajectory are looked at; between two, nothing moves by more than 0.1 m."""

_TURNS = np.linspace(0.0, 2.0 * np.pi, 8, endpoint=False)
_RIM = _THICK / np.cos(np.pi / 8.0) * np.column_stack([np.cos(_TURNS), np.sin(_TURNS)])
"""Corners of an octagon around a circle."""

Corners = tuple[tuple[float, float], ...]


def covered(arm: ArmModel, postures: Array, held: Held | None) -> Corners:
    """Returns the corners of a convex outline, in the frame of the base [m], above which the arm is all the time.

    Args:
        arm: The arm.
        postures: Joint angles in close succession [rad], shape (samples, joints).
        held: What it holds, which sticks out further.
    """
    body = _body(held)
    points = np.vstack([_points(arm, posture, body) for posture in (*postures[::_STEP], postures[-1])])
    around = (points[:, None, :2] + _RIM).reshape(-1, 2)
    corners = shapely.get_coordinates(shapely.MultiPoint(around).convex_hull)[:-1]
    return tuple((float(x), float(y)) for x, y in corners)


def _points(arm: ArmModel, posture: Array, body: Array) -> Array:
    """Returns the joints, the tip and the corners of what it holds [m]."""
    return np.vstack([arm.joint_places(posture), Pose.from_matrix(arm.tip_pose(posture).homogeneous).apply(body)])


def _body(held: Held | None) -> Array:
    """Returns the tip, and the corners of the box around what it holds, in the tip's frame [m]."""
    tip = np.zeros((1, 3))
    if held is None:
        return tip
    corners = np.array(list(product(*np.transpose(held.solid.bounds()))))
    return np.vstack([tip, held.pose.apply(corners)])
