"""The same skills on other robots, by their descriptions only."""

from __future__ import annotations

import math

import pytest

from skiros_py.devices.mobile_base import BaseState
from skiros_py.simulation.truth import Truth

pytestmark = [pytest.mark.physics, pytest.mark.parametrize("engine", ["pybullet", "mujoco"])]


def test_an_iiwa_on_an_omnidirectional_base_puts_a_part_into_the_kit(open_session, engine):
    session = open_session("kitting_iiwa", seed=3, simulation=engine)

    report = session.run(["InKit(Starter, kit_1)"])

    assert [(condition.believed, condition.true) for condition in report.conditions] == [(True, True)]
    assert report.reached


def test_a_fanuc_on_a_heavy_base_puts_a_part_into_the_kit(open_session, engine):
    session = open_session("kitting_fanuc", seed=3, simulation=engine)

    report = session.run(["ObjectAtLocation(Alternator, kit_1_b)"])

    assert [(condition.believed, condition.true) for condition in report.conditions] == [(True, True)]
    assert report.reached


def test_from_pallet_to_pallet_it_glides_and_docks_within_5_mm_and_half_a_degree(open_session, engine):
    session, sideways = open_session("kitting_iiwa", seed=4, simulation=engine), []
    board, truth = session.cycle.board, Truth(session.simulation)
    assert session.run(["RobotAtLocation(robot_1, pallet_a)"]).reached
    session.cycle.observe(lambda: sideways.append(abs(board.snapshot.state("base_1", BaseState).sideways)))

    report = session.run(["RobotAtLocation(robot_1, pallet_b)"])

    assert report.reached
    assert max(sideways) > 0.3
    pose = truth.base_pose("base_1")
    assert math.dist(pose.position[:2], (5.0 - 0.78, -1.6)) <= 0.005
    assert abs(pose.yaw) <= math.radians(0.5)
