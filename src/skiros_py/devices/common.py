"""Common to several device kinds: a rate limit, standstill detection and a fake without physics."""

from __future__ import annotations

from collections.abc import Callable
from typing import Generic, TypeVar

StateT = TypeVar("StateT")
TargetT = TypeVar("TargetT")

BASE_STILL = 0.002
"""Speed below which what moves a robot counts as slow [m/s], turning counted as [rad/s]."""

_QUIET_CYCLES = 10  # a drive that reverses is slow for an instant without standing


def approach(value: float, target: float, step: float) -> float:
    """Returns ``value`` moved towards ``target`` by at most ``step``."""
    return min(max(target, value - step), value + step)


class Standstill:
    """Tells whether a device stands: slower than a threshold for 10 cycles on end.

    Args:
        threshold: Speed below which it counts as slow, in the device's unit per second.
    """

    def __init__(self, threshold: float) -> None:
        self._threshold = threshold
        self._quiet = _QUIET_CYCLES

    def update(self, speed: float) -> bool:
        """Takes this cycle's speed and returns whether the device stands."""
        self._quiet = self._quiet + 1 if abs(speed) < self._threshold else 0
        return self._quiet >= _QUIET_CYCLES


class FakeModel(Generic[StateT, TargetT]):
    """A device without physics, which does at once what it is commanded to.

    Args:
        state: Its state at the start.
        after: Returns the state after a cycle, from the state before and the target, or None for no target.
    """

    braking_time = 0.0

    def __init__(self, state: StateT, after: Callable[[StateT, TargetT | None], StateT]) -> None:
        self._state = state
        self._after = after

    def command(self, target: TargetT | None) -> None:
        """Does it."""
        self._state = self._after(self._state, target)

    def state(self) -> StateT:
        """Returns the state."""
        return self._state
