"""A hexacopter with a small arm below it, described by files alone."""

from __future__ import annotations

from pathlib import Path

from skiros_py.ports.kinematics import RobotModel

_HERE = Path(__file__).parent

HEXACOPTER = RobotModel("hexacopter", _HERE / "hexacopter.urdf", _HERE / "hexacopter.ttl")
"""The robot of the scene delivery_uav."""
