"""The built-in adapters for motion; their libraries are imported when they are created."""

from __future__ import annotations

from importlib.util import find_spec

from skiros_py.devices.arm import ArmSpec
from skiros_py.errors import SkirosError
from skiros_py.ports.adapters import Adapter, Request
from skiros_py.ports.device import DeviceSpec, MobileSpec
from skiros_py.ports.kinematics import InverseKinematics, Kinematics
from skiros_py.ports.motion import ArmPlanner, BasePlanner


def _is_arm(device: DeviceSpec[object, object]) -> bool:
    return isinstance(device, ArmSpec)


def _is_base(device: DeviceSpec[object, object]) -> bool:
    return isinstance(device, MobileSpec)


def _arm_planner(request: Request) -> object:
    from skiros_py.motion.arm_planner import WorkerArmPlanner

    return WorkerArmPlanner(request.groups[0])


def _base_planner(_request: Request) -> object:
    from skiros_py.motion.base_paths import ShapelyBasePlanner

    return ShapelyBasePlanner()


def _kinematics(request: Request) -> object | None:
    """Returns the kinematics of a robot; None where Pinocchio or the robot's model is not installed."""
    if not request.groups[0].model or find_spec("pinocchio") is None:
        return None
    from skiros_py.motion.pinocchio.kinematics import kinematics_of

    try:
        return kinematics_of(request.groups[0].model)
    except SkirosError:
        return None


def _inverse_kinematics(request: Request) -> object:
    from skiros_py.motion.pinocchio.arm_model import arm_model
    from skiros_py.motion.pinocchio.ik import IkSolver

    assert isinstance(request.device, ArmSpec)
    return IkSolver(arm_model(request.groups[0], request.device))


ARM_PLANNER = Adapter((ArmPlanner,), _arm_planner, serves=_is_arm, one_for="robot")
BASE_PLANNER = Adapter((BasePlanner,), _base_planner, serves=_is_base)
KINEMATICS = Adapter((Kinematics,), _kinematics, one_for="robot", eager=False, without_physics=True)
INVERSE_KINEMATICS = Adapter((InverseKinematics,), _inverse_kinematics, serves=_is_arm, one_for="device", eager=False)
