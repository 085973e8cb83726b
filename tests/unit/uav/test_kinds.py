"""The device kinds of robots that fly keep the contract, and do what they are for."""

from __future__ import annotations

import math
from typing import Any

import pytest

from skiros_py.errors import DescriptionError, DeviceError
from skiros_py.geometry import Pose
from skiros_py.ports.device import Contribution, DeviceSpec, FakeRobot
from skiros_py.ports.paths import BasePath, PosePath
from skiros_py.testing.conformance import DeviceKindContract
from skiros_uav.aerial_base import AerialBaseSpec, AerialState, AerialTwist
from skiros_uav.battery import BatterySpec, BatteryState

OUTLINE = ((-0.6, -0.6), (0.6, -0.6), (0.6, 0.6), (-0.6, 0.6))
BASE = AerialBaseSpec("base", Pose((1.0, 2.0, 0.0)), OUTLINE, 1.0, 1.0, 0.6, 0.8, 1.5, 140.0, 0.9, (0.3, 0.0, 0.14))
BATTERY = BatterySpec("battery", "base", 180.0, 0.5, chargers=((1.0, 2.0),))


class TestAerialBase(DeviceKindContract):
    def device(self) -> DeviceSpec[Any, Any]:
        return BASE

    def target(self) -> AerialTwist:
        return AerialTwist(0.1, 0.2, 0.3, 0.4)


class TestBattery(DeviceKindContract):
    def device(self) -> DeviceSpec[Any, Any]:
        return BATTERY


def followed(path: PosePath, seconds: float = 60.0) -> AerialState:
    """Returns where the fake base is after it has followed a path."""
    robot = FakeRobot(pose=BASE.start)
    model = BASE.fake(robot)
    follower = BASE.follow(path, lambda: model.state().pose)
    for (_, target), _ in zip(follower, range(round(seconds / robot.period)), strict=False):
        model.command(target)
    return model.state()


def test_it_flies_up_along_and_down_to_the_end_of_a_path() -> None:
    goal = Pose.of(3.0, 1.0, 0.6, yaw=1.2)

    state = followed(PosePath((Pose((1.0, 2.0, 1.0)), Pose.of(3.0, 1.0, 1.0, yaw=1.2), goal)))

    assert state.pose.distance(goal) < 0.01
    assert state.pose.yaw == pytest.approx(1.2, abs=0.01)
    assert not state.landed


def test_a_path_over_the_floor_is_refused() -> None:
    with pytest.raises(DeviceError, match="from pose to pose"):
        next(BASE.follow(BasePath((), 0.0), lambda: BASE.start))


def test_without_a_command_the_fake_hovers_and_on_the_ground_it_has_landed() -> None:
    model = BASE.fake(FakeRobot())
    assert model.state().landed
    for _ in range(100):
        model.command(AerialTwist(climb=0.5))
    model.command(None)
    aloft = model.state()
    assert not aloft.landed
    assert aloft.still
    assert aloft.pose.position[2] == pytest.approx(0.25)
    for _ in range(200):
        model.command(AerialTwist(climb=-0.5))
    assert model.state().landed


def test_twists_are_mixed_by_weight() -> None:
    mixed = BASE.mixed(
        [Contribution("a", AerialTwist(climb=1.0), 3.0), Contribution("b", AerialTwist(linear=1.0), 1.0)]
    )

    assert mixed == AerialTwist(0.25, 0.0, 0.75, 0.0)


def test_a_battery_empties_by_what_is_drawn_and_fills_at_a_charger_only() -> None:
    state = BatteryState(0.5)

    flown = BATTERY.after(state, 60.0, 900.0, None)
    landed = BATTERY.after(state, 60.0, 15.0, (3.0, 3.0))
    charged = BATTERY.after(state, 60.0, 15.0, (1.1, 2.1))

    assert flown.charge == pytest.approx(0.5 - 900.0 / 60.0 / 180.0)
    assert landed.charge == pytest.approx(0.5 - 15.0 / 60.0 / 180.0)
    assert charged.charging
    assert charged.charge > 0.5


def test_it_is_never_fuller_than_full_nor_emptier_than_empty() -> None:
    assert BATTERY.after(BatteryState(0.99), 3600.0, 0.0, (1.0, 2.0)).charge == 1.0
    assert BATTERY.after(BatteryState(0.01), 3600.0, 900.0, None).charge == 0.0


class _Individual:
    """A battery that is described by properties alone."""

    id = "battery_1"

    def __init__(self, owner: str | None = "base_1", **values: Any) -> None:
        self._owner, self._values = owner, values

    def number(self, name: str, default: float | None = None) -> float:
        return self._values.get(name.partition(":")[2], default)

    def vector(self, name: str, length: int | None = None, default: Any = None) -> Any:
        return self._values.get(name.partition(":")[2], default)

    def owner(self, class_: str) -> str | None:
        return self._owner


@pytest.mark.parametrize(
    ("individual", "why"),
    [
        (_Individual(owner=None, capacity=100.0), "supplies no aerial base"),
        (_Individual(capacity=100.0, chargers=(1.0, 2.0, 3.0)), "x and y of each contact"),
        (_Individual(capacity=100.0, lowLevel=0.1, criticalLevel=0.2), "uav:criticalLevel"),
    ],
)
def test_what_a_battery_lacks_is_named(individual: Any, why: str) -> None:
    with pytest.raises(DescriptionError, match=why):
        BatterySpec.read(individual)


def test_signals_say_altitude_and_charge() -> None:
    altitude, charge = BASE.signal("altitude"), BATTERY.signal("charge")

    assert altitude is not None
    assert charge is not None
    assert altitude.read(AerialState(Pose((0.0, 0.0, 1.5)))) == 1.5
    assert math.isclose(charge.read(BatteryState(0.3)), 0.3)
