"""The port to a robot cell: simulated, real or both; a driver is connected and disconnected while its cell runs."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import replace
from typing import Any, ClassVar, Protocol, runtime_checkable

from skiros_py.errors import DeviceError, SkirosError, UsageError
from skiros_py.ports.device import DeviceSpec
from skiros_py.ports.device_faults import DeviceModels, KindGuard
from skiros_py.ports.values import Commands, DepthImage, Pending, Snapshot

_PERIOD = 1.0 / 200.0


class CellDriver(Protocol):
    """All devices of a cell, exchanged once per control cycle."""

    @property
    def period(self) -> float:
        """Length of one control cycle [s]."""

    @property
    def devices(self) -> Mapping[str, DeviceSpec[Any, Any]]:
        """The devices that it drives, by id."""

    @property
    def kind(self) -> str:
        """Name of the adapter ("pybullet", "fake"); skills may have an implementation for one kind only."""

    @property
    def braking_time(self) -> float:
        """Longest time from full speed to standstill, as its snapshots say it, when commands cease [s]."""

    def read(self) -> Snapshot:
        """Returns the current state without advancing time."""

    def exchange(self, commands: Commands) -> Snapshot:
        """Applies the commands for one period and returns what the sensors say at its end.

        While the cell is halted it ignores the commands.

        Raises:
            DeviceError: A device broke.
        """

    def halt(self) -> None:
        """Brakes everything and ignores all commands until :meth:`release`; what is gripped stays gripped.

        May be called in any thread and at any time, also during :meth:`exchange`; returns at once and waits for
        nothing. A simulation, whose time stands still between two exchanges, brakes with the next one.
        """

    def release(self) -> None:
        """Obeys commands again; nothing moves by that alone."""

    def capture(self, camera: str) -> Pending[DepthImage]:
        """Takes a picture now; the image arrives after the camera's latency.

        Args:
            camera: Device id of the camera.

        Raises:
            DeviceError: No such camera.
        """

    def close(self) -> None:
        """Brings everything down; waits for its processes. May be called twice."""


def require_known(commands: Commands, known: Collection[str]) -> None:
    """Refuses commands for devices that a driver does not have.

    Raises:
        DeviceError: There is one.
    """
    for device in commands:
        if device not in known:
            raise DeviceError(f"no device '{device}'; there is {', '.join(sorted(known)) or 'none'}")


def exchange_with(driver: CellDriver, commands: Commands, last: Snapshot) -> Snapshot:
    """Exchanges a driver's commands for one period; what it does wrong is an error with its name.

    Args:
        driver: The driver.
        commands: The commands.
        last: Its last snapshot.

    Raises:
        DeviceError: A device broke; or the driver raises, or does not return the snapshot of a later cycle.
    """
    try:
        now: object = driver.exchange(commands)
    except SkirosError:
        raise
    except Exception as error:
        raise DeviceError(f"driver '{driver.kind}': its exchange raised {type(error).__name__}: {error}") from error
    if not isinstance(now, Snapshot):
        raise DeviceError(f"driver '{driver.kind}': its exchange returned {now!r:.80}, not a Snapshot")
    if now.cycle <= last.cycle:
        raise DeviceError(f"driver '{driver.kind}': its exchange returned cycle {now.cycle} after cycle {last.cycle}")
    return now


class ModelCell:
    """Base of drivers whose devices are models: knows the last snapshot, and ignores commands while it is halted.

    Args:
        devices: The devices, by id.
    """

    period: float = _PERIOD
    """Length of one control cycle [s]."""
    coming_to_rest: ClassVar[float] = _PERIOD
    """Time from the last braking command until the snapshots say that all stands [s]."""
    _models: DeviceModels

    def __init__(self, devices: Mapping[str, DeviceSpec[Any, Any]]) -> None:
        self.devices = devices
        self._halted = False
        self._snapshot = Snapshot(0, 0.0)

    @property
    def braking_time(self) -> float:
        """Longest time from full speed to standstill, as its snapshots say it [s]."""
        return self._models.braking_time + self.coming_to_rest

    def read(self) -> Snapshot:
        """Returns the current state without advancing time."""
        return self._snapshot

    def exchange(self, commands: Commands) -> Snapshot:
        """Applies the commands for one period and returns what the sensors say at its end.

        Raises:
            DeviceError: A command is malformed or for a device that does not exist, or a device broke.
        """
        require_known(commands, self._snapshot.devices)
        self._step({} if self._halted else commands)
        cycle = self._snapshot.cycle + 1
        self._snapshot = Snapshot(cycle, cycle * self.period, self._models.states())
        return self._snapshot

    def halt(self) -> None:
        """Brakes everything from the next exchange on, whatever is commanded; for any thread."""
        self._halted = True

    def release(self) -> None:
        """Obeys commands again."""
        self._halted = False

    def contain(self, guard: KindGuard) -> None:
        """Runs the code of kinds under a guard."""
        self._models.contain(guard)

    def _step(self, commands: Commands) -> None:
        """Applies the commands and advances time by one period."""
        self._models.command(commands)


@runtime_checkable
class RunsKinds(Protocol):
    """A driver that itself runs code of kinds of device."""

    def contain(self, guard: KindGuard) -> None:
        """Runs that code under a guard from now on."""


def contain_kinds(driver: object, guard: KindGuard) -> None:
    """Has a driver run the code of kinds under a guard, where it runs any."""
    if isinstance(driver, RunsKinds):
        driver.contain(guard)


class CompositeDriver:
    """A :class:`~skiros_py.ports.driver.CellDriver` made of several, which are exchanged one after the other.

    Args:
        drivers: The drivers; the first is that of the cell, which says the kind.

    Attributes:
        drivers: The drivers.
        devices: The devices of all, by id.
        period: Length of one control cycle [s].
        kind: Kind of the cell's own driver.

    Raises:
        UsageError: Their periods differ, or two of them drive one device.
    """

    def __init__(self, drivers: Sequence[CellDriver]) -> None:
        self.drivers = tuple(drivers)
        self.period, self.kind = drivers[0].period, drivers[0].kind
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
        self._last = [driver.read() for driver in self.drivers]
        self._snapshot = self._merged(0)

    @property
    def braking_time(self) -> float:
        """Longest time from full speed to standstill [s]."""
        return max(driver.braking_time for driver in self.drivers)

    def read(self) -> Snapshot:
        """Returns the current state without advancing time."""
        return self._snapshot

    def exchange(self, commands: Commands) -> Snapshot:
        """Exchanges each driver's commands for one period, and returns what the sensors of all say at its end.

        Raises:
            DeviceError: A device broke, or a command is for a device that does not exist.
        """
        require_known(commands, self.devices)
        for number, driver in enumerate(self.drivers):
            own = {device: target for device, target in commands.items() if device in driver.devices}
            self._last[number] = exchange_with(driver, own, self._last[number])
        self._snapshot = self._merged(self._snapshot.cycle + 1)
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

    def contain(self, guard: KindGuard) -> None:
        """Runs the code of kinds under a guard."""
        for driver in self.drivers:
            contain_kinds(driver, guard)

    def _merged(self, cycle: int) -> Snapshot:
        devices = {device: state for snapshot in self._last for device, state in snapshot.devices.items()}
        return Snapshot(cycle, cycle * self.period, devices)


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
        self._guard: KindGuard | None = None
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
        if self._guard is not None:
            contain_kinds(driver, self._guard)
        first, last = driver.read(), self._snapshot
        self._ahead = last.cycle - first.cycle, last.time - first.time
        self._driver = driver

    def contain(self, guard: KindGuard) -> None:
        """Runs the code of kinds under a guard."""
        self._guard = guard
        contain_kinds(self._driver, guard)

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
