"""A halted cell brakes whatever is commanded, from any thread, and obeys again when it is released."""

import threading

import pytest

from skiros_py.devices.arm import ArmState, ArmTarget
from skiros_py.devices.gripper import GripperState, GripperTarget
from skiros_py.devices.mobile_base import BaseState, BaseTwist
from skiros_py.simulation.fake.cell import FakeCell

FULL = BaseTwist(-0.8, 0.0)  # backwards: ahead stands the table


@pytest.fixture(params=["fake", "pybullet"])
def cell(request, make_cell, kitting):
    spec = kitting.cell_spec()
    return FakeCell(spec) if request.param == "fake" else make_cell(spec)


def _swing(kitting, cell, cycle):
    """Turns the first joint with 2 rad/s."""
    angle = kitting.HOME[0] + 2.0 * cycle * cell.period
    return ArmTarget((angle, *kitting.HOME[1:]), (2.0, *(0.0,) * 6))


def _at_speed(kitting, cell):
    """Drives and swings until both go fast; returns the commands that would go on with it."""
    for cycle in range(1, 221):
        arm = _swing(kitting, cell, max(0, cycle - 180))
        cell.exchange({"arm": arm if cycle > 180 else ArmTarget(kitting.HOME, (0.0,) * 7), "base": FULL})
    return {"arm": _swing(kitting, cell, 41), "base": FULL}


def test_a_halted_cell_stops_within_its_braking_time_despite_commands(cell, kitting):
    commands = _at_speed(kitting, cell)
    assert not cell.read().state("base", BaseState).still
    assert not cell.read().state("arm", ArmState).still

    threading.Thread(target=cell.halt).start()
    end = cell.read().time + cell.braking_time
    while cell.read().time < end:
        cell.exchange(commands)

    assert cell.read().state("base", BaseState).still
    assert cell.read().state("arm", ArmState).still


def test_a_cell_without_commands_stops_within_its_braking_time(cell, kitting):
    _at_speed(kitting, cell)

    end = cell.read().time + cell.braking_time
    while cell.read().time < end:
        cell.exchange({})

    assert cell.read().state("base", BaseState).still
    assert cell.read().state("arm", ArmState).still


def test_a_released_cell_stands_until_it_is_commanded_and_then_moves(cell, kitting):
    cell.halt()
    cell.exchange({"base": FULL})
    cell.release()
    for _ in range(20):
        cell.exchange({})
    assert cell.read().state("base", BaseState).still

    for _ in range(20):
        cell.exchange({"base": FULL})
    assert cell.read().state("base", BaseState).linear < -0.05


def test_a_halted_gripper_keeps_its_grip(cell):
    cell.exchange({"gripper": GripperTarget(0.02, 30.0)})
    cell.halt()
    for _ in range(200):
        cell.exchange({"gripper": GripperTarget(0.08, 30.0)})

    assert cell.read().state("gripper", GripperState).gap == pytest.approx(0.02, abs=1e-3)
