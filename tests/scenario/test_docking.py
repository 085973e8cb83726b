"""A base docks relative to where its scanner sees a place; the belief about the place follows, and truth judges."""

from __future__ import annotations

import math
from collections.abc import Callable

import pytest

from skiros_py.geometry import Pose, wrap_angle
from skiros_py.simulation.truth import Truth
from skiros_py.skills.outcome import Failure
from skiros_py.station.session import Session
from skiros_py.world import vocabulary as v
from skiros_py.world.poses import map_pose

pytestmark = pytest.mark.physics

PLACE = "pallet_a"


def test_a_base_docks_at_a_place_that_is_not_where_it_was_declared_and_believes_where_it_is(
    open_session: Callable[..., Session],
) -> None:
    session = open_session("kitting", seed=1)
    truth = Truth(session.simulation)
    session.simulation.move_body(PLACE, truth.pose(PLACE) @ Pose.of(-0.07, 0.10, 0.0, yaw=0.05))

    report = session.run([f"RobotAtLocation(robot_1, {PLACE})"])

    assert report.reached
    place, base, believed = truth.pose(PLACE), truth.base_pose("base_1"), map_pose(session.world, PLACE)
    driving = session.world.value(PLACE, v.DRIVING_POSE)
    assert isinstance(driving, Pose)
    wanted = place @ driving
    assert math.dist(base.position[:2], wanted.position[:2]) <= 0.005
    assert abs(wrap_angle(base.yaw - wanted.yaw)) <= math.radians(0.5)
    assert believed is not None
    assert believed.distance(place) < 0.03  # what is left is the localiser's error


def test_a_base_that_drives_to_a_place_that_is_gone_says_so(open_session: Callable[..., Session]) -> None:
    session = open_session("kitting", seed=1)
    session.simulation.move_body(PLACE, Truth(session.simulation).pose(PLACE) @ Pose((0.0, 3.0, 0.0)))

    outcome = session.run_module("drive_base", {"base": "base_1", "robot": "robot_1", "location": PLACE}, "base_1")

    assert isinstance(outcome, Failure)
    assert outcome.values == {"not_seen": PLACE}
    assert session.cycle.board.still
    assert not session.world.related("robot_1", v.AT, PLACE)
