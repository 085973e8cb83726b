"""Every engine behind the simulation port keeps the same contract, and simulated devices run on each of them."""

from __future__ import annotations

from typing import ClassVar

import pytest
from unit.simulation.kinematic_engine import KinematicEngine

from skiros_py.errors import DeviceError, UnknownName
from skiros_py.plugins.loading import find_plugin
from skiros_py.ports.cell import CellSpec
from skiros_py.ports.driver import CellDriver
from skiros_py.ports.simulation import Engine
from skiros_py.simulation.cell import SimulatedCell
from skiros_py.testing.conformance import CellDriverContract, EngineContract, small_cell


@pytest.mark.physics
class TestPyBullet(EngineContract):
    def make(self, period: float) -> Engine:
        engine: Engine = find_plugin("skiros.engines", "pybullet")(period=period)
        return engine


class TestKinematicEngine(EngineContract):
    dynamics: ClassVar[bool] = False

    def make(self, period: float) -> Engine:
        return KinematicEngine(period=period)


class TestCellOnTheKinematicEngine(CellDriverContract):
    """The same device code as on PyBullet; nothing else is simulated."""

    def make(self, spec: CellSpec) -> CellDriver:
        return SimulatedCell(spec, seed=1, engine=KinematicEngine)


def test_a_cell_has_the_class_of_its_engine():
    cell = SimulatedCell(small_cell(), seed=1, engine=KinematicEngine)

    assert cell.kind == "kinematic"
    assert cell.capture("camera").result().depth.max() > 0.0
    cell.close()


def test_an_unknown_engine_is_refused_with_those_there_are():
    with pytest.raises(UnknownName, match=r"unknown engine 'pybulet'.*Did you mean 'pybullet'"):
        SimulatedCell(small_cell(), seed=1, engine="pybulet")


def test_an_engine_that_does_not_start_is_a_device_error():
    def broken(*, period: float, gui: bool) -> Engine:
        raise RuntimeError(f"no licence for {1.0 / period:g} Hz")

    with pytest.raises(DeviceError, match="no licence for 200 Hz"):
        SimulatedCell(small_cell(), seed=1, engine=broken)
