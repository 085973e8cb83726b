"""A three-finger gripper with its camera, which several robots have: its links for their URDF, and its individuals."""

from __future__ import annotations

from pathlib import Path

from skiros_robots.installed_models import mounted

_HERE = Path(__file__).parent

THREE_FINGER_GRIPPER = _HERE / "three_finger_gripper.ttl"
"""The individuals of the gripper and of its camera, which those of a robot with an arm_1 import."""


def with_gripper(robot: Path) -> str:
    """Returns the URDF of a robot with the gripper.

    Args:
        robot: URDF file of the robot, whose joint "flange_joint" mounts the gripper that it does not have.
    """
    return mounted(robot, "flange_joint", _HERE / "three_finger_gripper.urdf")
