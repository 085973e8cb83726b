"""Snapshots of the devices as numbers in blocks: small on disk, exact to a hundredth of a millimetre or milliradian."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skiros_py.devices.arm import ArmState
from skiros_py.devices.base import BaseState
from skiros_py.devices.gripper import GripperState
from skiros_py.ports.values import Snapshot

__all__ = ["Frame", "Layout", "decode_block", "encode_block", "key_block"]

_QUANTUM = 1e-5
"""What numbers are rounded to [m, rad]."""
_TICK = 1e-4
"""What times are rounded to [s]."""
_LEVEL = 6
_WIDTH = struct.Struct("<H")
"""A block begins with how many numbers a row has, the time among them."""


@dataclass(frozen=True, slots=True)
class Frame:
    """Where the devices were at one moment.

    Attributes:
        time: Run time [s].
        arms: Joint angles [rad] by arm id.
        grippers: Distance between the finger pads [m] by gripper id.
        bases: Estimated x [m], y [m] and heading [rad] in the map by base id.
    """

    time: float
    arms: dict[str, tuple[float, ...]]
    grippers: dict[str, float]
    bases: dict[str, tuple[float, float, float]]


@dataclass(frozen=True, slots=True)
class Layout:
    """Which number of a row is what.

    Attributes:
        arms: Id and number of joints of each arm.
        grippers, bases: Ids.
    """

    arms: tuple[tuple[str, int], ...]
    grippers: tuple[str, ...]
    bases: tuple[str, ...]

    @classmethod
    def of(cls, snapshot: Snapshot) -> Layout:
        """Returns the layout for the devices of a cell."""
        arms = tuple((name, len(arm.positions)) for name, arm in snapshot.of(ArmState).items())
        return cls(arms, tuple(snapshot.of(GripperState)), tuple(snapshot.of(BaseState)))

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> Layout:
        """Reads what :meth:`as_json` gave.

        Raises:
            KeyError, TypeError, ValueError: It is no such thing.
        """
        arms = tuple((str(name), int(count)) for name, count in data["arms"])
        return cls(arms, tuple(map(str, data["grippers"])), tuple(map(str, data["bases"])))

    def as_json(self) -> dict[str, object]:
        """Returns plain data."""
        return {"arms": [list(arm) for arm in self.arms], "grippers": list(self.grippers), "bases": list(self.bases)}

    def row(self, snapshot: Snapshot) -> list[float]:
        """Returns the numbers of a snapshot."""
        row: list[float] = []
        for name, _ in self.arms:
            row += snapshot.state(name, ArmState).positions
        row += [snapshot.state(name, GripperState).gap for name in self.grippers]
        for name in self.bases:
            pose = snapshot.state(name, BaseState).pose
            row += (pose.position[0], pose.position[1], pose.yaw)
        return row

    def frame(self, time: float, row: Sequence[float]) -> Frame:
        """Returns what a row says."""
        numbers = iter(row)
        arms = {name: tuple(next(numbers) for _ in range(count)) for name, count in self.arms}
        grippers = {name: next(numbers) for name in self.grippers}
        bases = {name: (next(numbers), next(numbers), next(numbers)) for name in self.bases}
        return Frame(time, arms, grippers, bases)


def encode_block(times: Sequence[float], rows: Sequence[Sequence[float]]) -> bytes:
    """Packs rows: as differences from one to the next, number by number, which are mostly zeros."""
    numbers = np.asarray(rows, dtype=float).reshape(len(times), -1) / _QUANTUM
    return _packed(np.column_stack([np.asarray(times) / _TICK, numbers]))


def decode_block(data: bytes) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Unpacks times [s] and rows.

    Raises:
        ValueError: It is no such block.
    """
    whole = _unpacked(data).astype(np.float64)
    return whole[:, 0] * _TICK, whole[:, 1:] * _QUANTUM


def key_block(data: bytes) -> tuple[bytes, int]:
    """Returns a block with the first snapshot alone, and how many others there were.

    Raises:
        ValueError: It is no such block.
    """
    whole = _unpacked(data)
    return _packed(whole[:1]), len(whole) - 1


def _packed(table: NDArray[Any]) -> bytes:
    whole = np.rint(np.nan_to_num(table)).astype("<i8")
    steps = np.diff(whole, axis=0, prepend=np.zeros((1, whole.shape[1]), dtype="<i8"))
    return _WIDTH.pack(whole.shape[1]) + zlib.compress(np.ascontiguousarray(steps.T).tobytes(), _LEVEL)


def _unpacked(data: bytes) -> NDArray[np.int64]:
    try:
        (width,) = _WIDTH.unpack_from(data)
        steps = np.frombuffer(zlib.decompress(data[_WIDTH.size :]), dtype="<i8").reshape(width, -1)
    except (zlib.error, struct.error, TypeError) as error:
        raise ValueError(f"no block of snapshots: {error}") from None
    return np.cumsum(steps.T, axis=0, dtype=np.int64)
