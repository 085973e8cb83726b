"""Arm and gripper follow their targets within limits and do the safe thing when nobody commands them."""

import math
from dataclasses import replace

import numpy as np
import pytest

from skiros_py.devices.arm import ArmSpec, ArmState, ArmTarget
from skiros_py.devices.gripper import GripperState, GripperTarget
from skiros_py.errors import DescriptionError, DeviceError

REST = (0.0,) * 7


def _shifted(home, joint, by):
    return tuple(angle + (by if n == joint else 0.0) for n, angle in enumerate(home))


def test_at_the_start_the_arm_is_at_home_and_the_gripper_open(make_cell, kitting):
    snapshot = make_cell(kitting.cell_spec()).read()

    assert (snapshot.cycle, snapshot.time) == (0, 0.0)
    assert snapshot.state("arm", ArmState).positions == pytest.approx(kitting.HOME, abs=1e-4)
    assert snapshot.state("gripper", GripperState).gap == pytest.approx(0.08, abs=1e-4)
    assert snapshot.state("arm", ArmState).still
    assert snapshot.state("gripper", GripperState).still


def test_a_home_beyond_the_limits_of_a_joint_is_refused(make_cell, kitting):
    spec = kitting.cell_spec()
    (robot,) = spec.robots
    home = _shifted(kitting.HOME, 3, -1.0)
    devices = tuple(replace(one, home=home) if isinstance(one, ArmSpec) else one for one in robot.devices)

    with pytest.raises(
        DescriptionError, match=r"arm: sk:home has -3\.\d+ rad for panda_joint4, which turns from -3\.14"
    ):
        make_cell(replace(spec, robots=(replace(robot, devices=devices),)))


def test_a_smooth_motion_is_tracked_within_a_milliradian(make_cell, kitting):
    cell = make_cell(kitting.cell_spec())

    worst = 0.0
    for cycle in range(1, 401):
        phase = cycle / 400 * math.pi
        wanted = _shifted(kitting.HOME, 1, 0.4 * (1.0 - math.cos(phase)))
        speed = _shifted(REST, 1, 0.4 * math.sin(phase) * math.pi / 2.0)
        state = cell.exchange({"arm": ArmTarget(wanted, speed)}).state("arm", ArmState)
        worst = max(worst, float(np.abs(np.subtract(state.positions, wanted)).max()))

    assert worst < 1e-3


def test_a_jump_in_the_commands_becomes_a_motion_within_the_joint_speed(make_cell, kitting):
    cell = make_cell(kitting.cell_spec())
    target = ArmTarget(_shifted(kitting.HOME, 0, 1.0), REST)

    speeds = [abs(cell.exchange({"arm": target}).state("arm", ArmState).velocities[0]) for _ in range(200)]

    assert max(speeds) < 2.175 * 1.05
    assert cell.read().state("arm", ArmState).positions[0] == pytest.approx(kitting.HOME[0] + 1.0, abs=1e-3)


def test_an_arm_without_commands_brakes_smoothly_and_holds(make_cell, kitting):
    cell = make_cell(kitting.cell_spec())
    for cycle in range(1, 101):
        wanted = _shifted(kitting.HOME, 0, cycle * cell.period)
        cell.exchange({"arm": ArmTarget(wanted, _shifted(REST, 0, 1.0))})

    speeds = [1.0] + [cell.exchange({}).state("arm", ArmState).velocities[0] for _ in range(100)]
    decelerations = -np.diff(speeds) / cell.period
    stopped = cell.read().state("arm", ArmState)
    for _ in range(100):
        cell.exchange({})

    assert decelerations.max() < 7.5 * 1.3
    assert stopped.still
    assert stopped.positions[0] == pytest.approx(kitting.HOME[0] + 0.5 + 1.0 / (2 * 7.5), abs=0.01)
    assert cell.read().state("arm", ArmState).positions == pytest.approx(stopped.positions, abs=1e-5)


def test_a_gripper_keeps_its_last_target_and_measures_no_force_when_it_closes_empty(make_cell, kitting):
    cell = make_cell(kitting.cell_spec())

    cell.exchange({"gripper": GripperTarget(0.0, 30.0)})
    for _ in range(150):
        cell.exchange({})
    closed = cell.read().state("gripper", GripperState)

    assert closed.gap == pytest.approx(0.0, abs=5e-4)
    assert closed.force < 0.5
    assert closed.still


@pytest.mark.parametrize(
    "commands",
    [
        {"arm": ArmTarget((0.0,), (0.0,))},
        {"arm": ArmTarget((math.nan,) * 7, REST)},
        {"gripper": GripperTarget(math.inf, 30.0)},
    ],
)
def test_a_malformed_command_is_refused_with_the_device_s_name(make_cell, kitting, commands):
    with pytest.raises(DeviceError, match=r"(arm|gripper): a (target needs|command is made of)"):
        make_cell(kitting.cell_spec()).exchange(commands)
