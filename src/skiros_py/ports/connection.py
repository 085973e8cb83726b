"""A driver that is connected and disconnected while its cell runs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from skiros_py.errors import DeviceError
from skiros_py.ports.driver import CellDriver
from skiros_py.ports.pending import Pending
from skiros_py.ports.values import Commands, DepthImage, Snapshot


class Connection:
    """A :class:`~skiros_py.ports.driver.CellDriver` in front of one that may be gone for a while.

    While it is disconnected, its devices keep the state that they had last, and take no commands.

    Args:
        make: Connects a driver.
    """

    def __init__(self, make: Callable[[], CellDriver]) -> None:
        self._make = make
        self._halted = False
        driver = make()
        self._driver: CellDriver | None = driver
        self._snapshot = driver.read()
        self._ahead = 0, 0.0
        self.devices, self.period = driver.devices, driver.period
        self.kind, self.braking_time = driver.kind, driver.braking_time

    @property
    def connected(self) -> bool:
        """True while there is a driver."""
        return self._driver is not None

    def connect(self) -> None:
        """Connects a driver, if there is none; this may take long, and any thread may do it.

        Raises:
            DeviceError: It cannot be connected, or drives other devices than the one before.
        """
        if self._driver is not None:
            return
        driver = self._make()
        if driver.devices.keys() != self.devices.keys():
            driver.close()
            raise DeviceError(f"{self.kind} drives {', '.join(driver.devices)} now, not {', '.join(self.devices)}")
        if self._halted:
            driver.halt()
        first, last = driver.read(), self._snapshot
        self._ahead = last.cycle - first.cycle, last.time - first.time
        self._driver = driver

    def disconnect(self) -> CellDriver | None:
        """Removes the driver between two cycles, and returns it for the caller to close; None if there is none."""
        driver, self._driver = self._driver, None
        return driver

    def read(self) -> Snapshot:
        """Returns the last state without advancing time."""
        return self._snapshot

    def exchange(self, commands: Commands) -> Snapshot:
        """Applies the commands for one period; while disconnected, the state stays as it was.

        Raises:
            DeviceError: A device broke.
        """
        last = self._snapshot
        if self._driver is None:
            self._snapshot = replace(last, cycle=last.cycle + 1, time=last.time + self.period)
        else:
            now, (cycles, seconds) = self._driver.exchange(commands), self._ahead
            self._snapshot = replace(now, cycle=now.cycle + cycles, time=now.time + seconds) if cycles else now
        return self._snapshot

    def halt(self) -> None:
        """Brakes everything until :meth:`release`; for any thread."""
        self._halted = True
        if (driver := self._driver) is not None:
            driver.halt()

    def release(self) -> None:
        """Obeys commands again."""
        self._halted = False
        if (driver := self._driver) is not None:
            driver.release()

    def capture(self, camera: str) -> Pending[DepthImage]:
        """Takes a picture now.

        Raises:
            DeviceError: No such camera, or it is disconnected.
        """
        if self._driver is None:
            raise DeviceError(f"{camera} is not connected")
        return self._driver.capture(camera)

    def close(self) -> None:
        """Brings the driver down; may be called twice."""
        if (driver := self.disconnect()) is not None:
            driver.close()
