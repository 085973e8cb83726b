"""What every planner of arm motions and base paths, and the kinematics of every robot, must do."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Any, ClassVar

import numpy as np
import pytest
import shapely

from skiros_py.devices.arm import ArmSpec
from skiros_py.errors import SkirosError, UnknownName
from skiros_py.geometry import Array, Pose, Solid, wrap_angle
from skiros_py.ports.adapters import InstalledPorts
from skiros_py.ports.cell import RobotSpec
from skiros_py.ports.kinematics import Kinematics
from skiros_py.ports.motion import (
    ArmPlanner,
    BasePathRequest,
    BasePlanner,
    JointMove,
    LineMove,
    MotionPlan,
    MotionRequest,
    NoMotion,
    Obstacle,
    PoseMove,
    Route,
)
from skiros_py.ports.paths import Layer, Path
from skiros_py.testing.conformance.cells import small_cell
from skiros_py.testing.conformance.pending import check_pending

# ruff: noqa: D102 - the names of tests say what they claim


class _OfRobot:
    def robot(self) -> RobotSpec:
        """Returns the robot; override it for one of another kind."""
        return small_cell(cameras=False).robots[0]

    @property
    def _arm(self) -> ArmSpec:
        return self.robot().of(ArmSpec)[0]


class ArmPlannerContract(_OfRobot, ABC):
    """Claims about an :class:`~skiros_py.ports.motion.ArmPlanner`; one planner serves all tests of the class.

    The robot's first arm must be able to move each joint by 0.2 rad from home, and its tip by 4 cm, in free space.

    Class attributes:
        period: Time between two set-points [s].
        reach_tolerance: How well a tip's pose is reached [m].
        turn_tolerance: How well its direction is reached [rad].
        line_tolerance: How far a tip may leave its straight line [m].
    """

    period: ClassVar[float] = 1.0 / 200.0
    reach_tolerance: ClassVar[float] = 0.002
    turn_tolerance: ClassVar[float] = 0.01
    line_tolerance: ClassVar[float] = 0.003

    @abstractmethod
    def make(self, robot: RobotSpec) -> ArmPlanner:
        """Returns the planner for a robot; it is closed by its ``close``, where it has one."""

    @pytest.fixture(scope="class")
    @classmethod
    def planner(cls) -> Iterator[ArmPlanner]:
        """One planner for all tests: models take seconds to load."""
        planner = cls().make(cls().robot())
        yield planner
        getattr(planner, "close", lambda: None)()

    def test_an_arm_that_is_not_there_is_refused(self, planner: ArmPlanner) -> None:
        with pytest.raises(SkirosError, match="unknown_arm"):
            planner.plan(replace(self._request((JointMove(self._near),)), device="unknown_arm")).result()

    # ------------------------------------------------------------------ motions

    def test_a_joint_move_goes_from_rest_to_rest_between_its_ends(self, planner: ArmPlanner) -> None:
        (leg,) = self._planned(planner, (JointMove(self._near),)).legs

        assert leg.positions[0] == pytest.approx(self._arm.home, abs=1e-6)
        assert leg.positions[-1] == pytest.approx(self._near, abs=1e-3)
        assert leg.velocities[[0, -1]] == pytest.approx(np.zeros((2, len(self._near))), abs=1e-3)

    def test_speeds_are_those_of_the_positions(self, planner: ArmPlanner) -> None:
        (leg,) = self._planned(planner, (JointMove(self._near),)).legs
        slopes = np.gradient(leg.positions, self.period, axis=0)

        assert leg.positions.shape == leg.velocities.shape
        assert np.abs(slopes - leg.velocities)[1:-1].max() <= 0.1 * max(1.0, np.abs(slopes).max())

    def test_a_pose_move_brings_the_tip_to_the_pose_wherever_the_base_stands(self, planner: ArmPlanner) -> None:
        base = Pose.of(2.0, -1.0, 0.0, yaw=2.0)
        wanted = base @ self._tip(self._near)
        request = replace(self._request((PoseMove(wanted),)), base=base)

        plan = self._done(planner, request)

        self._assert_at(base @ self._tip(plan.legs[-1].positions[-1]), wanted)

    def test_a_line_move_keeps_the_tip_on_its_line_within_its_speed(self, planner: ArmPlanner) -> None:
        start = self._tip(self._arm.home)
        wanted = Pose((*start.position[:2], start.position[2] - 0.04), start.orientation)
        (leg,) = self._planned(planner, (LineMove(wanted, speed=0.05),)).legs

        tips = [self._tip(row).position for row in leg.positions[::10]]
        steps = [math.dist(a, b) for a, b in pairwise(tips)]

        assert max(math.dist(tip[:2], start.position[:2]) for tip in tips) <= self.line_tolerance
        assert max(steps) <= 0.05 * 10 * self.period * 1.1
        self._assert_at(self._tip(leg.positions[-1]), wanted)

    def test_each_move_of_a_route_has_a_leg_that_begins_where_the_last_one_ended(self, planner: ArmPlanner) -> None:
        route = (JointMove(self._near), PoseMove(self._tip(self._arm.home)), JointMove(self._near))

        legs = self._planned(planner, route).legs

        assert len(legs) == len(route)
        for before, after in pairwise(legs):
            assert after.positions[0] == pytest.approx(before.positions[-1], abs=1e-6)

    def test_half_the_speed_takes_longer(self, planner: ArmPlanner) -> None:
        request = self._request((JointMove(self._near),))

        fast, slow = self._done(planner, request), self._done(planner, replace(request, speed=0.3))

        assert len(slow.legs[0].positions) > len(fast.legs[0].positions)

    def test_the_same_request_has_the_same_answer(self, planner: ArmPlanner) -> None:
        request = self._request((PoseMove(self._tip(self._near)),))

        one, other = self._done(planner, request), self._done(planner, request)

        assert np.array_equal(one.legs[0].positions, other.legs[0].positions)

    def test_a_motion_stays_above_what_it_says_it_covers_of_the_floor(self, planner: ArmPlanner) -> None:
        """With another robot about: its way must not lead through an arm."""
        plan = self._planned(planner, (JointMove(self._near),))
        tips = [self._tip(row).position[:2] for row in plan.legs[0].positions]

        assert _all_inside(tips, plan.covers)
        assert _all_inside(tips[-1:], plan.ends)
        assert _all_inside(plan.ends, plan.covers)

    # ------------------------------------------------------------------ what is not possible

    def test_a_pose_out_of_reach_has_a_reason_instead_of_a_motion(self, planner: ArmPlanner) -> None:
        answer = planner.plan(self._request((PoseMove(Pose((50.0, 0.0, 0.0))),))).result()

        assert isinstance(answer, NoMotion)
        assert answer.reason

    def test_nothing_is_planned_into_an_obstacle(self, planner: ArmPlanner) -> None:
        tip = self._tip(self._near)
        block = Obstacle("block", Solid.box(0.1, 0.1, 0.1), Pose(tip.position) @ Pose((0.0, 0.0, -0.05)))

        answer = planner.plan(replace(self._request((JointMove(self._near),)), obstacles=(block,))).result()

        assert isinstance(answer, NoMotion)

    def test_of_several_routes_a_feasible_one_is_taken(self, planner: ArmPlanner) -> None:
        request = self._request((PoseMove(Pose((50.0, 0.0, 0.0))),), (JointMove(self._near),))

        assert self._done(planner, request).route == 1

    # ------------------------------------------------------------------ requests

    @property
    def _near(self) -> tuple[float, ...]:
        return tuple(angle + 0.2 for angle in self._arm.home)

    def _request(self, *routes: Route) -> MotionRequest:
        return MotionRequest(self._arm.id, self._arm.home, Pose(), routes)

    def _planned(self, planner: ArmPlanner, route: Route) -> MotionPlan:
        return self._done(planner, self._request(route))

    def _done(self, planner: ArmPlanner, request: MotionRequest) -> MotionPlan:
        answer = check_pending(planner.plan(request))
        assert isinstance(answer, MotionPlan), answer
        return answer

    def _tip(self, positions: tuple[float, ...] | Array) -> Pose:
        kinematics = InstalledPorts((self.robot(),)).port(Kinematics, self._arm.id)
        return kinematics.pose(self._arm.tip, dict(zip(self._arm.joints, map(float, positions), strict=True)))

    def _assert_at(self, tip: Pose, wanted: Pose) -> None:
        turn: Any = (tip.inverse() @ wanted).orientation
        assert tip.distance(wanted) <= self.reach_tolerance
        assert 2.0 * math.acos(min(1.0, abs(turn[3]))) <= self.turn_tolerance


def _all_inside(points: Sequence[tuple[float, float]], outline: Sequence[tuple[float, float]]) -> bool:
    hull = shapely.buffer(shapely.MultiPoint(list(outline)).convex_hull, 1e-6)
    return bool(shapely.covers(hull, shapely.MultiPoint(list(points))))


_OUTLINE = ((-0.40, -0.25), (0.30, -0.25), (0.30, 0.25), (-0.40, 0.25))
_START = Pose()
_GOAL = Pose.of(4.0, 1.0, 0.0, yaw=0.5)


class BasePlannerContract(ABC):
    """Claims about a :class:`~skiros_py.ports.motion.BasePlanner`; one planner serves all tests of the class.

    Class attributes:
        goal_tolerance: How near to its goal a path ends [m].
    """

    goal_tolerance: ClassVar[float] = 0.01

    @abstractmethod
    def make(self) -> BasePlanner:
        """Returns the planner; it is closed by its ``close``, where it has one."""

    @pytest.fixture(scope="class")
    @classmethod
    def planner(cls) -> Iterator[BasePlanner]:
        """One planner for all tests."""
        planner = cls().make()
        yield planner
        getattr(planner, "close", lambda: None)()

    def test_a_path_leads_from_the_start_to_the_goal(self, planner: BasePlanner) -> None:
        self._assert_good(self._path(planner, _START, _GOAL), _START, _GOAL)

    def test_the_last_stretch_is_driven_straight_ahead_into_the_goal(self, planner: BasePlanner) -> None:
        *_, before, last = _poses(self._path(planner, _START, _GOAL))

        assert wrap_angle(before.yaw - _GOAL.yaw) == pytest.approx(0.0, abs=0.02)
        assert wrap_angle(last.yaw - _GOAL.yaw) == pytest.approx(0.0, abs=0.02)

    def test_who_is_there_already_does_not_drive(self, planner: BasePlanner) -> None:
        path = self._path(planner, _GOAL, _GOAL)

        assert path.legs == ()
        *_, (_, last) = path.poses(_GOAL)
        assert wrap_angle(last.yaw - _GOAL.yaw) == pytest.approx(0.0, abs=0.02)

    def test_nothing_on_the_way_is_touched(self, planner: BasePlanner) -> None:
        wall = _block("wall", 2.0, 0.5, 0.3, 1.5)

        path = self._path(planner, _START, _GOAL, wall)

        self._assert_good(path, _START, _GOAL)
        assert max(_overlap(pose, wall) for pose in _poses(path)) == 0.0

    def test_out_of_a_narrow_dock_it_leaves_without_turning_in_it(self, planner: BasePlanner) -> None:
        dock = [_block("left", 0.3, 0.5, 1.4, 0.2), _block("right", 0.3, -0.5, 1.4, 0.2), _block("end", 0.9, 0, 0.1, 1)]
        goal = Pose.of(-3.0, 0.0, 0.0, yaw=math.pi)

        path = self._path(planner, _START, goal, *dock)

        self._assert_good(path, _START, goal)
        assert max(_overlap(pose, block) for pose in _poses(path) for block in dock) == 0.0

    def test_a_goal_inside_an_obstacle_has_a_reason_that_names_it(self, planner: BasePlanner) -> None:
        answer = self._answer(planner, _START, _GOAL, _block("cupboard", 4.0, 1.0, 0.5, 0.5))

        assert isinstance(answer, NoMotion)
        assert "cupboard" in answer.reason

    def test_where_there_is_no_way_it_says_so(self, planner: BasePlanner) -> None:
        sides = [(4.0, -1.0, 5.0, 0.2), (4.0, 3.0, 5.0, 0.2), (2.0, 1.0, 0.2, 5.0), (6.0, 1.0, 0.2, 5.0)]
        room = [_block(f"wall_{n}", *side) for n, side in enumerate(sides)]

        answer = self._answer(planner, _START, _GOAL, *room)

        assert isinstance(answer, NoMotion)
        assert answer.reason

    def test_the_same_request_has_the_same_answer(self, planner: BasePlanner) -> None:
        wall = _block("wall", 2.0, 0.5, 0.3, 1.5)

        assert self._path(planner, _START, _GOAL, wall) == self._path(planner, _START, _GOAL, wall)

    # ------------------------------------------------------------------ requests

    def _answer(self, planner: BasePlanner, start: Pose, goal: Pose, *obstacles: Obstacle) -> Path | NoMotion:
        return check_pending(planner.plan(BasePathRequest(start, goal, (Layer(_OUTLINE),), obstacles)))

    def _path(self, planner: BasePlanner, start: Pose, goal: Pose, *obstacles: Obstacle) -> Path:
        answer = self._answer(planner, start, goal, *obstacles)
        assert not isinstance(answer, NoMotion), answer
        return answer

    def _assert_good(self, path: Path, start: Pose, goal: Pose) -> None:
        *_, (_, last) = path.poses(start)
        assert last.distance(goal) <= self.goal_tolerance
        assert wrap_angle(last.yaw - goal.yaw) == pytest.approx(0.0, abs=0.02)


def _poses(path: Path) -> list[Pose]:
    """Returns the poses of a path from the start, in small steps."""
    return [pose for _, pose in path.poses(_START, way=0.02, turn=0.05)]


def _block(name: str, x: float, y: float, length: float, width: float) -> Obstacle:
    return Obstacle(name, Solid.box(length, width, 1.0), Pose.of(x, y, 0.0))


def _overlap(pose: Pose, block: Obstacle) -> float:
    """Returns the area that the base at a pose shares with a block [m²]."""
    base = shapely.Polygon([pose.apply(np.array((x, y, 0.0)))[:2] for x, y in _OUTLINE])
    (primitive,) = block.solid.primitives
    x, y, half = block.pose.position[0], block.pose.position[1], [size / 2.0 for size in primitive.size]
    return float(base.intersection(shapely.box(x - half[0], y - half[1], x + half[0], y + half[1])).area)


_STEP = 1e-6


class KinematicsContract(_OfRobot, ABC):
    """Claims about :class:`~skiros_py.ports.kinematics.Kinematics`, for a robot with an arm."""

    @abstractmethod
    def make(self, robot: RobotSpec) -> Kinematics:
        """Returns the kinematics of a robot."""

    @pytest.fixture
    def kinematics(self) -> Kinematics:
        """The kinematics of the robot."""
        return self.make(self.robot())

    def test_each_link_has_one_pose_whichever_way_it_is_asked_for(self, kinematics: Kinematics) -> None:
        poses = kinematics.poses(self._home)

        assert poses.keys() == kinematics.parents.keys()
        assert all(kinematics.pose(link, self._home) == pose for link, pose in poses.items())

    def test_the_tip_moves_with_the_joints_and_comes_back(self, kinematics: Kinematics) -> None:
        home = kinematics.pose(self._arm.tip, self._home)
        moved = kinematics.pose(self._arm.tip, {joint: angle + 0.2 for joint, angle in self._home.items()})

        assert home.distance(moved) > 0.001
        assert kinematics.pose(self._arm.tip, self._home) == home

    def test_parents_come_before_their_children(self, kinematics: Kinematics) -> None:
        seen = set(kinematics.parents.values()) - kinematics.parents.keys()
        for link, parent in kinematics.parents.items():
            assert parent in seen
            seen.add(link)

    def test_the_home_posture_is_within_the_ranges_of_the_joints(self, kinematics: Kinematics) -> None:
        for joint, angle in self._home.items():
            limits = kinematics.joints[joint]
            assert limits.lower is None or limits.lower <= angle
            assert limits.upper is None or angle <= limits.upper

    def test_the_jacobian_is_the_rate_at_which_the_tip_moves(self, kinematics: Kinematics) -> None:
        jacobian = kinematics.jacobian(self._arm.tip, self._home, self._arm.joints)
        here = kinematics.pose(self._arm.tip, self._home).inverse()

        assert jacobian.shape == (6, len(self._arm.joints))
        for column, joint in zip(jacobian.T, self._arm.joints, strict=True):
            step = here @ kinematics.pose(self._arm.tip, self._home | {joint: self._home[joint] + _STEP})
            turn = 2.0 * np.array(step.orientation[:3]) * np.sign(step.orientation[3])
            assert np.array([*step.position, *turn]) / _STEP == pytest.approx(column, abs=1e-4)

    def test_a_link_or_joint_that_is_not_there_is_refused(self, kinematics: Kinematics) -> None:
        with pytest.raises(UnknownName, match="unknown_link"):
            kinematics.pose("unknown_link", self._home)
        with pytest.raises(UnknownName, match="unknown_joint"):
            kinematics.jacobian(self._arm.tip, self._home, ("unknown_joint",))

    @property
    def _home(self) -> dict[str, float]:
        return dict(zip(self._arm.joints, self._arm.home, strict=True))
