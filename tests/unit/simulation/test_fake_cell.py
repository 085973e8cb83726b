"""The fake cell does at once what it is told, and admits what it cannot do."""

import math

import pytest

from skiros_py.devices.arm import ArmState, ArmTarget
from skiros_py.devices.base import BaseState, BaseTwist
from skiros_py.devices.gripper import GripperState, GripperTarget
from skiros_py.errors import DeviceError
from skiros_py.geometry import Pose
from skiros_py.simulation.fake import FakeCell


def test_arms_and_grippers_reach_their_targets_within_the_cycle(kitting):
    cell = FakeCell(kitting.cell_spec())

    target = ArmTarget((0.1,) * 7, (0.0,) * 7)
    snapshot = cell.exchange({"arm": target, "gripper": GripperTarget(0.03, 20.0)})

    assert snapshot.cycle == 1
    assert snapshot.time == cell.period
    assert snapshot.state("arm", ArmState).positions == target.positions
    assert snapshot.state("gripper", GripperState).gap == 0.03
    assert cell.exchange({}).state("gripper", GripperState).gap == 0.03


def test_a_base_drives_exactly_as_told_and_knows_where_it_is(kitting):
    cell = FakeCell(kitting.cell_spec(start=Pose.of(1.0, 2.0, 0.0, yaw=math.pi / 2)))

    for _ in range(200):
        cell.exchange({"base": BaseTwist(0.5, 0.0)})
    for _ in range(200):
        cell.exchange({"base": BaseTwist(0.0, -math.pi / 2)})
    base = cell.exchange({}).state("base", BaseState)

    assert base.pose.position == pytest.approx((1.0, 2.5, 0.0))
    assert base.pose.yaw == pytest.approx(0.0, abs=1e-9)
    assert base.still


def test_there_is_nothing_to_see(kitting):
    with pytest.raises(DeviceError, match="the fake cell has no camera"):
        FakeCell(kitting.cell_spec()).capture("camera")


def test_a_command_for_an_unknown_device_is_refused(kitting):
    with pytest.raises(DeviceError, match="no device 'leg'; there is arm"):
        FakeCell(kitting.cell_spec()).exchange({"leg": ArmTarget((), ())})
