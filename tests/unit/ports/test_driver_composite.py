"""Drivers of one cell side by side: each gets its own commands, and all is one snapshot."""

from __future__ import annotations

import dataclasses

import pytest

from skiros_py.devices.mobile_base import BaseTwist
from skiros_py.errors import DeviceError, UsageError
from skiros_py.geometry import Pose, Solid
from skiros_py.ports.cell import BodySpec, CellSpec
from skiros_py.ports.driver import CellDriver, CompositeDriver
from skiros_py.simulation.fake.cell import FakeCell
from skiros_py.testing.conformance import CellDriverContract, small_cell


def _other(driver: str = "real", address: str = "10.0.0.7") -> CellSpec:
    """The small cell with other ids."""
    (robot,) = small_cell(cameras=False).robots
    devices = tuple(dataclasses.replace(device, id=f"{device.id}_2") for device in robot.devices)
    return CellSpec((), (dataclasses.replace(robot, id="robot_2", devices=devices, driver=driver, address=address),))


class TestCompositeDriver(CellDriverContract):
    inertia = False
    pictures = False

    def spec(self) -> CellSpec:
        return CellSpec((), (*small_cell(cameras=False).robots, *_other().robots))

    def make(self, spec: CellSpec) -> CellDriver:
        return CompositeDriver([FakeCell(part) for part in spec.by_driver().values()])


def test_each_driver_gets_the_commands_of_its_own_devices():
    first, second = FakeCell(small_cell(cameras=False)), FakeCell(_other())
    cell = CompositeDriver([first, second])

    for _ in range(200):
        snapshot = cell.exchange({"base_2": BaseTwist(0.5, 0.0)})

    assert snapshot.devices["base"].pose == Pose()
    assert snapshot.devices["base_2"].pose.position[0] == pytest.approx(0.5)
    assert (snapshot.cycle, first.read().cycle, second.read().cycle) == (200, 200, 200)
    with pytest.raises(DeviceError, match="no device 'base_3'"):
        cell.exchange({"base_3": BaseTwist(0.5, 0.0)})


def test_two_drivers_of_one_device_are_refused():
    with pytest.raises(UsageError, match="two drivers drive arm, base, force_torque, gripper"):
        CompositeDriver([FakeCell(small_cell(cameras=False)), FakeCell(small_cell(cameras=False))])


def test_drivers_of_different_periods_are_refused():
    class Slow(FakeCell):
        period = 0.01  # type: ignore[assignment]

    with pytest.raises(UsageError, match=r"one period: fake has 0\.005 s, fake has 0\.01 s"):
        CompositeDriver([FakeCell(small_cell(cameras=False)), Slow(_other())])


def test_all_drivers_are_closed_even_if_one_of_them_fails():
    closed = []

    class Telling(FakeCell):
        def close(self) -> None:
            closed.append(len(self.devices))

    class Failing(FakeCell):
        def close(self) -> None:
            raise DeviceError("stuck")

    cell = CompositeDriver([Telling(small_cell(cameras=False)), Failing(_other())])
    with pytest.raises(DeviceError, match="stuck"):
        cell.close()

    assert closed == [len(small_cell(cameras=False).devices)]


def test_a_cell_is_divided_by_driver_and_mounted_devices_follow_their_robot():
    bodies = (
        BodySpec("table", "Table", Solid.box(1.0, 1.0, 0.5), pose=Pose()),
        BodySpec("tray", "Tray", Solid.box(0.2, 0.2, 0.1), pose=Pose(), carrier="base_2"),
        BodySpec("part", "Part", Solid.box(0.1, 0.1, 0.1), 0.2, place="tray"),
    )
    spec = CellSpec(bodies, (*small_cell().robots, *_other().robots))

    parts = spec.by_driver()

    assert list(parts) == ["", "real"]
    assert [robot.id for robot in parts[""].robots] == ["robot"]
    assert [body.id for body in parts[""].bodies] == ["table"]
    assert [(robot.id, robot.address) for robot in parts["real"].robots] == [("robot_2", "10.0.0.7")]
    assert parts["real"].bodies == ()
