"""Every engine behind the simulation port keeps the same contract, and simulated devices run on each of them."""

from __future__ import annotations

import sys
from typing import Any, ClassVar

import pytest
from unit.simulation.kinematic_engine import KinematicEngine

from skiros_py.errors import DeviceError, MissingExtra, UnknownName, UsageError
from skiros_py.geometry import Pose, Solid
from skiros_py.plugins.loading import find_plugin
from skiros_py.ports.cell import CellSpec
from skiros_py.ports.driver import CellDriver
from skiros_py.ports.simulation import FLOOR, Engine, SimulatedRobot
from skiros_py.simulation.cell import SimulatedCell
from skiros_py.simulation.pybullet import client
from skiros_py.testing.conformance import CellDriverContract, EngineContract, small_cell

GREY = (0.5, 0.5, 0.5, 1.0)


@pytest.mark.physics
class TestPyBullet(EngineContract):
    def make(self, period: float) -> Engine:
        engine: Engine = find_plugin("skiros.engines", "pybullet")(period=period)
        return engine


@pytest.mark.physics
class TestMujoco(EngineContract):
    def make(self, period: float) -> Engine:
        engine: Engine = find_plugin("skiros.engines", "mujoco")(period=period)
        return engine

    def test_what_goes_on_from_a_restored_state_is_the_same_to_the_last_bit(
        self, engine: Engine, crane: SimulatedRobot
    ) -> None:
        engine.add_body("box", Solid.box(0.2, 0.2, 0.1), Pose.of(2.0, 0.0, 0.2, roll=0.4), mass=1.0, colour=GREY)
        self.hold(crane, slew=1.0, trolley=0.5, counter=0.0)
        self.run(engine, 10)
        saved = engine.save()
        runs = []
        for _ in range(2):
            self.run(engine, 60)  # the box falls, and comes to lie
            runs.append(engine.state_bytes())
            engine.restore(saved)

        assert runs[0] == runs[1]

    def test_the_state_outlives_what_is_added_and_removed(self, engine: Engine, crane: SimulatedRobot) -> None:
        engine.add_body("first", Solid.box(0.2, 0.2, 0.1), Pose((2.0, 0.0, 1.0)), mass=1.0, colour=GREY)
        engine.add_body("box", Solid.box(0.2, 0.2, 0.1), Pose((3.0, 0.0, 1.0)), mass=1.0, colour=GREY)
        self.hold(crane, slew=0.3, trolley=0.2, counter=0.0)
        self.run(engine, 20)
        before = engine.pose("box"), engine.twist("box"), crane.joints(("slew",)).read()[:2]

        engine.remove_body("first")
        engine.add_body("other", Solid.box(0.1, 0.1, 0.1), Pose((4.0, 0.0, 0.0)), colour=GREY)

        assert (engine.pose("box"), engine.twist("box"), crane.joints(("slew",)).read()[:2]) == before
        self.run(engine, 100)
        assert crane.joints(("slew", "trolley")).read().positions == pytest.approx((0.3, 0.2), abs=self.tolerance)

    def test_contacts_are_known_right_after_something_is_added_or_a_state_restored(self, engine: Engine) -> None:
        engine.add_body("box", Solid.box(0.2, 0.2, 0.1), Pose(), mass=1.0, colour=GREY)
        self.run(engine, 50)

        engine.add_body("other", Solid.box(0.2, 0.2, 0.1), Pose((2.0, 0.0, 0.0)), colour=GREY)
        assert {contact.other for contact in engine.contacts("box")} == {FLOOR}

        saved = engine.save()
        engine.move_body("box", Pose((0.0, 0.0, 1.0)))
        engine.step()
        assert engine.contacts("box") == ()
        engine.restore(saved)
        assert {contact.other for contact in engine.contacts("box")} == {FLOOR}

    def test_a_motor_that_is_blocked_pushes_with_its_greatest_effort_and_with_no_more(
        self, engine: Engine, crane: SimulatedRobot
    ) -> None:
        self.hold(crane, slew=0.0, counter=0.0)
        trolley = crane.joints(("trolley",))
        trolley.reset((0.95,))
        trolley.hold_positions((1.5,), gain=0.2, effort=(30.0,), max_velocity=0.1)
        efforts = []
        for _ in range(300):
            engine.step()
            efforts.append(trolley.read().efforts[0])

        assert efforts[-1] == pytest.approx(30.0)
        assert max(map(abs, efforts)) <= 30.0
        assert trolley.read().positions[0] == pytest.approx(1.0, abs=0.01)  # its end

    def test_a_motor_that_pushed_against_its_end_goes_back_with_less_effort(
        self, engine: Engine, crane: SimulatedRobot
    ) -> None:
        self.hold(crane, slew=0.0, counter=0.0)
        trolley = crane.joints(("trolley",))
        trolley.reset((0.99,))
        trolley.hold_positions((1.5,), gain=0.2, effort=(60.0,), max_velocity=0.01)
        self.run(engine, 300)
        pushing = trolley.read().efforts[0]
        trolley.hold_positions((0.5,), gain=0.2, effort=(20.0,), max_velocity=0.01)
        self.run(engine, 50)

        assert pushing == pytest.approx(60.0, abs=1.0)
        assert trolley.read().velocities[0] == pytest.approx(-0.01, abs=0.001)

    def test_it_has_no_window(self) -> None:
        with pytest.raises(UsageError, match="no window"):
            find_plugin("skiros.engines", "mujoco")(period=0.005, gui=True)


class TestKinematicEngine(EngineContract):
    dynamics: ClassVar[bool] = False

    def make(self, period: float) -> Engine:
        return KinematicEngine(period=period)


@pytest.mark.physics
class TestCellOnMujoco(CellDriverContract):
    """Every kind of device on it."""

    def make(self, spec: CellSpec) -> CellDriver:
        return SimulatedCell(spec, seed=1, engine="mujoco")


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


def test_an_engine_whose_library_is_not_installed_names_its_extra(monkeypatch):
    monkeypatch.setattr("skiros_py.simulation.pybullet.client._library", _without_pybullet(monkeypatch))

    with pytest.raises(MissingExtra, match="the simulation with PyBullet needs the extra 'pybullet'"):
        SimulatedCell(small_cell(), seed=1, engine="pybullet")


def _without_pybullet(monkeypatch: pytest.MonkeyPatch) -> Any:
    monkeypatch.setitem(sys.modules, "pybullet", None)  # importing it raises
    return client._library.__wrapped__
