"""Trajectories of joints that need no planner, and playing trajectories on the clock of the cycle."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from skiros_py.devices.arm import ArmTarget
from skiros_py.ports.motion import Trajectory

_SAME = 1e-6
"""Clock times that differ by less than this fraction of a period count as equal."""


class Playback:
    """Samples a trajectory at the time that has passed on a clock; the path is independent of the clock's speed.

    Args:
        trajectory: Samples, one per period.
        period: The control period [s].
        now: Time on the clock when it begins [s].
    """

    def __init__(self, trajectory: Trajectory, period: float, now: float) -> None:
        self._trajectory = trajectory
        self._period = period
        self._start = now
        self._last = now - period
        self._sample = 0.0

    @property
    def sample(self) -> int:
        """Number of the sample that was returned last, rounded down."""
        return int(self._sample)

    @property
    def ended(self) -> bool:
        """True once the last sample has been returned."""
        return self._sample >= len(self._trajectory.positions) - 1

    def target(self, now: float) -> ArmTarget:
        """Returns the set-point for the end of the coming cycle, assuming the clock runs as in the last one.

        Args:
            now: Time on the clock, once per cycle [s].
        """
        rate = min(1.0, _rounded((now - self._last) / self._period))
        self._last = now
        passed = _rounded((now - self._start) / self._period)
        self._sample = min(passed + rate, float(len(self._trajectory.positions) - 1))
        before, share = int(self._sample), self._sample % 1.0
        positions, velocities = self._trajectory.positions[before], self._trajectory.velocities[before]
        if share > 0.0:
            positions = positions + share * (self._trajectory.positions[before + 1] - positions)
            velocities = velocities + share * (self._trajectory.velocities[before + 1] - velocities)
        return ArmTarget(tuple(positions.tolist()), tuple((rate * velocities).tolist()))


def _rounded(periods: float) -> float:
    """Returns a whole number if within rounding error: on a regular clock each sample is hit exactly."""
    whole = math.floor(periods + 0.5)
    return float(whole) if abs(periods - whole) < _SAME else periods


UNPLANNED_SPEED = 0.3
"""Mean joint speed of a motion without a planner [rad/s]."""


def even(start: Sequence[float], goal: Sequence[float], period: float) -> Trajectory:
    """Returns a straight motion from rest to rest, for arms without a planner.

    Args:
        start: Joint angles where it begins [rad].
        goal: Joint angles where it ends [rad].
        period: Time between two samples [s].
    """
    way = np.asarray(goal) - np.asarray(start)
    count = max(2, int(np.ceil(np.abs(way).max(initial=0.0) / UNPLANNED_SPEED / period)) + 1)
    share = np.linspace(0.0, 1.0, count)[:, None]
    smooth, rate = share**2 * (3.0 - 2.0 * share), 6.0 * share * (1.0 - share) / ((count - 1) * period)
    return Trajectory(np.asarray(start) + smooth * way, rate * way)


def moved_to(way: Trajectory, start: Sequence[float], period: float) -> Trajectory:
    """Returns a motion that begins elsewhere, and comes to its own way evenly until its end.

    Args:
        way: The motion.
        start: Joint angles where it begins [rad].
        period: Time between two samples [s].
    """
    off = np.asarray(start) - way.positions[0]
    share = np.linspace(0.0, 1.0, len(way.positions))[:, None]
    left, rate = 1.0 - share**2 * (3.0 - 2.0 * share), -6.0 * share * (1.0 - share) / ((len(share) - 1) * period)
    return Trajectory(way.positions + left * off, way.velocities + rate * off)


def reversed_way(way: Trajectory, *, slower: int = 1) -> Trajectory:
    """Returns a motion from the end of another one to its beginning, so many times slower."""
    last = len(way.positions) - 1
    steps = np.linspace(last, 0, slower * last + 1)
    positions, velocities = (
        np.column_stack([np.interp(steps, range(last + 1), column) for column in one.T])
        for one in (way.positions, way.velocities)
    )
    return Trajectory(positions, -velocities / slower)
