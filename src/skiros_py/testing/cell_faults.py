"""Faults of devices, as plain data: what :class:`~skiros_py.testing.faulty_cell.FaultyCell` does to a cell.

Each begins so many seconds of run time after the start (``after``) and lasts for so many (``for_``).
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
    """A device does not hear its commands: it does its default safe task."""

    device: str
    after: float = 0.0
    for_: float = math.inf


@dataclass(frozen=True, slots=True)
class Frozen:
    """A device goes on reporting what it said when the fault began."""

    device: str
    after: float = 0.0
    for_: float = math.inf


@dataclass(frozen=True, slots=True)
class Says:
    """A device reports a given state, whatever it does: a part between the fingers of a fake gripper, say."""

    device: str
    state: object
    after: float = 0.0
    for_: float = math.inf


@dataclass(frozen=True, slots=True)
class Noisy:
    """What a device says of where it is is wrong by a random amount each cycle.

    Attributes:
        device: Its id.
        sigma: Standard deviation: of each joint [rad], of the gap [m], of x and y of a base [m] and its heading [rad].
        after, for_: When [s].
        seed: Seed of the noise.
    """

    device: str
    sigma: float
    after: float = 0.0
    for_: float = math.inf
    seed: int = 0


@dataclass(frozen=True, slots=True)
class Dies:
    """The connection to the cell breaks: every exchange raises DeviceError. ``device`` is named in its text."""

    after: float = 0.0
    device: str = "the cell"
    for_: float = math.inf


@dataclass(frozen=True, slots=True)
class Blind:
    """A camera does not answer: asking it for a picture raises DeviceError."""

    device: str
    after: float = 0.0
    for_: float = math.inf


@dataclass(frozen=True, slots=True)
class Late:
    """A camera's pictures arrive so much later [s]."""

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
        now: What they say in truth.
        onset: What they said when it began.
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
