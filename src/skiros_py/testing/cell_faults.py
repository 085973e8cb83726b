"""Faults of devices, as plain data: what :class:`~skiros_py.testing.faulty_cell.FaultyCell` does to a cell.

Each begins so many seconds of run time after the start (``after``) and lasts for so many (``for_``).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np

from skiros_py.geometry import Pose
from skiros_py.ports.values import ArmState, BaseState, Commands, GripperState, Snapshot

__all__ = ["Blind", "CellFault", "Deaf", "Dies", "Frozen", "Late", "Noisy", "Says", "heard", "said"]

DeviceState = ArmState | GripperState | BaseState
T = TypeVar("T")


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
    state: DeviceState
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
    arms, grippers, bases = (_without(m, fault.device) for m in (commands.arms, commands.grippers, commands.bases))
    return Commands(arms, grippers, bases)  # type: ignore[arg-type]  # each mapping keeps its own kind of values


def said(fault: CellFault, now: Snapshot, onset: Snapshot, rng: np.random.Generator) -> Snapshot:
    """Returns what devices report under a fault.

    Args:
        fault: The fault.
        now: What they say in truth.
        onset: What they said when it began.
        rng: Its random numbers.
    """
    match fault:
        case Frozen(device):
            return _with_state(now, device, _state_of(onset, device))
        case Says(device, state):
            return _with_state(now, device, state)
        case Noisy(device, sigma):
            return _with_state(now, device, _blurred(_state_of(now, device), sigma, rng))
        case _:
            return now


def _state_of(snapshot: Snapshot, device: str) -> DeviceState:
    """Returns what a device said."""
    for states in (snapshot.arms, snapshot.grippers, snapshot.bases):
        if device in states:
            state: DeviceState = states[device]
            return state
    raise KeyError(device)


def _with_state(snapshot: Snapshot, device: str, state: DeviceState) -> Snapshot:
    """Returns a snapshot in which a device says something else."""
    match state:
        case ArmState():
            return replace(snapshot, arms={**snapshot.arms, device: state})
        case GripperState():
            return replace(snapshot, grippers={**snapshot.grippers, device: state})
        case BaseState():
            return replace(snapshot, bases={**snapshot.bases, device: state})


def _blurred(state: DeviceState, sigma: float, rng: np.random.Generator) -> DeviceState:
    match state:
        case ArmState(positions):
            blurred = np.asarray(positions) + rng.normal(0.0, sigma, len(positions))
            return replace(state, positions=tuple(map(float, blurred)))
        case GripperState(gap):
            return replace(state, gap=max(0.0, gap + rng.normal(0.0, sigma)))
        case BaseState(pose):
            x, y, turn = map(float, rng.normal(0.0, sigma, 3))
            return replace(state, pose=pose @ Pose.of(x, y, 0.0, yaw=turn))


def _without(values: Mapping[str, T], device: str) -> dict[str, T]:
    return {key: value for key, value in values.items() if key != device}
