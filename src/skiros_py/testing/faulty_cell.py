"""A driver around any other driver that adds faults, which are plain data."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from skiros_py.errors import DeviceError, UnknownName
from skiros_py.ports.device_faults import KindGuard
from skiros_py.ports.driver import CellDriver, contain_kinds
from skiros_py.ports.values import Commands, DepthImage, Pending, Snapshot


@dataclass(frozen=True, slots=True, kw_only=True)
class CellFault:
    """A fault of a cell.

    Attributes:
        after: Start [s, run time].
        for_: Duration [s].
    """

    after: float = 0.0
    for_: float = math.inf


@dataclass(frozen=True, slots=True)
class Deaf(CellFault):
    """A device does not receive its commands, so that it executes its default safe task."""

    device: str


@dataclass(frozen=True, slots=True)
class Frozen(CellFault):
    """A device keeps reporting its state at the start of the fault."""

    device: str


@dataclass(frozen=True, slots=True)
class Says(CellFault):
    """A device reports a given state instead of its true one, such as a part between the fingers of a fake gripper."""

    device: str
    state: object


@dataclass(frozen=True, slots=True)
class Noisy(CellFault):
    """The position reported by a device has a random error in each cycle.

    Attributes:
        device: Its id.
        sigma: Standard deviation: of each joint [rad], of the gap [m], of x and y of a base [m] and its heading [rad].
        seed: Seed of the noise.
    """

    device: str
    sigma: float
    seed: int = 0


@dataclass(frozen=True, slots=True)
class Dies(CellFault):
    """The connection to the cell is lost: every exchange raises DeviceError. ``device`` is named in its text."""

    device: str = "the cell"


@dataclass(frozen=True, slots=True)
class Unplugged(CellFault):
    """A device does not answer any more: it is switched off, as by an error in its driver, and stays so."""

    device: str


@dataclass(frozen=True, slots=True)
class Blind(CellFault):
    """A camera does not answer: requesting a picture raises DeviceError."""

    device: str


@dataclass(frozen=True, slots=True)
class Late(CellFault):
    """A camera's pictures arrive with a delay [s]."""

    device: str
    seconds: float


class FaultyCell:
    """A :class:`skiros_py.ports.driver.CellDriver` that forwards everything, except for its faults.

    >>> cell = FaultyCell(FakeCell(spec), Deaf("base_1", after=2.0), Dies(after=10.0))

    Args:
        driver: The cell.
        *faults: The faults, applied in this order.

    Attributes:
        devices: The devices, by id.
        period: Length of one control cycle [s].
        kind: Name of the adapter inside.

    Raises:
        UnknownName: A fault is for a device that the cell does not have.
    """

    def __init__(self, driver: CellDriver, *faults: CellFault) -> None:
        self._driver = driver
        self._faults = faults
        self._generators = [np.random.default_rng(fault.seed if isinstance(fault, Noisy) else 0) for fault in faults]
        self._onsets: dict[int, Snapshot] = {}
        self._guard = KindGuard()
        self.devices = driver.devices
        self.period, self.kind = driver.period, driver.kind
        start = driver.read()
        for fault in faults:
            if isinstance(fault, Deaf | Frozen | Says | Noisy | Unplugged) and fault.device not in start.devices:
                raise UnknownName("device", fault.device, start.devices, where=f"in {fault}")
        self._snapshot = self._reported(start)

    @property
    def braking_time(self) -> float:
        """Longest time from full speed to standstill [s]."""
        return self._driver.braking_time

    def read(self) -> Snapshot:
        """Returns the current state, as reported, without advancing time."""
        return self._snapshot

    def exchange(self, commands: Commands) -> Snapshot:
        """Applies the received commands for one period, and returns the reported state at its end.

        Raises:
            DeviceError: The cell is dead, or a device inside has failed.
        """
        for _, fault in self._active(self._snapshot.time):
            if isinstance(fault, Dies):
                raise DeviceError(f"{fault.device} does not answer")
            if isinstance(fault, Deaf):
                commands = {device: target for device, target in commands.items() if device != fault.device}
            if isinstance(fault, Unplugged):
                self._guard.switch_off(self.devices[fault.device], "it does not answer")
        self._snapshot = self._reported(self._driver.exchange(commands))
        return self._snapshot

    def halt(self) -> None:
        """Brakes everything."""
        self._driver.halt()

    def release(self) -> None:
        """Accepts commands again."""
        self._driver.release()

    def capture(self, camera: str) -> Pending[DepthImage]:
        """Takes a picture now.

        Raises:
            DeviceError: The camera does not answer.
        """
        late = 0.0
        for _, fault in self._active(self._snapshot.time):
            if isinstance(fault, Blind) and fault.device == camera:
                raise DeviceError(f"camera '{camera}' does not answer")
            if isinstance(fault, Late) and fault.device == camera:
                late += fault.seconds
        picture = self._driver.capture(camera)
        return _Delayed(picture, picture.latency + late) if late else picture

    def contain(self, guard: KindGuard) -> None:
        """Runs the code of kinds of the cell inside under a guard."""
        self._guard = guard
        contain_kinds(self._driver, guard)

    def close(self) -> None:
        """Closes the cell inside."""
        self._driver.close()

    def _active(self, time: float) -> Iterator[tuple[int, CellFault]]:
        for number, fault in enumerate(self._faults):
            if fault.after <= time < fault.after + fault.for_:
                yield number, fault
            else:
                self._onsets.pop(number, None)

    def _reported(self, snapshot: Snapshot) -> Snapshot:
        """Returns what devices report under the faults."""
        for number, fault in self._active(snapshot.time):
            onset = self._onsets.setdefault(number, snapshot)
            match fault:
                case Frozen():
                    state = onset.devices[fault.device]
                case Says():
                    state = fault.state
                case Noisy():
                    true = snapshot.devices[fault.device]
                    state = self.devices[fault.device].noisy(true, fault.sigma, self._generators[number])
                case _:
                    continue
            snapshot = replace(snapshot, devices={**snapshot.devices, fault.device: state})
        return snapshot


@dataclass(frozen=True, slots=True)
class _Delayed:
    """A picture that takes longer."""

    picture: Pending[DepthImage]
    latency: float

    def done(self) -> bool:
        return self.picture.done()

    def result(self) -> DepthImage:
        return self.picture.result()
