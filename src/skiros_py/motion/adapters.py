"""The built-in adapters for motion; their libraries are imported when they are created."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from importlib.util import find_spec
from typing import Any

from platformdirs import user_cache_path

from skiros_py.devices.arm import ArmSpec
from skiros_py.errors import SkirosError
from skiros_py.ports.adapters import Adapter, Request
from skiros_py.ports.cell import RobotSpec
from skiros_py.ports.device import DeviceSpec, MobileSpec
from skiros_py.ports.kinematics import Dynamics, InverseKinematics, Kinematics
from skiros_py.ports.motion import ArmPlanner, BasePlanner, ReachChecker, SamplingPlanner, SceneMapper
from skiros_py.ports.values import Pending
from skiros_py.workers import Worker

_LATENCY = 0.05
_MORE = 0.02
"""Declared time for each further place of a base from where an arm may reach something [s]."""


class WorkerPlanner:
    """Plans motions in a worker process: an ``ArmPlanner``, ``SceneMapper``, ``ReachChecker``, or a ``BasePlanner``.

    Args:
        name: Name of the process.
        build: Builds the planner there.
        latency: Declared time from request to plan [s]; in lockstep the simulation runs on for as long.
    """

    def __init__(self, name: str, build: Callable[[], object], *, latency: float = _LATENCY) -> None:
        self._worker = Worker(name, build)
        self._latency = latency

    def plan(self, request: Any) -> Pending[Any]:
        """Plans one request."""
        return self._worker.call("plan", request, latency=self._latency)

    def see(self, view: Any) -> Pending[Any]:
        """Shows the planner of arms a picture."""
        return self._worker.call("see", view, latency=self._latency)

    def blocked(self, check: Any) -> Pending[Any]:
        """Asks the planner of arms what that was seen is in the way of a motion."""
        return self._worker.call("blocked", check, latency=self._latency)

    def reach(self, request: Any) -> Pending[Any]:
        """Asks the planner of arms from where an arm reaches something."""
        latency = self._latency + _MORE * (len(request.bases) - 1)
        return self._worker.call("reach", request, latency=latency)

    def close(self) -> None:
        """Ends the worker process."""
        self._worker.close()


def arm_motion(spec: RobotSpec) -> object:
    """Builds the motion planning of a robot's arms; for a worker process, where Pinocchio is loaded."""
    from skiros_py.motion.pinocchio.arm_motion import ArmMotion

    return ArmMotion(spec)


def base_paths() -> object:
    """Builds the path planning of bases; for a worker process, where Shapely is loaded."""
    from skiros_py.motion.base_paths import BasePaths

    return BasePaths()


def _is_arm(device: DeviceSpec[object, object]) -> bool:
    return isinstance(device, ArmSpec)


def _arm_planner(request: Request) -> object:
    return WorkerPlanner("motion", partial(arm_motion, request.groups[0]))


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


def _analytic_kinematics(request: Request) -> object:
    """Returns inverse kinematics in closed form; the numeric one for an arm for which there is no such form."""
    from skiros_py.motion.pinocchio.analytic import analytic_kinematics
    from skiros_py.motion.pinocchio.arm_model import arm_model
    from skiros_py.motion.pinocchio.kinematics import IkSolver

    assert isinstance(request.device, ArmSpec)
    arm = arm_model(request.groups[0], request.device)
    numeric = IkSolver(arm)
    return analytic_kinematics(arm.chain, numeric, user_cache_path("skiros-py") / "arms") or numeric


def _rrt_connect(request: Request) -> object:
    """Returns RRT-Connect of roboplan; in Python where that is not installed."""
    from skiros_py.motion.sampling import RrtConnect

    if find_spec("roboplan") is None:
        return RrtConnect()
    from skiros_py.motion.pinocchio.roboplan import RoboplanRrt

    assert isinstance(request.device, ArmSpec)
    return RoboplanRrt(request.groups[0], request.device)


def _python_planner(name: str) -> Callable[[Request], object]:
    def make(_request: Request) -> object:
        from skiros_py.motion import sampling

        return getattr(sampling, name)()

    return make


ARM_PLANNER = Adapter((ArmPlanner, SceneMapper, ReachChecker), _arm_planner, serves=_is_arm, one_for="robot")
BASE_PLANNER = Adapter(
    (BasePlanner,),
    lambda _request: WorkerPlanner("base paths", base_paths),
    lambda device: isinstance(device, MobileSpec),
)
KINEMATICS = Adapter((Kinematics, Dynamics), _kinematics, one_for="robot", eager=False, without_physics=True)
ANALYTIC_KINEMATICS = Adapter(
    (InverseKinematics,),
    _analytic_kinematics,
    serves=lambda device: _is_arm(device) and find_spec("ssik") is not None,
    one_for="device",
    eager=False,
    by_name=True,  # what a robot does never depends on what happens to be installed
)
INVERSE_KINEMATICS = Adapter((InverseKinematics,), _inverse_kinematics, serves=_is_arm, one_for="device", eager=False)
RRT_CONNECT = Adapter((SamplingPlanner,), _rrt_connect, serves=_is_arm, one_for="device", eager=False)
PRM, EST = (
    Adapter((SamplingPlanner,), _python_planner(name), serves=_is_arm, one_for="device", eager=False, by_name=True)
    for name in ("Prm", "Est")
)
