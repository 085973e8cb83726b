"""Faults of devices, as plain data, for :class:`~skiros_py.testing.faulty_cell.FaultyCell`.

Each begins ``after`` seconds of run time after the start and lasts for ``for_`` seconds.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from skiros_py.ports.device import DeviceSpec
from skiros_py.ports.values import Commands, Snapshot


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
