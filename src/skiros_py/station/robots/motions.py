"""The planned motions of the robots, for display: the answers of planners until executed or abandoned."""

from __future__ import annotations

import math
import threading
from collections import Counter, deque
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from skiros_py.api.robots import ArmWay, RobotMotion, Waypoint
from skiros_py.devices.arm import ArmSpec, ArmState
from skiros_py.errors import SkirosError
from skiros_py.execution.runtime import LibraryCall
from skiros_py.execution.task import Task
from skiros_py.geometry import Pose, wrap_angle
from skiros_py.ports.board import Commander, DeviceBoard
from skiros_py.ports.cell import RobotSpec
from skiros_py.ports.kinematics import Kinematics
from skiros_py.ports.motion import BasePathRequest, MotionPlan, MotionRequest, NoMotion
from skiros_py.ports.paths import Path
from skiros_py.ports.values import Snapshot
from skiros_py.station.session import Session

MOST_POINTS = 60
"""Number of points on the path of one arm."""
_KEPT = 8
"""Number of plans kept that were not processed yet."""
_THERE, _FACING, _BENT = 0.04, math.radians(3.0), 0.02
"""Tolerances at the end of the path, of a base [m, rad] and of an arm's joints [rad]."""


@dataclass(frozen=True, slots=True, eq=False)
class _Way:
    """A plan for one device.

    Attributes:
        robot: The robot.
        device: Id of the base or arm.
        call: The request and its answer.
        asker: The module that requested it; None if unknown.
        time: Time of the request [s, run time].
    """

    robot: RobotSpec
    device: str
    call: LibraryCall
    asker: Commander | None
    time: float

    def is_over(self, board: DeviceBoard) -> bool:
        """Returns whether the device has reached the end, or the requesting module has abandoned the plan."""
        if isinstance(self.asker, Task) and self.asker.done:
            return True
        answer = self.call.answer.result()
        if not isinstance(answer, MotionPlan):
            return _base_arrived(self.robot, board, self.call.request)
        samples = sum(len(leg.positions) for leg in answer.legs)
        if board.snapshot.time < self.time + samples * board.period:  # a pose on the way may equal that at the end
            return False
        return _arm_arrived(board.snapshot, self.device, answer)


class Motions:
    """The planned motions of each robot; thread-safe.

    Nothing is computed in the control thread, which only records the plans.
    """

    def __init__(self) -> None:
        self._session: Session | None = None
        self._lock = threading.Lock()
        self._asked: dict[str, deque[_Way]] = {}
        self._ways: dict[str, dict[str, _Way]] = {}
        self._robots: dict[str, RobotSpec] = {}
        self._counts: Counter[str] = Counter()
        self._leave: Callable[[], None] = lambda: None

    def open(self, session: Session) -> None:
        """Records the plans of a session."""
        robots = session.spec.robots
        with self._lock:
            self._asked = {robot.id: deque(maxlen=_KEPT) for robot in robots}
            self._ways = {robot.id: {} for robot in robots}
            self._robots = {device.id: robot for robot in robots for device in robot.devices}
            self._session = session
        self._leave = session.runtime.asked.subscribe(self._note)

    def close(self, _session: Session) -> None:
        """Stops recording, and drops the plans of the session."""
        self._leave()
        with self._lock:
            self._session, self._asked, self._ways = None, {}, {}

    def numbers(self) -> dict[str, int]:
        """Returns for each robot a number that changes with its planned motion."""
        with self._lock:
            if self._session is None:
                return {}
            for robot in self._ways:
                self._look(self._session, robot)
            return {robot: self._counts[robot] for robot in self._ways}

    def motion(self, robot: RobotSpec) -> RobotMotion:
        """Returns the planned motion of a robot."""
        with self._lock:
            if self._session is not None and robot.id in self._ways:
                self._look(self._session, robot.id)
            ways, number = tuple(self._ways.get(robot.id, {}).values()), self._counts[robot.id]
        base: tuple[Waypoint, ...] = ()
        arms: list[ArmWay] = []
        for way in ways:
            request, answer = way.call.request, way.call.answer.result()
            if isinstance(request, BasePathRequest):
                base = _waypoints(request.start, answer)
            elif isinstance(request, MotionRequest):
                arms.append(ArmWay(arm=way.device, points=self._tips(request, answer)))
        return RobotMotion(number=number, base=base, arms=tuple(arms))

    def _tips(self, request: MotionRequest, plan: MotionPlan) -> tuple[tuple[float, float, float], ...]:
        """Returns the positions of an arm's tip along its path, in the map [m]; none without kinematics."""
        rows = [row for leg in plan.legs for row in leg.positions.tolist()]
        if self._session is None or not rows:
            return ()
        arm = self._session.spec.device(request.arm, ArmSpec)
        kinematics = self._session.runtime.context.ports.find(Kinematics, arm.id)
        if kinematics is None:
            return ()
        postures = [dict(zip(arm.joints, rows[index], strict=True)) for index in _spread(len(rows))]
        return tuple((request.base @ kinematics.pose(arm.tip, posture)).position for posture in postures)

    def _note(self, call: LibraryCall) -> None:
        """Records a request; called in the control thread."""
        request, session = call.request, self._session
        if session is None or not isinstance(request, BasePathRequest | MotionRequest):
            return
        device = request.base if isinstance(request, BasePathRequest) else request.arm
        board = session.cycle.board
        with self._lock:  # never held for long
            if (robot := self._robots.get(device)) is not None:
                self._asked[robot.id].append(_Way(robot, device, call, board.owner, board.now))

    def _look(self, session: Session, robot: str) -> None:
        """Adopts new answers, and drops finished plans; the caller holds the lock."""
        asked, ways = self._asked[robot], self._ways[robot]
        board = session.cycle.board
        while asked and asked[0].call.answer.done():
            way = asked.popleft()
            if _is_plan(way.call):
                ways[way.device] = way
                self._counts[robot] += 1
        for way in tuple(ways.values()):
            if way.is_over(board):
                del ways[way.device]
                self._counts[robot] += 1


def _is_plan(call: LibraryCall) -> bool:
    try:
        return not isinstance(call.answer.result(), NoMotion)
    except SkirosError:  # reported by the caller of the request
        return False


def _base_arrived(robot: RobotSpec, board: DeviceBoard, request: object) -> bool:
    assert isinstance(request, BasePathRequest)
    pose, goal = robot.pose(board.snapshot, board.guard), request.goal
    away = math.dist(goal.position[:2], pose.position[:2])
    standing = robot.carrier is None or board.stand([robot.carrier.id])
    return standing and away < _THERE and abs(wrap_angle(goal.yaw - pose.yaw)) < _FACING


def _arm_arrived(snapshot: Snapshot, arm: str, plan: MotionPlan) -> bool:
    state = snapshot.state(arm, ArmState)
    if not (plan.legs and state.still):
        return state.still
    last = plan.legs[-1].positions[-1]
    return bool(np.abs(np.asarray(state.positions) - last).max() < _BENT)


def _waypoints(start: Pose, path: Path) -> tuple[Waypoint, ...]:
    """Returns the start of a base path, the end of each leg, and the final heading."""
    ends: dict[float, Pose] = {}
    for driven, pose in path.poses(start):
        ends.setdefault(driven, pose)
    shown = [*(end for driven, end in ends.items() if driven.is_integer()), pose]
    return tuple(Waypoint(x=one.position[0], y=one.position[1], heading=one.yaw) for one in shown)


def _spread(count: int) -> list[int]:
    """Returns the indices to take of a number of points: the first, the last, and evenly spaced ones between."""
    most = min(count, MOST_POINTS)
    return sorted({round(index * (count - 1) / max(1, most - 1)) for index in range(most)})
