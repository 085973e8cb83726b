"""Small pieces of motion control that the simulated devices share."""

from __future__ import annotations

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
