"""The way of one leg of a base as a curve: where the base is on it, and how fast it may go where."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import combinations, dropwhile
from typing import NamedTuple

import numpy as np

from skiros_py.geometry import Array, Pose
from skiros_py.ports.paths import BaseLeg

_SHARES = (0.95, 0.87)
"""Share of the limits of driving and turning that is planned with; the rest is left for corrections."""
_GLIDING = (0.8, 0.7)
"""The same where it glides: what it drives ahead turns into what it drives sideways as fast as it turns."""
_BLIND = 0.4
"""Greatest speed backwards and sideways, where scanners that look ahead see nothing [m/s]."""
_GRID = 0.01
"""Distance between points of a curve [m]."""
_AHEAD = 60
"""Number of points ahead of the last one among which the nearest one is looked for."""
_NEAR = 0.05
"""Points of a curve this near to its beginning tell no direction, since the base is some millimetres beside it [m]."""
_LEVER = 0.4
"""How much a turn counts as way on a curve [m/rad]."""


class Place(NamedTuple):
    """Where a base is on a curve.

    Attributes:
        along: How far along the curve the nearest place ahead is [m].
        behind: How far ahead of the base that is, in its heading there [m].
        aside: How far left of it the base is [m].
        turned: Angle by which the base has to turn [rad].
    """

    along: float
    behind: float
    aside: float
    turned: float


class Curve:
    """The way of one leg, from where the base stands: what it drives and what it turns.

    Attributes:
        along: Ways from the beginning at even steps [m], shape (n,); a turn by 1 rad counts as 0.4 m.
        length: [m].
        glides: Whether the heading is independent of the way.
        ahead, aside, turn: How much is driven ahead (negative in reverse) and to the left, and turned [rad], for each
            metre of the way, at these places.

    Args:
        leg: The leg.
        start: Where the base stands.
        grid: Distance between the points [m].
    """

    def __init__(self, leg: BaseLeg, start: Pose, grid: float = _GRID) -> None:
        first, *via, last = leg.points(start)
        points = np.array([first, *dropwhile(lambda point: math.dist(point[:2], first[:2]) < _NEAR, via), last])
        points[:, 2] = np.unwrap(points[:, 2])
        self.glides = leg.glides
        driven = self._driven(points)
        steps = np.hypot(*driven[:2]) + _LEVER * np.abs(driven[2])
        kept = steps > 1e-9
        points, driven, steps = points[np.concatenate([[True], kept])], driven[:, kept], steps[kept]
        ends = np.concatenate([[0.0], np.cumsum(steps)])
        self.length = float(ends[-1])
        self.along = np.linspace(0.0, self.length, max(2, math.ceil(self.length / grid) + 1))
        self._points = np.column_stack([np.interp(self.along, ends, column) for column in points.T])
        # Rates are known in the middle of each step: in between they change evenly.
        middles = (ends[1:] + ends[:-1]) / 2.0 if len(steps) else np.zeros(1)
        rates = driven / steps if len(steps) else np.zeros((3, 1))
        self.ahead, self.aside, self.turn = (np.interp(self.along, middles, rate) for rate in rates)
        self._index = 0

    def _driven(self, points: Array) -> Array:
        """Returns what is driven ahead, negative in reverse, and to the left [m], and turned [rad] in each step."""
        dx, dy, turn = np.diff(points, axis=0).T
        yaw = points[:-1, 2] + turn / 2.0
        ahead = dx * np.cos(yaw) + dy * np.sin(yaw)
        if self.glides:
            return np.stack([ahead, dy * np.cos(yaw) - dx * np.sin(yaw), turn])
        return np.stack([np.copysign(np.hypot(dx, dy), ahead), np.zeros(len(turn)), turn])

    def nearest(self, pose: Pose) -> Place:
        """Returns the nearest place ahead of a base."""
        x, y, _ = pose.position
        away = self._points[self._index : self._index + _AHEAD] - (x, y, pose.yaw)
        away[:, 2] = _LEVER * ((away[:, 2] + math.pi) % (2.0 * math.pi) - math.pi)
        nearest = int(np.argmin((away**2).sum(axis=1)))
        self._index += nearest
        dx, dy, turned = away[nearest].tolist()
        ahead, left, turn = (float(one[self._index]) for one in (self.ahead, self.aside, self.turn))
        yaw = float(self._points[self._index, 2])
        behind, aside = dx * math.cos(yaw) + dy * math.sin(yaw), dx * math.sin(yaw) - dy * math.cos(yaw)
        past = -(behind * ahead - aside * left + turned * _LEVER * turn)
        past /= ahead**2 + left**2 + (_LEVER * turn) ** 2
        at = float(self.along[self._index]) + past
        return Place(at, behind + past * ahead, aside - past * left, turned / _LEVER + past * turn)

    def rates(self, along: float) -> tuple[float, float, float]:
        """Returns how much is driven ahead and to the left and turned for each metre of the way at a place."""
        ahead, aside, turn = (float(np.interp(along, self.along, one)) for one in (self.ahead, self.aside, self.turn))
        return ahead, aside, turn


@dataclass(frozen=True, slots=True)
class Speeds:
    """Limits of speed and acceleration [m/s, rad/s, m/s², rad/s²], and of the speed sideways [m/s]."""

    linear: float
    angular: float
    acceleration: float
    angular_acceleration: float
    sideways: float = 0.0

    def along(self, curve: Curve, *, start: float = math.inf) -> Array:
        """Returns the greatest rates of way at the points of a curve [m/s], which ends at rest.

        The rates are found backwards, from where the base can still brake, and then forwards: Pham and Pham, "A new
        approach to time-optimal path parameterization based on reachability analysis" (2018), for up to three
        velocities.

        Args:
            curve: The curve.
            start: Rate at its beginning [m/s].
        """
        step = float(curve.along[1] - curve.along[0])
        fastest = np.where(curve.ahead < 0.0, min(self.linear, _BLIND), self.linear)
        squared = np.full(len(curve.along), math.inf)
        parts = []
        shares = _GLIDING if curve.glides else _SHARES
        push, swing = shares[0] * self.acceleration, shares[1] * self.angular_acceleration
        limits = [(curve.ahead, fastest, push), (curve.turn, _SHARES[1] * self.angular, swing)]
        if curve.glides:
            limits.append((curve.aside, _SHARES[0] * min(self.sideways, _BLIND), push))
        for share, speed, limit in limits:
            size = np.maximum(np.abs(share), 1e-9)  # a velocity is share * rate
            bend = np.gradient(share, step) * np.where(share < 0.0, -1.0, 1.0)
            squared = np.minimum(squared, (speed / size) ** 2)
            parts.append((size, bend, limit))
        for (one, jolt, push), (other, swerve, swing) in combinations(parts, 2):
            both = np.maximum(np.abs(jolt * other - swerve * one), 1e-15)  # where one limit asks what the other forbids
            squared = np.minimum(squared, (push * other + swing * one) / both)
        squared[0], squared[-1] = min(squared[0], start**2), 0.0
        found = squared.tolist()
        gains = [
            list(zip((2.0 * step * limit / size).tolist(), (2.0 * step * bend / size).tolist(), strict=True))
            for size, bend, limit in parts
        ]
        for index in range(len(found) - 2, -1, -1):
            after = found[index + 1]
            for gain in gains:
                driving, bending = gain[index]
                if bending < 1.0:
                    found[index] = min(found[index], (after + driving) / (1.0 - bending))
        for index in range(len(found) - 1):
            here = found[index]
            most = min(driving - bending * here for driving, bending in (gain[index] for gain in gains))
            found[index + 1] = max(0.0, min(found[index + 1], here + most))
        return np.asarray(np.sqrt(found))

    def duration(self, curve: Curve) -> float:
        """Returns how long a curve takes from rest to rest [s]."""
        rates = self.along(curve, start=0.0)
        return float(2.0 * (np.diff(curve.along) / np.maximum(1e-6, rates[1:] + rates[:-1])).sum())

    def turning(self, angle: float) -> float:
        """Returns how long a turn on the spot by an angle [rad] takes [s]."""
        angle, quick = abs(angle), self.angular**2 / self.angular_acceleration
        full = angle / self.angular + self.angular / self.angular_acceleration
        return full if angle > quick else 2.0 * math.sqrt(angle / self.angular_acceleration)
