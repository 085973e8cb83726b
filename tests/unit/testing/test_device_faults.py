"""A faulty cell does what its faults say, when they say, and nothing else."""

from __future__ import annotations

import math
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from skiros_py.devices.arm import ArmSpec, ArmState, ArmTarget
from skiros_py.devices.force_torque import ForceTorqueState
from skiros_py.devices.gripper import GripperState, GripperTarget
from skiros_py.devices.mobile_base import BaseState, BaseTwist
from skiros_py.errors import DeviceError, UnknownName
from skiros_py.geometry import Pose
from skiros_py.ports.board import DeviceBoard, DeviceHandle
from skiros_py.ports.driver import CellDriver
from skiros_py.ports.values import DepthImage, Done, Pending
from skiros_py.simulation.fake.cell import FakeCell
from skiros_py.testing import Blind, CellFault, Deaf, Dies, FaultyCell, Frozen, Late, Noisy, Says, Unplugged
from skiros_py.testing.conformance import small_cell

AHEAD = {"base": BaseTwist(0.5, 0.0)}


def cell(*faults: CellFault) -> FaultyCell:
    return FaultyCell(FakeCell(small_cell()), *faults)


def drive(driver: CellDriver, seconds: float) -> list[float]:
    return [
        driver.exchange(AHEAD).state("base", BaseState).pose.position[0] for _ in range(round(seconds / driver.period))
    ]


@given(st.integers(0, 60), st.integers(0, 60))
def test_a_deaf_base_stands_still_exactly_as_long_as_it_is_deaf(after: int, cycles: int) -> None:
    period = FakeCell(small_cell()).period
    ways = drive(cell(Deaf("base", after=after * period - 1e-9, for_=cycles * period)), 0.5)

    assert ways[-1] == pytest.approx(0.5 * (0.5 - min(cycles, 100 - after) * period))


def test_a_frozen_base_reports_where_it_was_and_then_where_it_is() -> None:
    ways = drive(cell(Frozen("base", after=0.25, for_=0.25)), 1.0)

    assert len(set(ways[49:99])) == 1
    assert ways[-1] == pytest.approx(0.5)


def test_a_device_says_what_it_is_told_to_whatever_it_does() -> None:
    holding = GripperState(0.04, 30.0, True)
    driver = cell(Says("gripper", holding, after=0.1))
    driver.exchange({"gripper": GripperTarget(0.0, 10.0)})

    before = driver.read().state("gripper", GripperState)
    drive(driver, 0.2)

    assert before.gap == 0.0
    assert driver.read().state("gripper", GripperState) == holding


def test_noise_is_centred_as_wide_as_told_and_the_same_in_each_run() -> None:
    runs = []
    for _ in range(2):
        driver = cell(Noisy("arm", 0.01, seed=3))
        runs.append([driver.exchange({}).state("arm", ArmState).positions[0] for _ in range(400)])
    errors = [position - small_cell().robots[0].of(ArmSpec)[0].home[0] for position in runs[0]]

    assert runs[0] == runs[1]
    assert sum(errors) / 400 == pytest.approx(0.0, abs=0.002)
    assert math.sqrt(sum(e * e for e in errors) / 400) == pytest.approx(0.01, rel=0.2)


def test_noise_of_a_base_and_a_gripper_moves_them_a_little() -> None:
    driver = cell(Noisy("base", 0.01), Noisy("gripper", 0.001))
    now = driver.exchange({})

    assert 0.0 < now.state("base", BaseState).pose.distance(Pose()) < 0.1
    assert now.state("gripper", GripperState).gap != 0.08


def test_a_cell_that_dies_answers_no_more() -> None:
    driver = cell(Dies(after=0.1, device="the bus"))
    drive(driver, 0.1)

    with pytest.raises(DeviceError, match="the bus does not answer"):
        drive(driver, 0.1)


def test_an_unplugged_device_is_switched_off_and_the_others_go_on() -> None:
    board = DeviceBoard(cell(Unplugged("force_torque", after=0.1)))
    sensor = DeviceHandle[Any, ForceTorqueState, Any](board, "force_torque")
    assert sensor.state == ForceTorqueState()
    for _ in range(30):
        board.exchange()

    with pytest.raises(DeviceError, match=r"force_torque .* was switched off: it does not answer"):
        _ = sensor.state
    assert DeviceHandle[Any, ArmState, Any](board, "arm").state.still


class Seeing(FakeCell):
    """A fake that makes pictures."""

    def capture(self, camera: str) -> Pending[DepthImage]:
        return Done(None, latency=0.1)  # type: ignore[arg-type]  # nobody looks at it


def test_a_blind_camera_refuses_and_a_late_one_takes_longer() -> None:
    driver = FaultyCell(Seeing(small_cell()), Late("camera", 2.0), Blind("camera", after=0.1))

    assert driver.capture("camera").latency == pytest.approx(2.1)
    drive(driver, 0.1)
    with pytest.raises(DeviceError, match="camera 'camera' does not answer"):
        driver.capture("camera")


def test_faults_add_up_in_their_order() -> None:
    driver = cell(Deaf("arm"), Frozen("base"))
    now = driver.exchange({"arm": ArmTarget((0.0,) * 7, (0.0,) * 7), **AHEAD})

    assert now.state("arm", ArmState).positions == small_cell().robots[0].of(ArmSpec)[0].home
    assert now.state("base", BaseState).pose == Pose()


@pytest.mark.parametrize("fault", [Deaf("bass"), Frozen("bass"), Noisy("bass", 0.1)])
def test_a_fault_of_a_device_that_is_not_there_is_refused(fault: CellFault) -> None:
    with pytest.raises(UnknownName, match="Did you mean 'base'"):
        cell(fault)
