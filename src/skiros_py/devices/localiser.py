"""Where the robot believes to be: the truth and an error as a laser localiser makes it."""

from __future__ import annotations

import math

import numpy as np

from skiros_py.geometry import Array

POSITION_SIGMA = 0.005
"""Standard deviation of the error in x and in y [m]."""

YAW_SIGMA = math.radians(0.3)
"""Standard deviation of the error of the heading [rad]."""

_FADE = 0.5  # way [m], turning counted as [rad], after which an error has nothing in common with the one before


class Localiser:
    """Estimates the planar pose of a base.

    The error stays the same while the base stands, and is another one at each place it drives to. On the way it fades
    smoothly from the old one to the new one: the blend is a rotation, so its size stays that of one draw all the way.

    Args:
        rng: Source of the errors.
    """

    def __init__(self, rng: np.random.Generator) -> None:
        self._rng = rng
        self._old = self._draw()
        self._new = self._old
        self._faded = 1.0
        self._standing = True

    def estimate(self, x: float, y: float, yaw: float, way: float, standing: bool) -> tuple[float, float, float]:
        """Returns the estimated pose in the map.

        Args:
            x: True position [m].
            y: True position [m].
            yaw: True heading [rad].
            way: What the base moved in this cycle [m], turning included [rad].
            standing: Whether the base stands.
        """
        if self._standing and not standing:
            self._old, self._new, self._faded = self._error(), self._draw(), 0.0
        self._standing = standing
        if not standing:
            self._faded = min(1.0, self._faded + way / _FADE)
        ex, ey, eyaw = self._error().tolist()
        return x + ex, y + ey, yaw + eyaw

    def _error(self) -> Array:
        if self._faded >= 1.0:
            return self._new
        angle = self._faded * math.pi / 2.0
        return np.asarray(math.cos(angle) * self._old + math.sin(angle) * self._new)

    def _draw(self) -> Array:
        return self._rng.normal(size=3) * (POSITION_SIGMA, POSITION_SIGMA, YAW_SIGMA)
