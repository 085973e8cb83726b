"""Batteries of robots that fly: their charge is what flying has left of it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Self

import numpy as np

from skiros_py.errors import DescriptionError
from skiros_py.ports.device import DeviceSignal, DeviceSpec, FakeRobot, Individual
from skiros_py.ports.kinematics import BASE_LINK
from skiros_py.ports.simulation import SimulatedRobot
from skiros_uav.aerial_base import SimulatedAerialBase, wired_base

_ELECTRONICS = 15.0
"""Power of everything but the rotors [W]."""
_PER_THRUST = 1.15
"""Power of the rotors per thrust^1.5 [W / N^1.5]: momentum theory for six discs of 0.19 m radius, 68 % of it used."""
_HOVERING = 90.0
"""Thrust that a fake robot is taken to need in the air [N]."""
_CHARGER = 0.3
"""How far from the contact of a charger it is still charged [m]."""


@dataclass(frozen=True, slots=True)
class BatteryState:
    """What a battery says.

    Attributes:
        charge: Charge, 0 to 1.
        power: What is drawn from it [W]; negative while it is charged.
        charging: Whether it is being charged.
    """

    charge: float
    power: float = 0.0
    charging: bool = False


@dataclass(frozen=True, slots=True)
class BatterySpec(DeviceSpec[BatteryState, None]):
    """A battery.

    Attributes:
        id: Its element id.
        base: Id of the aerial base that it supplies.
        capacity: Energy when it is full [Wh].
        charge: Charge at the start, 0 to 1.
        low: Charge below which the robot has to charge it.
        critical: Charge below which the autopilot lands by itself.
        charging_power: Power with which it is charged [W].
        chargers: Where contacts charge it, in the map [m].
    """

    kind: ClassVar[str] = "battery"
    device_class: ClassVar[str] = "uav:Battery"
    state_type: ClassVar[type] = BatteryState
    signals: ClassVar[tuple[DeviceSignal[Any], ...]] = (
        DeviceSignal("charge", lambda state: state.charge, help="charge, 0 to 1"),
        DeviceSignal("power", lambda state: state.power, "W", "what is drawn from it"),
        DeviceSignal("charging", lambda state: state.charging, help="whether it is being charged"),
    )

    base: str
    capacity: float
    charge: float = 1.0
    low: float = 0.3
    critical: float = 0.08
    charging_power: float = 2000.0
    chargers: tuple[tuple[float, float], ...] = ()

    @classmethod
    def read(cls, individual: Individual) -> Self:
        """Reads the base that has it, its capacity, its levels and where it is charged."""
        base = individual.owner("uav:AerialBase")
        if base is None:
            raise DescriptionError(f"{individual.id} supplies no aerial base: relate one to it by sk:hasA")
        numbers = individual.vector("uav:chargers", default=())
        if len(numbers) % 2:
            raise DescriptionError(f"{individual.id}: uav:chargers takes x and y of each contact")
        levels = (("uav:chargeLevel", 1.0), ("uav:lowLevel", 0.3), ("uav:criticalLevel", 0.08))
        charge, low, critical = (individual.number(name, default) for name, default in levels)
        if not 0.0 < critical < low < 1.0:
            raise DescriptionError(f"{individual.id}: uav:criticalLevel, then uav:lowLevel are between 0 and 1")
        power = individual.number("uav:chargingPower", 2000.0)
        contacts = tuple(zip(numbers[0::2], numbers[1::2], strict=True))
        return cls(individual.id, base, individual.number("uav:capacity"), charge, low, critical, power, contacts)

    def fake(self, robot: FakeRobot) -> _Fake:
        """Returns a battery that empties above the ground, and fills at a charger."""
        return _Fake(self, robot)

    def simulate(self, robot: SimulatedRobot, rng: np.random.Generator) -> SimulatedBattery:  # noqa: ARG002 - nothing is drawn
        """Returns a battery that gives what the rotors of its robot need."""
        return SimulatedBattery(self, robot)

    def noisy(self, state: BatteryState, sigma: float, rng: np.random.Generator) -> BatteryState:
        """Returns a state with noise on the charge."""
        return replace(state, charge=min(1.0, max(0.0, state.charge + float(rng.normal(0.0, sigma)))))

    def after(self, state: BatteryState, seconds: float, power: float, at: tuple[float, float] | None) -> BatteryState:
        """Returns the state after a time.

        Args:
            state: The state before.
            seconds: The time [s].
            power: What is drawn [W].
            at: Where the robot has landed, in the map [m]; None for one that flies.
        """
        charging = at is not None and any(math.dist(at, charger) < _CHARGER for charger in self.chargers)
        drawn = power - self.charging_power if charging else power
        charge = state.charge - drawn * seconds / (3600.0 * self.capacity)
        return BatteryState(min(1.0, max(0.0, charge)), drawn, charging)


class _Fake:
    braking_time = 0.0

    def __init__(self, spec: BatterySpec, robot: FakeRobot) -> None:
        self._spec, self._robot = spec, robot
        self._state = BatteryState(spec.charge)

    def command(self, target: None) -> None:
        pass

    def state(self) -> BatteryState:
        x, y, z = self._robot.pose.position
        power = _ELECTRONICS + (_PER_THRUST * _HOVERING**1.5 if z > 0.0 else 0.0)
        self._state = self._spec.after(self._state, self._robot.period, power, None if z > 0.0 else (x, y))
        return self._state


class SimulatedBattery:
    """Gives what the rotors need.

    Args:
        spec: The battery.
        robot: Its robot.

    Attributes:
        level: Charge, 0 to 1; may be set, for tests of what an empty battery leads to.
    """

    braking_time = 0.0

    def __init__(self, spec: BatterySpec, robot: SimulatedRobot) -> None:
        self._spec = spec
        self.level = spec.charge
        self._link = robot.link(BASE_LINK)
        self._period = robot.engine.period
        self._base: SimulatedAerialBase | None = None

    def wire(self, models: Mapping[str, Any]) -> None:
        """Supplies its base, whose autopilot measures its charge."""
        self._base = wired_base(models, self._spec.base)
        if self._base is not None:
            self._base.is_empty = lambda: self.level < self._spec.critical

    def command(self, target: None) -> None:
        """Does nothing: it is a sensor."""

    def state(self) -> BatteryState:
        """Measures; to be called once per cycle."""
        base = self._base
        thrust, landed = (0.0, False) if base is None else (base.thrust, base.landed)
        x, y, _ = self._link.pose().position if landed else (0.0, 0.0, 0.0)
        power = _ELECTRONICS + _PER_THRUST * thrust**1.5
        state = self._spec.after(BatteryState(self.level), self._period, power, (x, y) if landed else None)
        self.level = state.charge
        return state
