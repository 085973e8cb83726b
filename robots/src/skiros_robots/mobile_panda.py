"""A differential-drive platform with a Franka Panda on it: the arm of the pybullet_data package, its URDF corrected.

Meshes stay in the installed package: the URDF refers to them by absolute path, so it is composed for each run.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from pathlib import Path

from skiros_py.ports.kinematics import RobotModel
from skiros_robots.installed_models import mounted, pybullet_urdf

_HERE = Path(__file__).parent
_FINGER_EFFORT = "70"  # continuous force of the Franka hand; the file's 20 is less than the hand is used with here


def _compose() -> str:
    """Returns the URDF; the tool point of the arm's file is a link without mass, and "tcp" replaces it."""
    urdf = pybullet_urdf("franka_panda/panda.urdf", "mobile_panda")
    tool = ("panda_grasptarget", "panda_grasptarget_hand")
    return mounted(_HERE / "mobile_panda.urdf", "panda_mount", urdf, _mend, without=tool)


def _compose_with_mast() -> str:
    """Returns the URDF with a mast on the platform, which carries a camera."""
    robot, mast = ET.fromstring(_compose()), ET.parse(_HERE / "mast.urdf").getroot()  # noqa: S314 - files of packages
    robot.set("name", "mobile_panda_mast")
    robot.extend(mast)
    ET.indent(robot)
    return ET.tostring(robot, encoding="unicode", xml_declaration=True)


def _mend(element: ET.Element) -> None:
    """Corrects one link or joint of the Panda's file in place.

    The file gives every link an inertia of 0.1 kg m², which makes light links and fingers sluggish, leaves one link
    without mass, and makes the fingertips soft, in which a held part turns.
    """
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
MOBILE_PANDA_MAST = RobotModel("mobile_panda_mast", _compose_with_mast, _HERE / "mobile_panda_mast.ttl")
"""The same with a camera on a mast."""
DEVICES = _HERE / "mobile_panda_devices.ttl"
"""The individuals that both have."""
