"""An omnidirectional platform with a KUKA LBR iiwa 14 R820 and a Schunk WSG 50 on it.

The arm is that of the pybullet_data package, which has the kinematics, the meshes and the limits of the R820's joints,
but masses of the smaller iiwa 7, a base without mass, and one speed for all joints. Its meshes stay in the installed
package: the URDF refers to them by absolute path, so it is composed for each run.
"""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from pathlib import Path

from skiros_py.ports.kinematics import RobotModel
from skiros_robots.installed_models import mounted, pybullet_urdf

_HERE = Path(__file__).parent
_LINKS = {
    0: (5.0, (0.05, 0.06, 0.03)),
    1: (5.76, (0.033, 0.0333, 0.0123)),
    2: (6.35, (0.0305, 0.0304, 0.011)),
    3: (3.5, (0.025, 0.0238, 0.0076)),
    4: (3.5, (0.017, 0.0164, 0.006)),
    5: (3.5, (0.01, 0.0087, 0.00449)),
    6: (1.8, (0.0049, 0.0047, 0.0036)),
    7: (1.2, (0.001, 0.001, 0.001)),
}
"""Masses of the links [kg], together about the 30 kg of the arm, and their moments of inertia about x, y, z [kg m²]."""
_JOINTS = {1: (85, 320), 2: (85, 320), 3: (100, 176), 4: (75, 176), 5: (130, 110), 6: (135, 40), 7: (135, 40)}
"""Greatest speed [deg/s] and torque [N m] of each joint, from the data sheet."""


def _compose() -> str:
    urdf = pybullet_urdf("kuka_iiwa/model.urdf", "mobile_iiwa")
    return mounted(_HERE / "mobile_iiwa.urdf", "iiwa_mount", urdf, _mend)


def _mend(piece: ET.Element) -> None:
    """Gives one link of the arm its mass, or one joint its limits."""
    number = int(piece.get("name", "")[-1]) if piece.tag in ("link", "joint") else 0
    if piece.tag == "link":
        mass, moments = _LINKS[number]
        for element in piece.iter("mass"):
            element.set("value", str(mass))
        for element in piece.iter("inertia"):
            element.attrib.update(zip(("ixx", "iyy", "izz"), map(str, moments), strict=True))
    elif piece.tag == "joint":
        speed, torque = _JOINTS[number]
        for element in piece.iter("limit"):
            element.attrib.update(velocity=f"{math.radians(speed):.4f}", effort=str(torque))


MOBILE_IIWA = RobotModel("mobile_iiwa", _compose, _HERE / "mobile_iiwa.ttl")
"""The robot of the scene kitting_iiwa."""
