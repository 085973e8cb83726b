"""Paths of bases over the floor, and the areas that robots and things cover there."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Protocol

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from skiros_py.geometry import Array, Pose, Primitive, Solid, wrap_angle

Outline = Sequence[tuple[float, float]]
"""Points on the floor in the frame of a base [m]; what is in their convex hull belongs to the robot."""

TALLEST = 1.6
"""What begins higher obstructs no robot with its arms folded [m]."""


@dataclass(frozen=True, slots=True)
class Layer:
    """What a robot covers between two heights.

    Attributes:
        outline: Points in the frame of the base [m]; what is in their convex hull belongs to the robot.
        bottom, top: Heights above the floor [m].
    """

    outline: tuple[tuple[float, float], ...]
    bottom: float = 0.0
    top: float = TALLEST


_WAY, _TURN = 0.5, math.radians(10.0)
"""Greatest distance [m] and turn [rad] between two poses of a path, unless more are wanted."""
_GLIDED = 0.1
"""Greatest distance between two poses where the base glides [m]: it goes around corners without turning."""
_CORNERS = 24
"""Of the polygon around a circle."""


class Path(Protocol):
    """A way of a base through the map, made of legs."""

    @property
    def legs(self) -> Sequence[object]:
        """Its legs."""

    def poses(self, start: Pose, *, way: float = _WAY, turn: float = _TURN) -> Iterator[tuple[float, Pose]]:
        """Yields the poses on the way from the start on, each with the number of legs driven there.

        1.5 is half of the second leg. Between two poses the base stays within the hull of its outline at both.

        Args:
            start: Where the base stands, in the map.
            way: Greatest distance between two poses [m].
            turn: Greatest turn between two poses [rad].
        """


@dataclass(frozen=True, slots=True)
class BaseLeg:
    """Turn towards a point in the map (or away from it, to reverse), then drive to it; or drive along a curve.

    Attributes:
        x, y: Where it ends [m].
        backwards: Whether a straight leg is driven in reverse.
        via: Points on the way [m] and the heading at each [rad], close together on a smooth curve; none for a straight
            leg. Where the heading is against the way, the base reverses.
        glides: Whether an omnidirectional base drives it, in any direction from its heading.
    """

    x: float
    y: float
    backwards: bool = False
    via: tuple[tuple[float, float, float], ...] = ()
    glides: bool = False

    @classmethod
    def gliding(cls, *poses: Pose) -> BaseLeg:
        """Returns a leg through poses in the map, which turns on the way; the first is where it is begun."""
        via = tuple((*pose.position[:2], pose.yaw) for pose in poses)
        return cls(*via[-1][:2], via=via, glides=True)

    def heading(self, start: Pose) -> float:
        """Returns the heading in which it is begun from a pose [rad]."""
        if self.via:
            return self.via[0][2]
        x, y, _ = start.position
        return math.atan2(self.y - y, self.x - x) + (math.pi if self.backwards else 0.0)

    def points(self, start: Pose) -> list[tuple[float, float, float]]:
        """Returns its points [m] and the headings there [rad], with where it is begun from a pose and where it ends."""
        x, y, _ = start.position
        first = self.heading(start)
        return [(x, y, first), *self.via, (self.x, self.y, self.via[-1][2] if self.via else first)]


@dataclass(frozen=True, slots=True)
class BasePath:
    """Legs one after the other, then a turn on the spot to ``heading`` [rad]; a :class:`Path`."""

    legs: tuple[BaseLeg, ...]
    heading: float

    def poses(self, start: Pose, *, way: float = _WAY, turn: float = _TURN) -> Iterator[tuple[float, Pose]]:
        """Yields the poses on the way, each with the number of legs driven there."""
        yield 0.0, start
        here = start
        for number, leg in enumerate(self.legs):
            poses = [Pose.of(x, y, start.position[2], yaw=yaw) for x, y, yaw in leg.points(here)]
            yield from ((float(number), pose) for pose in _between(here, poses[0], way, turn))
            most = min(way, _GLIDED) if leg.glides else way
            stops = [
                stop
                for before, there in pairwise(_thinned(poses, most, turn))
                for stop in _between(before, there, most, turn)
            ]
            yield from ((number + step / len(stops), pose) for step, pose in enumerate(stops, start=1))
            here = stops[-1]
        last = Pose.of(*here.position, yaw=self.heading)
        yield from ((float(len(self.legs)), pose) for pose in _between(here, last, way, turn))


def _thinned(poses: list[Pose], way: float, turn: float) -> list[Pose]:
    """Returns the first, the last and as few others as keep distances and turns small."""
    kept = [poses[0]]
    for pose, after in pairwise(poses[1:]):
        last = kept[-1]
        if after.distance(last) > way or abs(wrap_angle(after.yaw - last.yaw)) > turn:
            kept.append(pose)
    return [*kept, poses[-1]]


@dataclass(frozen=True, slots=True)
class PosePath:
    """Straight from pose to pose, turning on the way, for a base that drives in any direction; a :class:`Path`."""

    legs: tuple[Pose, ...]

    def poses(self, start: Pose, *, way: float = _WAY, turn: float = _TURN) -> Iterator[tuple[float, Pose]]:
        """Yields the poses on the way, each with the number of legs driven there."""
        yield 0.0, start
        for number, (here, there) in enumerate(pairwise((start, *self.legs))):
            stops = list(_between(here, there, way, turn))
            yield from ((number + step / len(stops), pose) for step, pose in enumerate(stops, start=1))


def _between(here: Pose, there: Pose, way: float, turn: float) -> Iterator[Pose]:
    """Yields poses from one to another, the last one included."""
    angle = wrap_angle(there.yaw - here.yaw)
    count = max(1, math.ceil(here.distance(there) / way), math.ceil(abs(angle) / turn))
    start, end = np.array(here.position), np.array(there.position)
    for step in range(1, count):
        share = step / count
        yield Pose.of(*(start + share * (end - start)), yaw=here.yaw + share * angle)
    yield there


# ---------------------------------------------------------------------- areas


def reach(outline: Outline) -> float:
    """Returns how far an outline reaches from the middle of the base [m]."""
    return max(math.hypot(x, y) for x, y in outline)


def hull(points: Array | Outline) -> BaseGeometry:
    """Returns the convex hull of points, seen from above [m]."""
    found: BaseGeometry = shapely.multipoints(np.asarray(points, dtype=float)[:, :2])  # type: ignore[assignment]
    return found.convex_hull


def placed(outline: Outline, pose: Pose) -> BaseGeometry:
    """Returns the area of an outline at a pose [m, map]; empty for a robot that does not touch the floor."""
    return swept(outline, (pose, pose))[0]


def swept(outline: Outline, poses: Iterable[Pose]) -> list[BaseGeometry]:
    """Returns the area that an outline covers from each pose to the next: the hull at both [m, map]."""
    corners = np.array([(x, y, 0.0) for x, y in outline]).reshape(-1, 3)
    points = [pose.apply(corners)[:, :2] for pose in poses]
    return [hull(np.vstack(pair)) for pair in pairwise(points)]


def floor_area(solid: Solid, pose: Pose, bottom: float = 0.0, top: float = TALLEST) -> BaseGeometry:
    """Returns the floor area of a solid [m, map]: the union of the outlines of its blocks between two heights."""
    blocks = [_corners(pose @ block.pose, block) for block in solid.primitives]
    there = [points for points in blocks if points[:, 2].min() < top and points[:, 2].max() > bottom]
    return shapely.union_all([hull(points) for points in there])


def _corners(pose: Pose, block: Primitive) -> Array:
    if block.kind == "box":
        half = np.array(block.size) / 2.0
        signs = np.array(np.meshgrid([-1, 1], [-1, 1], [-1, 1])).reshape(3, -1).T
        return pose.apply(signs * half)
    radius, length = block.size
    angles = np.linspace(0.0, 2.0 * np.pi, _CORNERS, endpoint=False)
    rim = radius / np.cos(np.pi / _CORNERS) * np.column_stack([np.cos(angles), np.sin(angles)])
    ends = [np.column_stack([rim, np.full(_CORNERS, z)]) for z in (-length / 2.0, length / 2.0)]
    return pose.apply(np.vstack(ends))
