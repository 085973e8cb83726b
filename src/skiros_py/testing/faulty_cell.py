"""A driver around any other driver that adds faults, which are plain data.

Each begins ``after`` seconds of run time after the start and lasts for ``for_`` seconds.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from skiros_py.errors import DeviceError, UnknownName
from skiros_py.ports.device import DeviceSpec
from skiros_py.ports.driver import CellDriver, contain_kinds
from skiros_py.ports.guard import KindGuard
from skiros_py.ports.values import Commands, DepthImage, Pending, Snapshot


@dataclass(frozen=True, slots=True)
class Deaf:
    """A device does not receive its commands, so that it executes its default safe task."""

    device: str
    after: float = 0.0
    for_: float = math.inf


@dataclass(frozen=True, slots=True)
class Frozen:
    """A device keeps reporting its state at the start of the fault."""

    device: str
    after: float = 0.0
    for_: float = math.inf


@dataclass(frozen=True, slots=True)
class Says:
    """A device reports a given state instead of its true one, such as a part between the fingers of a fake gripper."""

    device: str
    state: object
    after: float = 0.0
    for_: float = math.inf


@dataclass(frozen=True, slots=True)
class Noisy:
    """The position reported by a device has a random error in each cycle.

    Attributes:
        device: Its id.
        sigma: Standard deviation: of each joint [rad], of the gap [m], of x and y of a base [m] and its heading [rad].
        after, for_: Start and duration [s].
        seed: Seed of the noise.
    """

    device: str
    sigma: float
    after: float = 0.0
    for_: float = math.inf
    seed: int = 0


@dataclass(frozen=True, slots=True)
class Dies:
    """The connection to the cell is lost: every exchange raises DeviceError. ``device`` is named in its text."""

    after: float = 0.0
    device: str = "the cell"
    for_: float = math.inf


@dataclass(frozen=True, slots=True)
class Blind:
    """A camera does not answer: requesting a picture raises DeviceError."""

    device: str
    after: float = 0.0
    for_: float = math.inf


@dataclass(frozen=True, slots=True)
class Late:
    """A camera's pictures arrive with a delay [s]."""

    device: str
    seconds: float
    after: float = 0.0
    for_: float = math.inf


CellFault = Deaf | Frozen | Says | Noisy | Dies | Blind | Late


def heard(fault: CellFault, commands: Commands) -> Commands:
    """Returns the commands that get past a fault."""
    if not isinstance(fault, Deaf):
        return commands
    return {device: target for device, target in commands.items() if device != fault.device}


def said(
    fault: CellFault,
    now: Snapshot,
    onset: Snapshot,
    rng: np.random.Generator,
    devices: Mapping[str, DeviceSpec[Any, Any]],
) -> Snapshot:
    """Returns what devices report under a fault.

    Args:
        fault: The fault.
        now: Their true states.
        onset: Their states at the start of the fault.
        rng: Its random numbers.
        devices: The devices of the cell.
    """
    match fault:
        case Frozen(device):
            state = onset.devices[device]
        case Says(device, state):
            pass
        case Noisy(device, sigma):
            state = devices[device].noisy(now.devices[device], sigma, rng)
        case _:
            return now
    return replace(now, devices={**now.devices, device: state})


class FaultyCell:
    """A :class:`skiros_py.ports.driver.CellDriver` that forwards everything, except for its faults.

    >>> cell = FaultyCell(FakeCell(spec), Deaf("base_1", after=2.0), Dies(after=10.0))

    Args:
        driver: The cell.
        *faults: The faults, applied in this order.

    Attributes:
        devices: The devices, by id.

    Raises:
        UnknownName: A fault is for a device that the cell does not have.
    """

    def __init__(self, driver: CellDriver, *faults: CellFault) -> None:
        self._driver = driver
        self._faults = [_Fault(fault, driver.devices) for fault in faults]
        start = driver.read()
        self.devices = driver.devices
        for fault in faults:
            if not isinstance(fault, Dies | Blind | Late) and fault.device not in start.devices:
                raise UnknownName("device", fault.device, start.devices, where=f"in {fault}")
        self._snapshot = self._reported(start)

    @property
    def period(self) -> float:
        """Length of one control cycle [s]."""
        return self._driver.period

    @property
    def kind(self) -> str:
        """Name of the adapter inside."""
        return self._driver.kind

    @property
    def braking_time(self) -> float:
        """Longest time from full speed to standstill [s]."""
        return self._driver.braking_time

    def read(self) -> Snapshot:
        """Returns the present state, as reported, without advancing time."""
        return self._snapshot

    def exchange(self, commands: Commands) -> Snapshot:
        """Applies the received commands for one period, and returns the reported state at its end.

        Raises:
            DeviceError: The cell is dead, or a device inside has failed.
        """
        for fault in self._active():
            if isinstance(fault, Dies):
                raise DeviceError(f"{fault.device} does not answer")
            commands = heard(fault, commands)
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
        active = [fault for fault in self._active() if isinstance(fault, Blind | Late) and fault.device == camera]
        if any(isinstance(fault, Blind) for fault in active):
            raise DeviceError(f"camera '{camera}' does not answer")
        picture = self._driver.capture(camera)
        late = sum(fault.seconds for fault in active if isinstance(fault, Late))
        return _Delayed(picture, late) if late else picture

    def contain(self, guard: KindGuard) -> None:
        """Runs the code of kinds of the cell inside under a guard."""
        contain_kinds(self._driver, guard)

    def close(self) -> None:
        """Closes the cell inside."""
        self._driver.close()

    def _active(self) -> Iterable[CellFault]:
        return [fault.fault for fault in self._faults if fault.active(self._snapshot.time)]

    def _reported(self, snapshot: Snapshot) -> Snapshot:
        for fault in self._faults:
            snapshot = fault.reported(snapshot)
        return snapshot


class _Fault:
    """The state of one fault in one cell."""

    def __init__(self, fault: CellFault, devices: Mapping[str, DeviceSpec[Any, Any]]) -> None:
        self.fault = fault
        self._devices = devices
        self._onset: Snapshot | None = None
        self._rng = np.random.default_rng(fault.seed if isinstance(fault, Noisy) else 0)

    def active(self, time: float) -> bool:
        return self.fault.after <= time < self.fault.after + self.fault.for_

    def reported(self, snapshot: Snapshot) -> Snapshot:
        if not self.active(snapshot.time):
            self._onset = None
            return snapshot
        self._onset = self._onset or snapshot
        return said(self.fault, snapshot, self._onset, self._rng, self._devices)


class _Delayed(Pending[DepthImage]):
    """A picture that takes longer."""

    def __init__(self, picture: Pending[DepthImage], seconds: float) -> None:
        self._picture = picture
        self._latency = picture.latency + seconds

    @property
    def latency(self) -> float:
        return self._latency

    def done(self) -> bool:
        return self._picture.done()

    def result(self) -> DepthImage:
        return self._picture.result()
