"""The built-in adapters for motion; their libraries are imported when they are created."""

from __future__ import annotations

from importlib.util import find_spec

from skiros_py.devices.arm import ArmSpec
from skiros_py.errors import SkirosError
from skiros_py.ports.adapters import Adapter, Request
from skiros_py.ports.cell import RobotSpec
from skiros_py.ports.device import DeviceSpec, MobileSpec
from skiros_py.ports.kinematics import InverseKinematics, Kinematics
from skiros_py.ports.motion import ArmPlanner, BasePlanner, MotionPlan, MotionRequest, NoMotion
from skiros_py.ports.values import Pending
from skiros_py.workers import Worker

_PLAN_LATENCY = 0.05


class WorkerArmPlanner:
    """Plans the motions of one robot's arms in a worker process; a :class:`skiros_py.ports.motion.ArmPlanner`.

    Args:
        spec: The robot.
        latency: Declared time from request to plan [s]; in lockstep the simulation runs on for as long.
    """

    def __init__(self, spec: RobotSpec, *, latency: float = _PLAN_LATENCY) -> None:
        self._worker = Worker("motion", _Factory(spec))
        self._latency = latency

    def plan(self, request: MotionRequest) -> Pending[MotionPlan | NoMotion]:
        """Plans one request."""
        return self._worker.call("plan", request, latency=self._latency)

    def wait_ready(self) -> None:
        """Waits until the models are loaded.

        Raises:
            DeviceError: They could not be loaded.
        """
        self._worker.wait_ready()

    def close(self) -> None:
        """Ends the worker process."""
        self._worker.close()


class _Factory:
    """Builds the planner inside the worker, where Pinocchio is loaded."""

    def __init__(self, spec: RobotSpec) -> None:
        self._spec = spec

    def __call__(self) -> object:
        from skiros_py.motion.pinocchio.arm_motion import ArmMotion  # heavy, and not needed in the calling process

        return ArmMotion(self._spec)


def _is_arm(device: DeviceSpec[object, object]) -> bool:
    return isinstance(device, ArmSpec)


def _is_base(device: DeviceSpec[object, object]) -> bool:
    return isinstance(device, MobileSpec)


def _arm_planner(request: Request) -> object:

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
    from skiros_py.motion.pinocchio.kinematics import IkSolver

    assert isinstance(request.device, ArmSpec)
    return IkSolver(arm_model(request.groups[0], request.device))


ARM_PLANNER = Adapter((ArmPlanner,), _arm_planner, serves=_is_arm, one_for="robot")
BASE_PLANNER = Adapter((BasePlanner,), _base_planner, serves=_is_base)
KINEMATICS = Adapter((Kinematics,), _kinematics, one_for="robot", eager=False, without_physics=True)
INVERSE_KINEMATICS = Adapter((InverseKinematics,), _inverse_kinematics, serves=_is_arm, one_for="device", eager=False)
