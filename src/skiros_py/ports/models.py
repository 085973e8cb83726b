"""Robot models: a robot as its distribution brings it, with a URDF for all who need its geometry.

A robot comes by the entry-point group ``skiros.robots``. The simulation, the kinematics, the collision checker and the
pages load the same file.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from skiros_py.errors import UsageError
from skiros_py.plugins import find_plugin

GROUP = "skiros.robots"
"""Entry points of this group name robots: a :class:`RobotModel`, or files with individuals alone."""

BASE_LINK = "base_link"
"""Footprint frame of a mobile base: on the floor, x forward, in the middle between the wheels."""

BASE_JOINTS = ("base_x", "base_y", "base_yaw")
"""Joints of a mobile base: where it is in the map [m, m, rad]."""


@dataclass(frozen=True, slots=True)
class RobotModel:
    """A robot: what its geometry is and which individuals a scene imports.

    Attributes:
        name: Its name, as ``sk:model`` and its entry point have it ("mobile_panda").
        urdf: Its URDF file, or what composes the URDF text. Where a base moves it, its root link is "map".
        individuals: Turtle file with its individuals; None for a robot whose individuals others describe.
    """

    name: str
    urdf: Path | Callable[[], str]
    individuals: Path | None = None

    def write(self, directory: Path) -> Path:
        """Returns its URDF file; one that is composed is written to a directory.

        Raises:
            DeviceError: A package that it is composed from is not installed.
            FileError: A file that it is composed from is missing.
        """
        if isinstance(self.urdf, Path):
            return self.urdf
        path = directory / f"{self.name}.urdf"
        path.write_text(self.urdf(), encoding="utf-8")
        return path


def write_robot_urdf(model: str, directory: Path) -> Path:
    """Returns the URDF file of a robot model, which is written to a directory where it is composed.

    Args:
        model: Name of the model ("mobile_panda").
        directory: Where to write; it must exist and should belong to the run alone.

    Raises:
        UnknownName: No distribution brings that model.
        UsageError: It cannot be loaded, or has no URDF.
        DeviceError: A package that it is composed from is not installed.
        FileError: A file that it is composed from is missing.
    """
    robot = find_plugin(GROUP, model, kind="robot model")
    if not isinstance(robot, RobotModel):
        raise UsageError(f"robot model '{model}' has no URDF: its entry point names files with individuals alone")
    return robot.write(directory)
