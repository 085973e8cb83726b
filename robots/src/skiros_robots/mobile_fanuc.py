"""A heavy platform with a differential drive and a Fanuc M-20iA with a three-finger gripper on it."""

from __future__ import annotations

from pathlib import Path

from skiros_py.ports.kinematics import RobotModel
from skiros_robots.three_finger_gripper import with_gripper

_HERE = Path(__file__).parent

MOBILE_FANUC = RobotModel("mobile_fanuc", lambda: with_gripper(_HERE / "mobile_fanuc.urdf"), _HERE / "mobile_fanuc.ttl")
"""The robot of the scene kitting_fanuc."""
