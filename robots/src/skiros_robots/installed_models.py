"""URDF of arms and hands, composed with the URDF of what carries them; some are in installed packages."""

from __future__ import annotations

import importlib.util
import xml.etree.ElementTree as ET
from collections.abc import Callable, Collection
from pathlib import Path

from skiros_py.errors import FileError, MissingExtra


def mounted(
    platform: Path,
    mount: str,
    arm: Path,
    mend: Callable[[ET.Element], None] = lambda _: None,
    *,
    without: Collection[str] = (),
) -> str:
    """Returns the URDF of a platform with an arm's links and joints in it, before the joint that mounts the arm.

    Args:
        platform: URDF file of the platform, which mounts an arm that it does not have.
        mount: Name of the joint that mounts it.
        arm: URDF file of the arm; its meshes stay where they are, and are named by absolute paths.
        mend: Corrects one link or joint of the arm in place.
        without: Names of links and joints of the arm that are left out.
    """
    robot = ET.parse(platform).getroot()  # noqa: S314 - a file of this package
    at = next(number for number, element in enumerate(robot) if element.get("name") == mount)
    pieces = ET.parse(arm).getroot()  # noqa: S314 - a file of an installed package
    for number, piece in enumerate(one for one in pieces if one.get("name") not in without):
        for mesh in piece.iter("mesh"):
            mesh.set("filename", str(arm.parent / mesh.get("filename", "").removeprefix("package://")))
        mend(piece)
        robot.insert(at + number, piece)
    ET.indent(robot)
    return ET.tostring(robot, encoding="unicode", xml_declaration=True)


def pybullet_urdf(name: str, model: str) -> Path:
    """Returns a URDF file of the package pybullet_data.

    Args:
        name: Its path there ("kuka_iiwa/model.urdf").
        model: The robot that is composed from it, for messages.

    Raises:
        MissingExtra: The package is not installed.
        FileError: It does not hold the file.
    """
    package = importlib.util.find_spec("pybullet_data")
    if package is None or package.origin is None:
        raise MissingExtra("pybullet", f"the model '{model}'")
    path = Path(package.origin).parent / name
    if not path.is_file():
        raise FileError(path, f"the installed pybullet_data does not hold the model '{model}'; reinstall pybullet")
    return path
