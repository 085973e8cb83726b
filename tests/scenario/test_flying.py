"""A robot that flies: it takes off and lands, delivers a part, and lands by itself when its battery falls."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from skiros_py.station.session import Session
from skiros_uav.aerial_base import AerialState
from skiros_uav.battery import SimulatedBattery

pytestmark = pytest.mark.physics

GOAL = "ObjectAtLocation(Starter, kit_1_a)"


def base_of(session: Session) -> AerialState:
    return session.cycle.board.snapshot.state("base_1", AerialState)


def battery_of(session: Session) -> SimulatedBattery:
    models = {id_: model for robot in session.simulation.scene.robots for id_, model in robot.devices.items()}
    battery = models["battery_1"]
    assert isinstance(battery, SimulatedBattery)
    return battery


@pytest.mark.parametrize("engine", ["pybullet", "mujoco"])
def test_it_takes_off_hovers_and_lands(open_session: Callable[..., Session], engine: str) -> None:
    session = open_session("delivery_uav", seed=1, simulation=engine)
    before = battery_of(session).level

    assert session.run(["Fly(robot_1)"]).reached
    aloft = base_of(session)
    for _ in range(400):
        session.cycle.step()
    hovering = base_of(session)

    assert aloft.pose.position[2] == pytest.approx(1.0, abs=0.02)
    assert hovering.pose.distance(aloft.pose) < 0.01
    assert not hovering.landed
    assert 70.0 < hovering.thrust < 110.0
    assert battery_of(session).level < before

    assert session.run(["Landed(robot_1)"]).reached
    assert base_of(session).landed
    assert base_of(session).pose.position[2] == pytest.approx(0.0, abs=0.01)


def test_it_delivers_a_part(open_session: Callable[..., Session]) -> None:
    session = open_session("delivery_uav", seed=1, simulation="mujoco")

    report = session.run([GOAL])

    assert report.reached
    assert [(one.believed, one.true) for one in report.conditions] == [(True, True)]


def test_where_its_battery_falls_low_it_charges_and_goes_on(
    open_session: Callable[..., Session], when: Callable[[Session, Callable[[], bool], Callable[[], None]], None]
) -> None:
    session = open_session("delivery_uav", seed=1)
    landed: list[tuple[float, ...]] = []

    def fall() -> None:
        battery_of(session).level = 0.29

    when(session, lambda: session.cycle.board.snapshot.time > 9.0 and base_of(session).climb > -0.01, fall)
    when(
        session,
        lambda: battery_of(session).level < 0.3 and base_of(session).landed,
        lambda: landed.append(base_of(session).pose.position),
    )

    report = session.run([GOAL])

    assert landed
    assert landed[0][:2] == pytest.approx((-2.5, 0.0), abs=0.1)
    assert report.reached
    assert "charge" in [step.skill for step in report.steps]
    assert report.conditions[0].true


def test_where_its_battery_is_nearly_empty_the_autopilot_lands_where_it_is(
    open_session: Callable[..., Session],
) -> None:
    session = open_session("delivery_uav", seed=1)
    assert session.run(["Fly(robot_1)"]).reached
    there = base_of(session).pose.position

    battery_of(session).level = 0.07
    for _ in range(1200):
        session.cycle.step()

    assert base_of(session).landed
    assert base_of(session).pose.position == pytest.approx((*there[:2], 0.0), abs=0.02)
    assert session.world.value("robot_1", "uav:landed") is True
    assert session.world.value("robot_1", "uav:batteryLow") is True
