"""Devices are opened and closed at run time, and their drivers are connected and disconnected with them."""

from __future__ import annotations

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import pytest

from skiros_py.devices.mobile_base import BaseTwist
from skiros_py.errors import DeviceError, Refused, UnknownName, WrongState
from skiros_py.execution.claims import Claims
from skiros_py.ports.board import DeviceBoard, DeviceHandle
from skiros_py.ports.driver import Connection
from skiros_py.simulation.fake.cell import FakeCell
from skiros_py.station.robots.devices import DeviceService
from skiros_py.testing.conformance import small_cell


class Devices(DeviceService):
    """Opens and closes devices that are not described."""

    def get(self, _id: str) -> Any:
        return None


class Station:
    """A board over one connection, with a control thread that does everything at once."""

    def __init__(self) -> None:
        self.made: list[FakeCell] = []
        self.closed: list[FakeCell] = []
        self.fault = ""
        self.connection = Connection(self.make)
        self.board = DeviceBoard(self.connection)
        self.claims = Claims()
        managers, cycle = SimpleNamespace(claims=self.claims), SimpleNamespace(board=self.board)
        self.session: Any = SimpleNamespace(cell=self.connection, cycle=cycle, managers=managers)
        self.control: Any = self
        self.devices = Devices(self)  # type: ignore[arg-type]

    def make(self) -> FakeCell:
        if self.fault:
            raise DeviceError(self.fault)
        cell = FakeCell(small_cell(cameras=False))
        cell.close = lambda: self.closed.append(cell)  # type: ignore[method-assign]
        self.made.append(cell)
        return cell

    def call(self, work: Callable[[Any], Any]) -> Any:
        return work(self.session)


@pytest.fixture
def station() -> Station:
    return Station()


def test_a_closed_device_takes_neither_commands_nor_modules_until_it_is_opened(station: Station) -> None:
    station.devices.close("gripper")

    with pytest.raises(DeviceError, match="gripper is closed: open it first"):
        DeviceHandle(station.board, "gripper")
    station.board.send("base", BaseTwist(0.1, 0.0))  # the others go on
    station.devices.open("gripper")

    assert DeviceHandle(station.board, "gripper").id == "gripper"


def test_a_driver_is_disconnected_with_its_last_device_and_connected_with_the_first(station: Station) -> None:
    for device in ("arm", "base", "force_torque", "localiser", "scanner"):
        station.devices.close(device)
    assert station.connection.connected
    station.devices.close("gripper")
    assert not station.connection.connected
    assert station.closed == station.made

    station.devices.open("base")

    assert station.connection.connected
    assert len(station.made) == 2
    assert station.board.closed == {"arm", "force_torque", "gripper", "localiser", "scanner"}


def test_a_device_in_use_or_in_motion_cannot_be_closed(station: Station) -> None:
    with station.claims.request("pick", {"gripper"}), pytest.raises(WrongState, match=r"gripper \(pick\) is in use"):
        station.devices.close("gripper")
    station.board.send("base", BaseTwist(0.1, 0.0))
    station.board.exchange()
    with pytest.raises(WrongState, match="base moves"):
        station.devices.close("base")

    assert station.board.closed == set()


def test_a_device_whose_driver_does_not_answer_stays_closed(station: Station) -> None:
    for device in station.board.devices:
        station.devices.close(device)
    station.fault = "10.0.0.7 does not answer"

    with pytest.raises(Refused, match=r"base cannot be opened: 10\.0\.0\.7 does not answer"):
        station.devices.open("base")
    assert "base" in station.board.closed


def test_an_unknown_device_is_named(station: Station) -> None:
    for do in (station.devices.open, station.devices.close):
        with pytest.raises(UnknownName, match=r"unknown device 'bsae'.* Did you mean 'base'"):
            do("bsae")
