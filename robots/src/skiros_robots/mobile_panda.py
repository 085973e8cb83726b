"""A differential-drive platform with a Franka Panda on it: the arm of the pybullet_data package, its URDF corrected.

Meshes stay in the installed package: the URDF refers to them by absolute path, so it is composed for each run.
"""

from __future__ import annotations

import importlib.util
import xml.etree.ElementTree as ET
from pathlib import Path

from skiros_py.errors import FileError, MissingExtra
from skiros_py.ports.kinematics import RobotModel

_HERE = Path(__file__).parent
_FINGER_EFFORT = "70"  # continuous force of the Franka hand; the file's 20 is less than the hand is used with here


def _compose() -> str:
    """Returns the URDF of the platform with the arm's links and joints in it, before the joint that mounts the arm."""
    robot = ET.parse(_HERE / "mobile_panda.urdf").getroot()  # noqa: S314 - a file of this package
    source = _panda_urdf()
    arm = ET.parse(source).getroot()  # noqa: S314 - a file of an installed package
    at = next(number for number, element in enumerate(robot) if element.get("name") == "panda_mount")
    # "grasptarget" is a link without mass; "tcp" replaces it.
    pieces = [element for element in arm if "grasptarget" not in element.get("name", "")]
    for number, piece in enumerate(pieces):
        _mend(piece, source.parent)
        robot.insert(at + number, piece)
    ET.indent(robot)
    return ET.tostring(robot, encoding="unicode", xml_declaration=True)


def _panda_urdf() -> Path:
    package = importlib.util.find_spec("pybullet_data")
    if package is None or package.origin is None:
        raise MissingExtra("pybullet", "the model 'mobile_panda'")
    path = Path(package.origin).parent / "franka_panda" / "panda.urdf"
    if not path.is_file():
        raise FileError(path, "the installed pybullet_data does not hold the Panda's description; reinstall pybullet")
    return path


def _mend(element: ET.Element, folder: Path) -> None:
    """Corrects one link or joint of the Panda's file in place.

    The file gives every link an inertia of 0.1 kg m², which makes light links and fingers sluggish, leaves one link
    without mass, and makes the fingertips soft, in which a held part turns.
    """
    for mesh in element.iter("mesh"):
        mesh.set("filename", str(folder / mesh.get("filename", "").removeprefix("package://")))
    finger = "finger" in element.get("name", "")
    for inertia in element.iter("inertia"):
        for axis in ("ixx", "iyy", "izz"):
            inertia.set(axis, "0.0001" if finger else "0.02")
    for mass in element.iter("mass"):
        mass.set("value", mass.get("value", "0") if float(mass.get("value", "0")) > 0.0 else "0.01")
    for part in [child for child in element if child.tag in ("contact", "mimic")]:
        element.remove(part)
    if finger:
        for limit in element.iter("limit"):
            limit.set("effort", _FINGER_EFFORT)


MOBILE_PANDA = RobotModel("mobile_panda", _compose, _HERE / "mobile_panda.ttl")
"""The robot of the kitting scenes."""
