"""What every planner of base paths must do."""

# ruff: noqa: D102 - the names of tests say what they claim

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Iterator
from typing import ClassVar

import numpy as np
import pytest
import shapely

from skiros_py.geometry import Pose, Solid, wrap_angle
from skiros_py.ports.motion import BasePath, BasePathRequest, BasePlanner, NoMotion, Obstacle
from skiros_py.testing.conformance.pending import check_pending

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
        *_, before, last = _poses(self._path(planner, _START, _GOAL), _START)

        assert wrap_angle(before.yaw - _GOAL.yaw) == pytest.approx(0.0, abs=0.02)
        assert wrap_angle(last.yaw - _GOAL.yaw) == pytest.approx(0.0, abs=0.02)

    def test_who_is_there_already_does_not_drive(self, planner: BasePlanner) -> None:
        path = self._path(planner, _GOAL, _GOAL)

        assert path.legs == ()
        assert wrap_angle(path.heading - _GOAL.yaw) == pytest.approx(0.0, abs=0.02)

    def test_nothing_on_the_way_is_touched(self, planner: BasePlanner) -> None:
        wall = _block("wall", 2.0, 0.5, 0.3, 1.5)

        path = self._path(planner, _START, _GOAL, wall)

        self._assert_good(path, _START, _GOAL)
        assert max(_overlap(pose, wall) for pose in _poses(path, _START)) == 0.0

    def test_out_of_a_narrow_dock_it_leaves_without_turning_in_it(self, planner: BasePlanner) -> None:
        dock = [_block("left", 0.3, 0.5, 1.4, 0.2), _block("right", 0.3, -0.5, 1.4, 0.2), _block("end", 0.9, 0, 0.1, 1)]
        goal = Pose.of(-3.0, 0.0, 0.0, yaw=math.pi)

        path = self._path(planner, _START, goal, *dock)

        self._assert_good(path, _START, goal)
        assert max(_overlap(pose, block) for pose in _poses(path, _START) for block in dock) == 0.0

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

    def _answer(self, planner: BasePlanner, start: Pose, goal: Pose, *obstacles: Obstacle) -> BasePath | NoMotion:
        return check_pending(planner.plan(BasePathRequest(start, goal, _OUTLINE, obstacles)))

    def _path(self, planner: BasePlanner, start: Pose, goal: Pose, *obstacles: Obstacle) -> BasePath:
        answer = self._answer(planner, start, goal, *obstacles)
        assert isinstance(answer, BasePath), answer
        return answer

    def _assert_good(self, path: BasePath, start: Pose, goal: Pose) -> None:
        *_, last = _poses(path, start)
        assert last.distance(goal) <= self.goal_tolerance
        assert wrap_angle(last.yaw - goal.yaw) == pytest.approx(0.0, abs=0.02)


def _poses(path: BasePath, start: Pose) -> Iterator[Pose]:
    """Drives a path in small steps: turn, straight, ..., turn."""
    x, y, heading = start.position[0], start.position[1], start.yaw
    yield start
    for leg in path.legs:
        away = math.pi if leg.backwards else 0.0
        wanted = math.atan2(leg.y - y, leg.x - x) + away
        yield from (Pose.of(x, y, 0.0, yaw=yaw) for yaw in _turn(heading, wanted))
        for share in np.linspace(0.0, 1.0, 2 + int(math.dist((x, y), (leg.x, leg.y)) / 0.02)):
            yield Pose.of(x + share * (leg.x - x), y + share * (leg.y - y), 0.0, yaw=wanted)
        x, y, heading = leg.x, leg.y, wanted
    yield from (Pose.of(x, y, 0.0, yaw=yaw) for yaw in _turn(heading, path.heading))


def _turn(heading: float, wanted: float) -> Iterator[float]:
    turn = wrap_angle(wanted - heading)
    yield from (heading + float(share) * turn for share in np.linspace(0.0, 1.0, 2 + int(abs(turn) / 0.05)))


def _block(name: str, x: float, y: float, length: float, width: float) -> Obstacle:
    return Obstacle(name, Solid.box(length, width, 1.0), Pose.of(x, y, 0.0))


def _overlap(pose: Pose, block: Obstacle) -> float:
    """Returns the area that the base at a pose shares with a block [m²]."""
    base = shapely.Polygon([pose.apply(np.array((x, y, 0.0)))[:2] for x, y in _OUTLINE])
    (primitive,) = block.solid.primitives
    x, y, half = block.pose.position[0], block.pose.position[1], [size / 2.0 for size in primitive.size]
    return float(base.intersection(shapely.box(x - half[0], y - half[1], x + half[0], y + half[1])).area)
