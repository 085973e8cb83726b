from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from skiros_py.devices.arm import ArmSpec
from skiros_py.motion.pinocchio.arm_motion import ArmMotion
from skiros_py.ports.cell import RobotSpec
from skiros_py.skills.cell_reader import read_cell
from skiros_py.station.robots.kinematics import robot_model
from skiros_py.station.worlds import open_world


@pytest.fixture(scope="module")
def robot() -> RobotSpec:
    return read_cell(open_world("kitting"), ("robot_1",), simulated=False).robots[0]


@pytest.fixture(scope="module")
def planner(robot: RobotSpec) -> ArmMotion:
    return ArmMotion(robot)


@settings(max_examples=30, deadline=None)
@given(st.lists(st.floats(-1.5, 1.5), min_size=7, max_size=7))
def test_the_tool_is_where_the_motion_planner_says(robot, planner, angles) -> None:
    arm = robot.of(ArmSpec)[0]

    pose = robot_model(robot.model).tool(arm, angles)

    wanted = planner.frame_pose(arm.id, tuple(angles), arm.tip)
    assert pose is not None
    assert pose.position == pytest.approx(wanted.position, abs=1e-9)
    turn = pose.inverse() @ wanted
    assert abs(turn.orientation[3]) == pytest.approx(1.0, abs=1e-9)


def test_the_limits_of_joints_are_those_of_the_model(robot) -> None:
    joint = robot_model(robot.model).joint(robot.of(ArmSpec)[0].joints[3])

    assert joint is not None
    assert joint.lower is not None
    assert joint.upper is not None
    assert joint.lower < robot.of(ArmSpec)[0].home[3] < joint.upper


def test_a_joint_that_the_model_does_not_have_is_none(robot) -> None:
    assert robot_model(robot.model).joint("nix") is None
