"""The simulated base keeps its limits, cannot move sideways, and stops by itself."""

import itertools
import math

import pytest

from skiros_py.devices.arm import ArmTarget
from skiros_py.devices.mobile_base import BaseState, BaseTwist
from skiros_py.errors import DeviceError
from skiros_py.geometry import Pose
from skiros_py.simulation.truth import Truth

LIMITS = {"linear": (0.8, 0.8), "angular": (1.2, 1.6)}  # greatest speed, greatest acceleration


def _drive(cell, linear, angular, cycles):
    return [cell.exchange({"base": BaseTwist(linear, angular)}).state("base", BaseState) for _ in range(cycles)]


def _coast(cell, cycles):
    return [cell.exchange({}).state("base", BaseState) for _ in range(cycles)]


@pytest.mark.parametrize("kind", ["linear", "angular"])
def test_a_base_commanded_too_fast_keeps_its_limits_and_stops_after_v_over_a(make_cell, kitting, kind):
    cell = make_cell(kitting.cell_spec(start=Pose((-2.0, 0.0, 0.0))))
    speed_limit, acceleration = LIMITS[kind]
    twist = {"linear": (9.0, 0.0), "angular": (0.0, 9.0)}[kind]

    speeds = [0.0, *(getattr(state, kind) for state in _drive(cell, *twist, 300))]
    speeds += [getattr(state, kind) for state in _coast(cell, 300)]
    steps = [abs(after - before) for before, after in itertools.pairwise(speeds)]
    last_moving = max(n for n, speed in enumerate(speeds) if abs(speed) > 0.002)

    assert max(speeds) == pytest.approx(speed_limit, rel=0.01)
    assert max(steps) <= acceleration * cell.period * 1.1
    assert (last_moving - 300) * cell.period <= speed_limit / acceleration + 0.05
    assert cell.read().state("base", BaseState).still


def test_a_differential_base_drives_curves_without_moving_sideways(make_cell, kitting):
    cell = make_cell(kitting.cell_spec(start=Pose.of(-2.0, 0.0, 0.0, yaw=0.5)))
    truth = Truth(cell)

    worst = 0.0
    for _ in range(400):
        before = truth.base_pose("base")
        _drive(cell, 0.5, 0.7, 1)
        step = before.inverse() @ truth.base_pose("base")
        expected = step.position[0] * math.tan(step.yaw / 2.0)  # of a circle tangent to the heading
        worst = max(worst, abs(step.position[1] - expected))

    assert worst < 2e-6


def test_a_standing_base_does_not_creep_while_the_arm_swings(make_cell, kitting):
    cell = make_cell(kitting.cell_spec())
    truth = Truth(cell)
    before = truth.base_pose("base")

    for cycle in range(600):
        swing = tuple(angle + 0.4 * math.sin(cycle / 60.0) for angle in kitting.HOME)
        speeds = (0.4 * math.cos(cycle / 60.0) * 200.0 / 60.0,) * 7
        cell.exchange({"arm": ArmTarget(swing, speeds)})
    after = truth.base_pose("base")

    assert before.distance(after) < 5e-5
    assert abs(after.yaw - before.yaw) < 5e-5


def test_the_wheels_turn_as_far_as_the_base_drives(make_cell, kitting):
    cell = make_cell(kitting.cell_spec(start=Pose((-2.0, 0.0, 0.0))))
    wheels = cell.scene.robots[0].model.joints(("wheel_left", "wheel_right"))
    before = Truth(cell).base_pose("base")

    _drive(cell, 0.5, 0.0, 400)
    _coast(cell, 200)
    turned = wheels.read().positions
    way = before.distance(Truth(cell).base_pose("base"))

    assert turned == pytest.approx((way / 0.10,) * 2, rel=0.02)


def test_a_speed_that_is_not_finite_is_refused(make_cell, kitting):
    with pytest.raises(DeviceError, match="base: a command is made of finite numbers"):
        _drive(make_cell(kitting.cell_spec()), math.nan, 0.0, 1)
