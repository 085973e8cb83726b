"""The arm motion planner as a port: it plans in a process of its own, one for each robot."""

from __future__ import annotations

from collections.abc import Sequence

from skiros_py.devices.arm import ArmSpec
from skiros_py.errors import DeviceError
from skiros_py.geometry import Pose
from skiros_py.ports.cell import RobotSpec
from skiros_py.ports.motion import MotionPlan, MotionRequest, NoMotion
from skiros_py.ports.pending import Pending
from skiros_py.workers import Worker

_PLAN_LATENCY = 0.05


class WorkerArmPlanner:
    """Plans the motions of one robot's arms in a worker process; a :class:`skiros_py.ports.motion.ArmPlanner`.

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


class ArmPlanners:
    """Plans the motions of the arms of several robots; a :class:`skiros_py.ports.motion.ArmPlanner`.

    Each robot has a worker process of its own, so that no robot waits for the plans of another.

    Args:
        robots: The robots.
    """

    def __init__(self, robots: Sequence[RobotSpec]) -> None:
        self._planners = [WorkerArmPlanner(robot) for robot in robots]
        self._of_arm = {
            arm.id: planner for robot, planner in zip(robots, self._planners, strict=True) for arm in robot.of(ArmSpec)
        }

    def plan(self, request: MotionRequest) -> Pending[MotionPlan | NoMotion]:
        """Plans one request.

        Raises:
            DeviceError: No robot has the arm.
        """
        return self._planner(request.arm).plan(request)

    def frame_pose(self, arm: str, positions: tuple[float, ...], frame: str) -> Pending[Pose]:
        """Returns the pose of a URDF link in the base frame of the arm's robot at the given joint angles [rad].

        Raises:
            DeviceError: No robot has the arm.
        """
        return self._planner(arm).frame_pose(arm, positions, frame)

    def wait_ready(self) -> None:
        """Waits until all models are loaded.

        Raises:
            DeviceError: They could not be loaded.
        """
        for planner in self._planners:
            planner.wait_ready()

    def close(self) -> None:
        """Ends the worker processes."""
        for planner in self._planners:
            planner.close()

    def _planner(self, arm: str) -> WorkerArmPlanner:
        if arm not in self._of_arm:
            raise DeviceError(f"no robot has an arm '{arm}'; there is {', '.join(self._of_arm) or 'none'}")
        return self._of_arm[arm]


class _Factory:
    """Builds the planner inside the worker, where Pinocchio is loaded."""

    def __init__(self, spec: RobotSpec) -> None:
        self._spec = spec

    def __call__(self) -> object:
        from skiros_py.motion.pinocchio.arm_motion import ArmMotion  # heavy, and not wanted in the calling process

        return ArmMotion(self._spec)
