"""Mistakes of a cell driver are named, and switch off no more than they must."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest

from skiros_py.devices.mobile_base import BaseState
from skiros_py.errors import DeviceError
from skiros_py.geometry import Pose
from skiros_py.ports.board import DeviceBoard
from skiros_py.ports.driver import CompositeDriver
from skiros_py.ports.values import Commands, Snapshot
from skiros_py.simulation.fake.cell import FakeCell
from skiros_py.testing.conformance import small_cell

Change = Callable[[Snapshot], Any]
NAN = BaseState(Pose(), math.nan, 0.0, still=False)


class Mistaken:
    """A driver that changes what another one says."""

    kind = "mistaken"

    def __init__(self, change: Change = lambda snapshot: snapshot) -> None:
        self.change = change
        self._cell = FakeCell(small_cell(cameras=False))
        self.devices, self.period, self.braking_time = self._cell.devices, self._cell.period, 0.1

    def read(self) -> Snapshot:
        """Returns the present state."""
        return self._cell.read()

    def exchange(self, commands: Commands) -> Any:
        """Applies the commands, and says what is wrong."""
        return self.change(self._cell.exchange(commands))

    def __getattr__(self, name: str) -> Any:
        if name == "contain":  # it does not run the code of kinds itself
            raise AttributeError(name)
        return getattr(self._cell, name)


def fail(_now: Snapshot) -> Snapshot:
    raise ValueError("serial line")


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (fail, "driver 'mistaken': its exchange raised ValueError: serial line"),
        (lambda _now: None, "driver 'mistaken': its exchange returned None, not a Snapshot"),
        (lambda now: replace(now, cycle=0), "driver 'mistaken': its exchange returned cycle 0 after cycle 0"),
    ],
    ids=["raises", "returns None", "stands still"],
)
@pytest.mark.parametrize("alone", [True, False], ids=["alone", "one of several"])
def test_an_exchange_without_a_later_snapshot_is_an_error_with_the_name_of_the_driver(
    change: Change, said: str, *, alone: bool
) -> None:
    driver = Mistaken(change)
    board = DeviceBoard(driver if alone else CompositeDriver([driver]))

    with pytest.raises(DeviceError) as error:
        board.exchange()

    assert str(error.value) == said


def without(now: Snapshot) -> Snapshot:
    return replace(now, devices={id_: state for id_, state in now.devices.items() if id_ != "base"})


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda now: replace(now, devices={**now.devices, "base": "fast"}), "gave the state 'fast', not a BaseState"),
        (lambda now: replace(now, devices={**now.devices, "base": NAN}), "gave the state BaseState("),
        (without, "gave the state None, not a BaseState"),
    ],
    ids=["another type", "NaN", "missing"],
)
def test_a_device_with_a_wrong_state_is_switched_off_and_keeps_its_last_one(change: Change, said: str) -> None:
    driver = Mistaken()
    board = DeviceBoard(driver)
    before = board.exchange().devices
    driver.change = change

    after = board.exchange()

    assert said in board.guard.off["base"]
    assert set(board.guard.off) == {"base"}
    assert after.devices == before


def test_a_driver_without_a_state_of_a_device_is_refused_at_the_start() -> None:
    driver = Mistaken()
    driver.read = lambda: without(driver._cell.read())  # type: ignore[method-assign]

    with pytest.raises(DeviceError, match="base: driver 'mistaken' gave the state None"):
        DeviceBoard(driver)
