"""A cell whose robots and devices have drivers of their own: simulated, real, or both."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import ExitStack
from typing import Any

from skiros_py.errors import DeviceError, UsageError
from skiros_py.ports.device import DeviceSpec
from skiros_py.ports.driver import CellDriver, require_known
from skiros_py.ports.pending import Pending
from skiros_py.ports.values import Commands, DepthImage, Snapshot


class CompositeDriver:
    """A :class:`~skiros_py.ports.driver.CellDriver` made of several, which are exchanged one after the other.

    Args:
        drivers: The drivers; the first is that of the cell, which says the kind.

    Attributes:
        drivers: The drivers.
        devices: The devices of all, by id.

    Raises:
        UsageError: Their periods differ, or two of them drive one device.
    """

    def __init__(self, drivers: Sequence[CellDriver]) -> None:
        self.drivers = tuple(drivers)
        self.devices: dict[str, DeviceSpec[Any, Any]] = {}
        for driver in self.drivers:
            twice = sorted(self.devices.keys() & driver.devices.keys())
            if twice:
                raise UsageError(f"two drivers drive {', '.join(twice)}")
            if driver.period != self.period:
                raise UsageError(
                    f"drivers of one cell need one period: {self.kind} has {self.period:g} s, {driver.kind} has "
                    f"{driver.period:g} s"
                )
            self.devices |= driver.devices
        self._snapshot = self._merged(0, [driver.read() for driver in self.drivers])

    @property
    def period(self) -> float:
        """Length of one control cycle [s]."""
        return self.drivers[0].period

    @property
    def kind(self) -> str:
        """Kind of the cell's own driver."""
        return self.drivers[0].kind

    @property
    def braking_time(self) -> float:
        """Longest time from full speed to standstill [s]."""
        return max(driver.braking_time for driver in self.drivers)

    def read(self) -> Snapshot:
        """Returns the present state without advancing time."""
        return self._snapshot

    def exchange(self, commands: Commands) -> Snapshot:
        """Exchanges each driver's commands for one period, and returns what the sensors of all say at its end.

        Raises:
            DeviceError: A device broke, or a command is for a device that does not exist.
        """
        require_known(commands, self.devices)
        snapshots = [
            driver.exchange({device: target for device, target in commands.items() if device in driver.devices})
            for driver in self.drivers
        ]
        self._snapshot = self._merged(self._snapshot.cycle + 1, snapshots)
        return self._snapshot

    def halt(self) -> None:
        """Brakes everything until :meth:`release`; for any thread."""
        for driver in self.drivers:
            driver.halt()

    def release(self) -> None:
        """Obeys commands again."""
        for driver in self.drivers:
            driver.release()

    def capture(self, camera: str) -> Pending[DepthImage]:
        """Takes a picture now; it shows the devices of the driver that has the camera.

        Raises:
            DeviceError: No such camera.
        """
        for driver in self.drivers:
            if camera in driver.devices:
                return driver.capture(camera)
        raise DeviceError(f"no camera '{camera}' in this cell")

    def close(self) -> None:
        """Brings all drivers down, also where one of them fails; may be called twice."""
        with ExitStack() as stack:
            for driver in self.drivers:
                stack.callback(driver.close)

    def _merged(self, cycle: int, snapshots: Sequence[Snapshot]) -> Snapshot:
        devices = {device: state for snapshot in snapshots for device, state in snapshot.devices.items()}
        return Snapshot(cycle, cycle * self.period, devices)
