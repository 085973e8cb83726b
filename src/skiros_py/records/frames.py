"""Snapshots of the devices as numbers in blocks: small on disk, exact to a hundredth of a millimetre or milliradian."""

from __future__ import annotations

import zlib
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from skiros_py.robot.values import Snapshot

__all__ = ["Frame", "Layout", "decode_block", "encode_block"]

_QUANTUM = 1e-5
"""What numbers are rounded to [m, rad]."""
_TICK = 1e-4
"""What times are rounded to [s]."""
_LEVEL = 6


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
        arms = tuple((name, len(arm.positions)) for name, arm in snapshot.arms.items())
        return cls(arms, tuple(snapshot.grippers), tuple(snapshot.bases))

    @classmethod
    def from_json(cls, data: dict[str, list[list[object]]]) -> Layout:
        """Reads what :meth:`as_json` gave.

        Raises:
            KeyError, TypeError, ValueError: It is no such thing.
        """
        arms = tuple((str(name), int(str(count))) for name, count in data["arms"])
        return cls(arms, tuple(map(str, data["grippers"])), tuple(map(str, data["bases"])))

    def as_json(self) -> dict[str, object]:
        """Returns plain data."""
        return {"arms": [list(arm) for arm in self.arms], "grippers": list(self.grippers), "bases": list(self.bases)}

    @property
    def width(self) -> int:
        """How many numbers a row has."""
        return sum(count for _, count in self.arms) + len(self.grippers) + 3 * len(self.bases)

    def row(self, snapshot: Snapshot) -> list[float]:
        """Returns the numbers of a snapshot."""
        row: list[float] = []
        for name, _ in self.arms:
            row += snapshot.arms[name].positions
        row += [snapshot.grippers[name].gap for name in self.grippers]
        for name in self.bases:
            pose = snapshot.bases[name].pose
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
    table = np.column_stack([np.asarray(times) / _TICK, np.asarray(rows, dtype=float).reshape(len(times), -1) / _QUANTUM])
    whole = np.rint(np.nan_to_num(table)).astype("<i8")
    steps = np.diff(whole, axis=0, prepend=np.zeros((1, whole.shape[1]), dtype="<i8"))
    return zlib.compress(np.ascontiguousarray(steps.T).tobytes(), _LEVEL)


def decode_block(data: bytes, layout: Layout) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Unpacks times [s] and rows.

    Raises:
        ValueError: It is no such block.
    """
    try:
        steps = np.frombuffer(zlib.decompress(data), dtype="<i8").reshape(layout.width + 1, -1).T
    except (zlib.error, TypeError) as error:
        raise ValueError(f"no block of snapshots: {error}") from None
    whole = np.cumsum(steps, axis=0)
    return whole[:, 0] * _TICK, whole[:, 1:] * _QUANTUM
