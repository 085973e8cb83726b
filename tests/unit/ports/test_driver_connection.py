"""A driver that comes and goes while its cell runs."""

from __future__ import annotations

import pytest

from skiros_py.devices.mobile_base import BaseTwist
from skiros_py.errors import DeviceError
from skiros_py.ports.cell import CellSpec
from skiros_py.ports.driver import CellDriver, Connection
from skiros_py.simulation.fake.cell import FakeCell
from skiros_py.testing.conformance import CellDriverContract, small_cell

AHEAD = {"base": BaseTwist(0.5, 0.0)}


class TestConnection(CellDriverContract):
    inertia = False
    pictures = False

    def spec(self) -> CellSpec:
        return small_cell(cameras=False)

    def make(self, spec: CellSpec) -> CellDriver:
        return Connection(lambda: FakeCell(spec))


def test_disconnected_devices_keep_their_state_while_time_advances():
    connection = Connection(lambda: FakeCell(small_cell(cameras=False)))
    before = connection.exchange(AHEAD)
    driver = connection.disconnect()

    after = connection.exchange(AHEAD)

    assert isinstance(driver, FakeCell)
    assert not connection.connected
    assert after.devices == before.devices
    assert (after.cycle, after.time) == (2, pytest.approx(2 * connection.period))
    with pytest.raises(DeviceError, match="eye is not connected"):
        connection.capture("eye")


def test_a_driver_connected_later_continues_with_the_time_of_the_run():
    connection = Connection(lambda: FakeCell(small_cell(cameras=False)))
    for _ in range(3):
        connection.exchange({})
    connection.disconnect()
    connection.connect()

    after = connection.exchange(AHEAD)

    assert (after.cycle, after.time) == (4, pytest.approx(4 * connection.period))
    assert after.devices["base"].pose.position[0] > 0.0


def test_a_halt_applies_to_a_driver_connected_later():
    connection = Connection(lambda: FakeCell(small_cell(cameras=False)))
    connection.disconnect()
    connection.halt()
    connection.connect()

    halted = connection.exchange(AHEAD)
    connection.release()
    released = connection.exchange(AHEAD)

    assert halted.devices["base"].pose.position[0] == 0.0
    assert released.devices["base"].pose.position[0] > 0.0


def test_a_driver_of_other_devices_is_refused_and_closed():
    closed: list[CellDriver] = []

    class Other(FakeCell):
        def close(self) -> None:
            closed.append(self)

    found = [FakeCell(small_cell(cameras=False)), Other(small_cell())]
    connection = Connection(lambda: found.pop(0))
    connection.disconnect()

    with pytest.raises(DeviceError, match="fake drives"):
        connection.connect()
    assert len(closed) == 1
