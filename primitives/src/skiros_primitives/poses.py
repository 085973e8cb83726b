"""Poses of tools and parts that primitives reckon with."""

from __future__ import annotations

import math

from skiros_py.geometry import Pose


def downward(x: float, y: float, z: float, yaw: float) -> Pose:
    """Returns a tool pose that points straight down; the tool's x axis has the given heading [m, rad]."""
    return Pose.of(x, y, z, roll=math.pi, yaw=yaw)


def level(pose: Pose) -> Pose:
    """Returns a pose without its tilt: things are believed to stand as they are described, whatever a look says."""
    return Pose.of(*pose.position, yaw=pose.yaw)
