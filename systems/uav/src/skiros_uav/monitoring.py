"""Primitives that read a battery: one that monitors it beside what else runs, one that waits until it is charged."""

from __future__ import annotations

import math
from typing import Any, ClassVar

from skiros_py.messages import Message
from skiros_py.ports.board import DeviceHandle
from skiros_py.skills.outcome import Execution, Failure, Outcome, Success
from skiros_py.skills.parameters import Access, Kind, param
from skiros_py.skills.primitive import Primitive
from skiros_py.world import vocabulary as v
from skiros_uav import names
from skiros_uav.aerial_base import AerialState
from skiros_uav.battery import BatterySpec, BatteryState

_CHARGED = 0.9
"""Charge from which a battery counts as charged."""
_STEP, _STALLED = 0.01, 60.0
"""Without so much more charge in so long a time [s], it is not being charged."""


class Battery(DeviceHandle[BatterySpec, BatteryState, None]):
    """A battery in the hands of a primitive."""

    spec_type: ClassVar[Any] = BatterySpec


class BatteryPrimitive(Primitive[Any]):
    """Base of the primitives that read a battery; their parameters have fields ``battery`` and ``robot``."""

    def write_low(self, state: BatteryState, *, low: bool) -> None:
        """Writes whether the robot has to charge its battery."""
        if self.world.value(self.params.robot, names.BATTERY_LOW) is not low:
            reason = Message("the battery is at {percent:.0f} %", percent=100.0 * state.charge)
            with self.world.transaction(author=self.name, reason=reason) as tx:
                tx.set(self.params.robot, names.BATTERY_LOW, low)


class MonitorBattery(BatteryPrimitive):
    """Writes when the charge has fallen low, and where the autopilot has landed by itself; it never ends by itself."""

    name: ClassVar[str] = "monitor_battery"
    limit: ClassVar[float | None] = math.inf

    battery: str = param(names.BATTERY, "The battery.", kind=Kind.HARDWARE, access=Access.READ)
    robot: str = param(v.ROBOT, "Its robot.", kind=Kind.PLANNING)
    frequency: float = param("number", "How often it looks.", default=10.0, unit="Hz")

    def execute(self) -> Execution[Outcome]:
        """Looks so many times a second."""
        battery = Battery(self.context.board, self.battery)
        while True:
            state = battery.state
            if state.charge < battery.spec.low:
                self.write_low(state, low=True)
            self._note_failsafe(battery.spec.base)
            yield from self.context.sleep(1.0 / self.frequency)

    def _note_failsafe(self, base: str) -> None:
        """Writes that the autopilot has landed by itself."""
        states = self.context.board.snapshot.of(AerialState)
        landed = self.world.value(self.robot, names.LANDED)
        if base in states and states[base].landed and states[base].failsafe and landed is not True:
            with self.world.transaction(author=self.name, reason=Message("the autopilot has landed")) as tx:
                tx.set(self.robot, names.LANDED, True)


class Recharge(BatteryPrimitive):
    """Waits at a charger until the battery is charged."""

    name: ClassVar[str] = "recharge"
    limit: ClassVar[float | None] = 3600.0

    battery: str = param(names.BATTERY, "The battery.", kind=Kind.HARDWARE, access=Access.READ)
    robot: str = param(v.ROBOT, "Its robot.", kind=Kind.PLANNING)

    def execute(self) -> Execution[Outcome]:
        """Waits; ends where the charge does not grow."""
        battery = Battery(self.context.board, self.battery)
        best, since = battery.state.charge, self.context.now
        while (state := battery.state).charge < _CHARGED:
            if state.charge > best + _STEP:
                best, since = state.charge, self.context.now
                self.progress(round(100.0 * best), Message("the battery is at {percent:.0f} %", percent=100.0 * best))
            if self.context.now - since > _STALLED:
                return Failure(Message("{battery} is not being charged here", battery=self.battery))
            yield
        self.write_low(state, low=False)
        return Success(Message("charged to {percent:.0f} %", percent=100.0 * state.charge))
