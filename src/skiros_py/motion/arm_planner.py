"""The arm motion planner as a port: it plans in a process of its own."""

from __future__ import annotations

from skiros_py.geometry import Pose
from skiros_py.robot.cell import RobotSpec
from skiros_py.robot.motion import MotionPlan, MotionRequest, NoMotion
from skiros_py.robot.pending import Pending
from skiros_py.workers import Worker

__all__ = ["WorkerArmPlanner"]

_PLAN_LATENCY = 0.05


class WorkerArmPlanner:
    """Plans the motions of one robot's arms in a worker process; a :class:`skiros_py.robot.motion.ArmPlanner`.

    Args:
        spec: The robot.
        latency: Declared time from request to plan [s]; in lockstep the simulation goes on for as long.
    """

    def __init__(self, spec: RobotSpec, *, latency: float = _PLAN_LATENCY) -> None:
        self._worker = Worker("motion", _Factory(spec))
        self._latency = latency

    def plan(self, request: MotionRequest) -> Pending[MotionPlan | NoMotion]:
        """Plans one request."""
        return self._worker.call("plan", request, latency=self._latency)

    def frame_pose(self, arm: str, positions: tuple[float, ...], frame: str) -> Pending[Pose]:
        """Returns the pose of a URDF link in the robot's base frame at the given joint angles [rad]."""
        return self._worker.call("frame_pose", arm, positions, frame)

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
        from skiros_py.motion.pinocchio.arm_motion import ArmMotion  # heavy, and not wanted in the calling process

        return ArmMotion(self._spec)
