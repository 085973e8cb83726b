"""Poses of tools and parts used by primitives."""

from __future__ import annotations

import math

from skiros_py.geometry import Pose


def downward(x: float, y: float, z: float, yaw: float) -> Pose:
    """Returns a tool pose that points straight down; the tool's x axis has the given heading [m, rad]."""
    return Pose.of(x, y, z, roll=math.pi, yaw=yaw)


def level(pose: Pose) -> Pose:
    """Returns a pose without its tilt: things are assumed to stand upright, regardless of the measured tilt."""
    return Pose.of(*pose.position, yaw=pose.yaw)
