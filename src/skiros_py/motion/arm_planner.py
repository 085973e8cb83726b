"""The arm motion planner as a port: it plans in a worker process, one for each robot."""

from __future__ import annotations

from skiros_py.ports.cell import RobotSpec
from skiros_py.ports.motion import MotionPlan, MotionRequest, NoMotion
from skiros_py.ports.pending import Pending
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
