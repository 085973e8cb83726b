"""A cell for contracts: one robot on a free floor."""

from __future__ import annotations

import math

from skiros_py.devices.arm import ArmSpec
from skiros_py.devices.camera import CameraSpec
from skiros_py.devices.force_torque import ForceTorqueSpec
from skiros_py.devices.gripper import GripperSpec
from skiros_py.devices.localiser import LocaliserSpec
from skiros_py.devices.mobile_base import BaseSpec
from skiros_py.devices.scanner import ScannerSpec
from skiros_py.geometry import Pose
from skiros_py.ports.cell import CellSpec, RobotSpec

_HOME = (-1.5708, -0.6, 0.0, -2.4, 0.0, 1.9, 0.7854)
_FOOTPRINT = ((-0.525, -0.305), (0.345, -0.305), (0.345, 0.305), (-0.525, 0.305))


def small_cell(*, cameras: bool = True) -> CellSpec:
    """Returns a cell with nothing but one mobile manipulator of the model that comes with the simulation.

    Args:
        cameras: False for a robot without a camera.
    """
    eye = CameraSpec("camera", "camera_optical", 160, 120, math.radians(56.0), 0.05, 2.0, 0.001, 0.1)
    robot = RobotSpec(
        "robot",
        "mobile_panda",
        (
            BaseSpec("base", Pose(), _FOOTPRINT, 0.8, 1.2, 0.8, 1.6),
            LocaliserSpec("localiser"),
            ScannerSpec("scanner", "scanner", math.pi, 5.0),
            ArmSpec("arm", tuple(f"panda_joint{n}" for n in range(1, 8)), "tcp", _HOME),
            ForceTorqueSpec("force_torque", "arm", "panda_joint7", "panda_link8", 1.222, (0.0, 0.0, 0.035)),
            GripperSpec("gripper", ("panda_finger_joint1", "panda_finger_joint2"), "arm", 0.08, 70.0),
            *((eye,) if cameras else ()),
        ),
    )
    return CellSpec((), (robot,))
