"""Motions of an arm keep away from what a camera has seen and nothing explains, also those that are under way."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from skiros_py.geometry import Array, Pose, Solid
from skiros_py.motion.adapters import WorkerPlanner
from skiros_py.motion.pinocchio.arm_model import arm_model
from skiros_py.motion.pinocchio.arm_motion import ArmMotion
from skiros_py.motion.pinocchio.collision import SEEN, CollisionScene
from skiros_py.ports.cell import RobotSpec
from skiros_py.ports.motion import DepthView, MotionCheck, MotionPlan, MotionRequest, NoMotion, Obstacle, PoseMove
from skiros_py.ports.values import CameraIntrinsics

POST = Obstacle("post", Solid.box(0.06, 0.06, 0.35), Pose((0.62, 0.0, 0.5)))
WIDE = Obstacle("table", Solid.box(3.0, 3.0, 0.5), Pose())
CAMERA = CameraIntrinsics(160, 120, 113.0, 113.0, 79.5, 59.5, 0.05, 2.0)
HIGH = 1.2


def picture(*, shows: bool = True) -> DepthView:
    """Returns what a camera above a table sees, with the post or without."""
    v, u = np.mgrid[0 : CAMERA.height, 0 : CAMERA.width]
    away = HIGH - 0.85
    on = np.maximum(np.abs(u - CAMERA.cx) / CAMERA.fx, np.abs(v - CAMERA.cy) / CAMERA.fy) * away < 0.03
    depth = np.where(on & shows, away, HIGH - 0.5).astype(np.float32)
    return DepthView("arm", depth, CAMERA, Pose.of(0.62, 0.0, HIGH, roll=math.pi), 0.0, (WIDE,))


START = (-1.78, -0.21, -0.34, -2.36, -0.08, 2.17, 0.29)
"""Where the tip is 0.25 m beside the post, below its top [rad]."""


@pytest.fixture
def across(bench: SimpleNamespace) -> MotionRequest:
    """From one side of the post to the other, below its top."""
    route = (PoseMove(bench.down(0.62, 0.25, 0.70, 0.0)),)
    return MotionRequest("arm", START, Pose(), (route,), (bench.table(0.5),))


@pytest.fixture
def touches(robot: RobotSpec) -> Callable[[Array], bool]:
    arm = arm_model(robot, robot.devices[1])  # type: ignore[arg-type]
    checker = CollisionScene(arm, (), Pose(), (POST,), None, 0.08).checker(0.0)
    return lambda positions: not all(map(checker.clear, positions))


def test_an_arm_moves_around_what_was_seen(
    robot: RobotSpec, across: MotionRequest, touches: Callable[[Array], bool]
) -> None:
    motion = ArmMotion(robot)

    before = motion.plan(across)
    seen = motion.see(picture())
    after = motion.plan(across)

    assert isinstance(before, MotionPlan)
    assert isinstance(after, MotionPlan)
    assert touches(before.legs[0].positions)
    assert not touches(after.legs[0].positions)
    assert [one.pose.position[:2] for one in seen] == [pytest.approx((0.62, 0.0), abs=0.02)]


def test_what_was_seen_is_named_where_an_arm_cannot_get_past(robot: RobotSpec, bench: SimpleNamespace) -> None:
    motion = ArmMotion(robot)
    into = MotionRequest("arm", bench.HOME, Pose(), ((PoseMove(bench.down(0.62, 0.0, 0.7, 0.0)),),))
    assert isinstance(motion.plan(into), MotionPlan)

    motion.see(picture())
    refused = motion.plan(into)

    assert isinstance(refused, NoMotion)
    assert SEEN in refused.reason
    assert refused.values == {"cause": "collision", "bodies": [SEEN]}


@pytest.mark.parametrize(("beside", "share"), [(0.10, 1.0), (0.085, 0.5), (0.07, None)])
def test_an_arm_comes_nearer_to_what_was_seen_only_where_there_is_no_other_way(
    robot: RobotSpec, bench: SimpleNamespace, beside: float, share: float | None
) -> None:
    motion = ArmMotion(robot)
    motion.see(picture())

    down = bench.down(0.62, beside, 0.66, math.pi / 2.0)
    planned = motion.plan(MotionRequest("arm", bench.HOME, Pose(), ((PoseMove(down),),)))

    assert (planned.share if isinstance(planned, MotionPlan) else None) == share


def test_the_rest_of_a_motion_is_blocked_by_what_is_seen_in_it(
    robot: RobotSpec, bench: SimpleNamespace, across: MotionRequest
) -> None:
    motion = ArmMotion(robot)
    up = replace(across, routes=((PoseMove(bench.down(0.62, -0.25, 0.8, 0.0)),),))
    plans = [plan for plan in map(motion.plan, (across, up)) if isinstance(plan, MotionPlan)]
    past, beside = (MotionCheck("arm", Pose(), plan.legs[0].positions, None, 0.08) for plan in plans)

    motion.see(picture(shows=False))
    free = motion.blocked(past)
    motion.see(picture())
    aside, blocked = motion.blocked(beside), motion.blocked(past)

    assert free is None
    assert aside is None
    assert isinstance(blocked, NoMotion)
    assert SEEN in blocked.reason


def test_an_arm_that_stands_where_something_was_seen_may_leave(
    robot: RobotSpec, bench: SimpleNamespace, across: MotionRequest
) -> None:
    motion = ArmMotion(robot)
    planned = motion.plan(across)
    assert isinstance(planned, MotionPlan)
    middle = planned.legs[0].positions[len(planned.legs[0].positions) // 2]
    motion.see(picture())

    away = MotionRequest("arm", tuple(middle.tolist()), Pose(), ((PoseMove(bench.down(0.62, 0.0, 1.0, 0.0)),),))

    assert isinstance(motion.plan(away), MotionPlan)


def test_pictures_are_shown_to_the_planner_in_its_worker(robot: RobotSpec, bench: SimpleNamespace) -> None:
    worker = WorkerPlanner("motion", lambda: ArmMotion(robot), latency=0.07)
    into = MotionRequest("arm", bench.HOME, Pose(), ((PoseMove(bench.down(0.62, 0.0, 0.7, 0.0)),),))
    try:
        seen = worker.see(picture())
        refused = worker.plan(into).result()
        still = np.array([bench.HOME])
        rest = worker.blocked(MotionCheck("arm", Pose(), still, None, 0.08))

        assert (seen.latency, rest.latency) == (0.07, 0.07)
        assert len(seen.result()) == 1
        assert isinstance(refused, NoMotion)
        assert rest.result() is None
    finally:
        worker.close()
