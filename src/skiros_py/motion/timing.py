"""Rounds the corners of a joint path, and gives it times, from rest to rest, within the joints' limits.

First the fastest speed along the path is found on a grid (forwards and backwards pass under the limits), then it is
averaged over a short window, which bounds the jerk; limits violated by the averaging are restored by stretching time.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicHermiteSpline, CubicSpline

from skiros_py.geometry import Array
from skiros_py.ports.motion import Trajectory

_STEP = 0.02  # [rad] between samples of the path
_WINDOWS = (0.5, 0.25, 0.12)  # [rad] lengths of path over which corners are rounded, widest first


def round_corners(way_points: Sequence[Array], clear: Callable[[Array], bool]) -> Array | None:
    """Rounds a path's corners as widely as its surroundings allow.

    Args:
        way_points: Joint angles [rad] with clear straight lines in between; at least two.
        clear: Returns whether a posture is free of collisions.

    Returns:
        Joint angles [rad] at even steps, shape (n, joints), from the first to the last way point; None when even the
        tightest rounding touches something.
    """
    path = _sampled(way_points)
    if len(way_points) == 2:
        return path
    for window in _WINDOWS:
        rounded = _averaged(path, max(1, round(window / _STEP / 2.0)))
        if all(clear(posture) for posture in rounded):
            return rounded
    return None


def _sampled(way_points: Sequence[Array]) -> Array:
    corners = np.array(way_points)
    lengths = np.linalg.norm(np.diff(corners, axis=0), axis=1)
    corners = corners[np.concatenate([[True], lengths > 1e-9])]
    along = np.concatenate([[0.0], np.cumsum(lengths[lengths > 1e-9])])
    places = np.linspace(0.0, along[-1], max(5, int(np.ceil(along[-1] / _STEP)) + 1))
    return np.column_stack([np.interp(places, along, column) for column in corners.T])


def _averaged(path: Array, half: int) -> Array:
    """Averages twice over a window; beyond its ends the path is mirrored through them, so they stay where they are."""
    half = min(half, (len(path) - 1) // 2)
    kernel = np.full(2 * half + 1, 1.0 / (2 * half + 1))
    for _ in range(2):
        before = 2.0 * path[0] - path[half:0:-1]
        after = 2.0 * path[-1] - path[-2 : -half - 2 : -1]
        extended = np.vstack([before, path, after])
        path = np.column_stack([np.convolve(column, kernel, mode="valid") for column in extended.T])
    return path


PERIOD = 1.0 / 200.0
"""Time between two samples of a trajectory: one control period [s]."""

_GRID = 160
_WINDOW = 0.08  # [s] over which the speed is averaged
_FINE = 0.001  # [s]
_REST = 1e-6  # [rad] a path shorter than this is no motion


@dataclass(frozen=True, slots=True, eq=False)
class JointLimits:
    """Greatest joint speeds [rad/s] and accelerations [rad/s²]."""

    velocity: Array
    acceleration: Array

    def scaled(self, share: float) -> JointLimits:
        """Returns a share of the limits."""
        return JointLimits(self.velocity * share, self.acceleration * share)


def time_path(path: Array, limits: JointLimits, path_rate: float | Array = math.inf) -> Trajectory:
    """Times a path.

    Args:
        path: Joint angles [rad] at even steps of the path parameter, which runs from 0 to 1; shape (n, joints), n >= 2.
        limits: What no joint may exceed.
        path_rate: Greatest rate of the path parameter [1/s]: tip speed over tip way for a straight line; or one for
            each row of the path.

    Returns:
        Samples every :data:`PERIOD`; the first is the path's first row, the last its last row, both at rest.
    """
    if np.abs(np.diff(path, axis=0)).sum() < _REST:
        return Trajectory(path[:1].copy(), np.zeros_like(path[:1]))
    curve = CubicSpline(_even(len(path)), path, bc_type="natural")
    profile = _Profile(_fastest(curve, limits, path_rate))
    duration = profile.duration * _stretch(curve, profile, limits)
    samples = math.ceil(duration / PERIOD) + 1
    share, rate, _ = profile.at(np.linspace(0.0, profile.duration, samples))
    slower = profile.duration / ((samples - 1) * PERIOD)
    positions, velocities = curve(share), curve(share, 1) * (rate * slower)[:, None]
    positions[0], positions[-1] = path[0], path[-1]
    velocities[0] = velocities[-1] = 0.0
    return Trajectory(positions, velocities)


def _fastest(curve: CubicSpline, limits: JointLimits, path_rate: float | Array) -> CubicHermiteSpline:
    """Returns the path parameter over time of the fastest motion with piecewise constant acceleration."""
    grid = _even(_GRID + 1)
    slope, bend = np.abs(curve(grid, 1)) + 1e-12, np.abs(curve(grid, 2))
    rates = np.atleast_1d(path_rate)
    squared = np.minimum((limits.velocity / slope).min(axis=1) ** 2, np.interp(grid, _even(len(rates)), rates) ** 2)
    # Half of the acceleration is left for speeding up and braking where the path bends most.
    squared = np.minimum(squared, (0.5 * limits.acceleration / (bend + 1e-12)).min(axis=1))
    squared[0] = squared[-1] = 0.0
    found, limit = squared.tolist(), limits.acceleration.tolist()  # numbers one by one: arrays of a few joints are slow
    rows = [list(zip(limit, *row, strict=True)) for row in zip(bend.tolist(), slope.tolist(), strict=True)]
    for order in (range(_GRID), range(_GRID, 0, -1)):
        towards = 1 if order.step > 0 else -1
        for i in order:
            here = found[i]
            push = min((most - bent * here) / sloped for most, bent, sloped in rows[i])
            found[i + towards] = min(found[i + towards], here + 2.0 * push / _GRID)
    rate = np.sqrt(found)
    steps = 2.0 / _GRID / (rate[1:] + rate[:-1])
    return CubicHermiteSpline(np.concatenate([[0.0], np.cumsum(steps)]), grid, rate)


def _even(count: int) -> Array:
    return np.linspace(0.0, 1.0, count)


class _Profile:
    """Path parameter over time, averaged over the window; it starts and ends at rest."""

    def __init__(self, fastest: CubicHermiteSpline) -> None:
        end = float(fastest.x[-1])
        self.duration = end + _WINDOW
        self._fine = np.arange(-_WINDOW, self.duration + 2.0 * _FINE, _FINE)
        self._raw = fastest(np.clip(self._fine, 0.0, end))
        self._sum = np.concatenate([[0.0], np.cumsum((self._raw[1:] + self._raw[:-1]) * _FINE / 2.0)])

    def at(self, time: Array) -> tuple[Array, Array, Array]:
        """Returns path parameter, rate [1/s] and acceleration [1/s²] at times since the start [s]."""
        rate = self._rate(time)
        change = (self._rate(time + _FINE) - self._rate(time - _FINE)) / (2.0 * _FINE)
        share = (np.interp(time, self._fine, self._sum) - np.interp(time - _WINDOW, self._fine, self._sum)) / _WINDOW
        return np.clip(share, 0.0, 1.0), rate, change

    def _rate(self, time: Array) -> Array:
        later, earlier = np.interp(time, self._fine, self._raw), np.interp(time - _WINDOW, self._fine, self._raw)
        return np.asarray((later - earlier) / _WINDOW)


def _stretch(curve: CubicSpline, profile: _Profile, limits: JointLimits) -> float:
    """Returns the factor, at least 1, by which time must be stretched to hold the limits everywhere."""
    share, rate, change = profile.at(np.arange(0.0, profile.duration, _FINE))
    slope, bend = curve(share, 1), curve(share, 2)
    speed = np.abs(slope * rate[:, None]) / limits.velocity
    push = np.abs(bend * (rate**2)[:, None] + slope * change[:, None]) / limits.acceleration
    return 1.005 * max(1.0, float(speed.max()), math.sqrt(float(push.max())))
