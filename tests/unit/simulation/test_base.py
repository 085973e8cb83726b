"""The simulated base keeps its limits, cannot move sideways, and stops by itself."""

import itertools
import math

import numpy as np
import pytest

from skiros_py.devices.arm import ArmTarget
from skiros_py.devices.mobile_base import BaseState, BaseTwist
from skiros_py.errors import DeviceError
from skiros_py.geometry import Pose, Primitive, Solid
from skiros_py.ports.cell import BodySpec
from skiros_py.ports.simulation import Wrench
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


TRANSIENT, HELD = 280.0, 140.0  # [N] on a hand, in 10 ms and after half a second: ISO/TS 15066
BEHIND = -0.525 - 0.2  # [m] so that it has its full speed where it meets a thing
POST = Solid((Primitive("cylinder", (0.05, 0.3), Pose((0.0, 0.0, 0.15))),))
UNSEEN = {
    "a wall": BodySpec("thing", "Thing", Solid.box(0.3, 0.8, 0.5), pose=Pose((BEHIND - 0.15, 0.0, 0.0))),
    "an edge": BodySpec("thing", "Thing", Solid.box(0.3, 0.3, 0.5), pose=Pose.of(BEHIND - 0.22, 0.1, 0.0, yaw=0.8)),
    "a post at a corner": BodySpec("thing", "Thing", POST, pose=Pose((BEHIND - 0.05, 0.29, 0.0))),
    "a crate": BodySpec("thing", "Thing", Solid.box(0.3, 0.3, 0.5), 30.0, Pose((BEHIND - 0.15, 0.0, 0.0))),
}


def _pressed(cell, twist, cycles):
    """Drives on, whatever happens; returns the force on the thing in each cycle [N]."""
    truth, forces = Truth(cell), []
    for _ in range(cycles):
        cell.exchange({"base": twist})
        forces.append(sum(contact.force for contact in truth.contacts() if contact.body == "thing"))
    return np.array(forces)


@pytest.mark.parametrize("engine", ["pybullet", "mujoco"])
@pytest.mark.parametrize("thing", UNSEEN)
def test_a_base_backs_into_what_it_does_not_see_no_harder_than_a_hand_bears(make_cell, kitting, engine, thing):
    cell = make_cell(kitting.cell_spec(UNSEEN[thing]), engine=engine)

    forces = _pressed(cell, BaseTwist(-0.4, 0.0), 300)

    assert forces.max() > 20.0
    assert np.convolve(forces, np.ones(2) / 2.0).max() <= TRANSIENT
    assert np.convolve(forces, np.ones(100) / 100.0).max() <= HELD


@pytest.mark.parametrize("engine", ["pybullet", "mujoco"])
def test_a_bumper_is_not_harder_along_a_wall_because_more_points_touch_it(make_cell, kitting, engine):
    hardest = [
        _pressed(make_cell(kitting.cell_spec(UNSEEN[thing]), engine=engine), BaseTwist(-0.4, 0.0), 300).max()
        for thing in ("a wall", "a post at a corner")
    ]

    assert hardest[0] < 2.0 * hardest[1]


@pytest.mark.parametrize("engine", ["pybullet", "mujoco"])
def test_a_base_that_is_slowed_from_outside_lets_go_and_drives_on_once_it_stands(make_cell, kitting, engine):
    cell = make_cell(kitting.cell_spec(start=Pose((-3.0, 0.0, 0.0))), engine=engine)
    _drive(cell, 0.4, 0.0, 150)

    states = []
    for _ in range(40):
        cell.scene.engine.apply_wrench("robot", Wrench((-400.0, 0.0, 0.0)), link="base_link")
        states += _drive(cell, 0.4, 0.0, 1)
    released = _drive(cell, 0.4, 0.0, 300)

    brakes = [state for state in states[3:] if state.linear > 0.06]
    yields = [state for state in states if -0.1 < state.linear < -0.05]
    assert brakes
    assert yields
    assert all(state.force < 0.0 for state in brakes)
    assert all(abs(state.force) <= 45.0 for state in yields)
    assert released[-1].linear == pytest.approx(0.4, abs=0.01)


@pytest.mark.parametrize("engine", ["pybullet", "mujoco"])
def test_a_base_does_not_let_go_for_what_its_own_arm_does(make_cell, kitting, engine):
    cell = make_cell(kitting.cell_spec(start=Pose((-3.0, 0.0, 0.0))), engine=engine)
    speeds = []
    for cycle in range(300):
        swing = tuple(angle + 0.2 * (1.0 - math.cos(cycle / 30.0)) for angle in kitting.HOME)
        rates = (0.2 * math.sin(cycle / 30.0) * 200.0 / 30.0,) * 7
        state = cell.exchange({"base": BaseTwist(0.4, 0.3), "arm": ArmTarget(swing, rates)}).state("base", BaseState)
        speeds.append(state.linear)

    assert min(speeds[150:]) > 0.39
