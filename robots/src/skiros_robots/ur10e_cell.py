"""A UR10e on a pedestal: a cell that stands where it is, described by files alone."""

from __future__ import annotations

from pathlib import Path

from skiros_py.ports.kinematics import RobotModel
from skiros_robots.three_finger_gripper import with_gripper

_HERE = Path(__file__).parent

UR10E_CELL = RobotModel("ur10e_cell", lambda: with_gripper(_HERE / "ur10e_cell.urdf"), _HERE / "ur10e_cell.ttl")
"""The robot of the kitting cell."""
