"""What generators of scenes draw from: half of each range is kept for the final campaign."""

from __future__ import annotations

import math

import numpy as np


class Chance:
    """Draws from one half of each range, by the parity of the seed: odd seeds from the lower, even ones from the upper.

    What is mended is tried on odd seeds, and judged on both.

    Args:
        seed: Seed of all draws.
    """

    def __init__(self, seed: int) -> None:
        self._rng = np.random.default_rng(seed)
        self._lower = seed % 2

    def within(self, low: float, high: float) -> float:
        """Returns a number of the half range."""
        middle = (low + high) / 2.0
        return float(self._rng.uniform(low, middle) if self._lower else self._rng.uniform(middle, high))

    def sign(self) -> float:
        """Returns 1 or -1."""
        return float(self._rng.choice((-1.0, 1.0)))

    def turn(self) -> float:
        """Returns any angle [rad]."""
        return float(self._rng.uniform(-math.pi, math.pi))

    def order(self, count: int) -> list[int]:
        """Returns the numbers from 0 in random order."""
        return [int(number) for number in self._rng.permutation(count)]

    def posture(self, lower: np.ndarray, upper: np.ndarray) -> np.ndarray:
        """Returns any joint angles within limits [rad]."""
        return np.asarray(self._rng.uniform(lower, upper))
