"""Paths of a differential-drive base: backwards out of a dock, around obstacles, straight ahead into the next dock."""

from __future__ import annotations

import heapq
import math
from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from skiros_py.devices.mobile_base import Curve, Speeds
from skiros_py.geometry import Array, Pose, wrap_angle
from skiros_py.ports.motion import BasePathRequest, NoMotion, Obstacle
from skiros_py.ports.paths import BaseLeg, BasePath, Layer, floor_area, placed, reach, swept

_QUARTER = 2  # way points per quarter of a rounded corner
_TURN = 0.3  # [m] what a way point costs besides its way: the base stops there to turn
_SLACK = 0.002  # [m] by which way points lie outside what must not be entered

Point = tuple[float, float]


class DiscSpace:
    """Where the middle of a disc may be; the disc may be of another size at each height.

    Args:
        obstacles: Outlines of what stands on the floor [m], and the radius of the disc at their height [m].
        clearance: Distance to keep [m].
    """

    def __init__(self, obstacles: Sequence[tuple[BaseGeometry, float]], clearance: float) -> None:
        def grown(by: float, **style: Any) -> BaseGeometry:
            return shapely.union_all([shapely.buffer(area, radius + by, **style) for area, radius in obstacles])

        self._closed = grown(clearance, quad_segs=16)
        # Corners of polygons around each arc, so that the edges between them stay clear of the arc; and the one corner
        # outside of all, where there is room to turn but once.
        around = 1.0 / math.cos(math.pi / (4 * _QUARTER)) - 1.0
        close = shapely.union_all(
            [
                shapely.buffer(area, radius + clearance + _SLACK + around * (radius + clearance), quad_segs=_QUARTER)
                for area, radius in obstacles
            ]
        )
        wide = grown(clearance + _SLACK, join_style="mitre", mitre_limit=2.0)
        self._corners = np.vstack([self._outside(close), self._outside(wide)])
        shapely.prepare(self._closed)

    def free(self, point: Point) -> bool:
        """Returns True when the disc touches nothing with its middle at a point [m]."""
        return not shapely.intersects_xy(self._closed, *point)

    def all_free(self, points: Array) -> bool:
        """Returns True when it touches nothing at any of some points [m], shape (n, 2)."""
        return not shapely.intersects_xy(self._closed, points).any()

    def shortest(self, start: Point, goal: Point) -> list[Point] | None:
        """Returns the way points from start to goal, both included, or None: there is no way.

        It is the shortest way through the corners of the obstacles, where each turn counts as 0.3 m more.
        """
        nodes = np.vstack([start, goal, self._corners])
        rest = np.hypot(*(nodes - nodes[1]).T)
        length = np.full(len(nodes), np.inf)
        length[0] = 0.0
        parent = np.zeros(len(nodes), dtype=int)
        queue, closed = [(rest[0], 0)], np.zeros(len(nodes), dtype=bool)
        while queue:
            _, here = heapq.heappop(queue)
            if here == 1:
                return _way(nodes, parent)
            if closed[here]:
                continue
            closed[here] = True
            for there in self._seen_from(nodes, here, ~closed):
                through = length[here] + math.dist(nodes[here], nodes[there]) + (_TURN if there != 1 else 0.0)
                if through < length[there] - 1e-9:
                    length[there], parent[there] = through, here
                    heapq.heappush(queue, (through + rest[there], int(there)))
        return None

    def _seen_from(self, nodes: Array, here: int, candidates: Array) -> Array:
        others = np.flatnonzero(candidates)
        ends = np.stack([np.broadcast_to(nodes[here], (len(others), 2)), nodes[others]], axis=1)
        return np.asarray(others[~shapely.intersects(self._closed, shapely.linestrings(ends))])

    def _outside(self, area: BaseGeometry) -> Array:
        corners = shapely.get_coordinates(area)
        if not len(corners):
            return np.empty((0, 2))
        return np.unique(corners[~shapely.intersects_xy(self._closed, corners)], axis=0)


def _way(nodes: Array, parent: Array) -> list[Point]:
    way, node = [1], 1
    while node != 0:
        node = int(parent[node])
        way.append(node)
    return [(float(nodes[i, 0]), float(nodes[i, 1])) for i in reversed(way)]


_THERE = 0.004  # [m] this near the goal ...
_ALIGNED = math.radians(0.4)  # ... and this well aligned, the base need not move
_RUN_UP = 0.25  # [m] the last straight stretch is at least as long, so that the base comes in without sideways error
_FARTHEST = 3.0  # [m] a dock deeper than this is not looked for
_STEP = 0.02  # [m]
_DOCK_CLEARANCE = 0.02  # [m] kept by the base's outline while it docks
_NO_WAY = 1e-6  # [m]


class BasePaths:
    """Plans base paths synchronously, in tens of milliseconds.

    In the open the robot is a disc around its outline, so that it may turn anywhere on the way; docked it is the
    outline itself and only drives straight.
    """

    def plan(self, request: BasePathRequest) -> BasePath | NoMotion:
        """Plans one path."""
        turned = abs(wrap_angle(request.goal.yaw - request.start.yaw))
        if math.dist(_xy(request.start), _xy(request.goal)) <= _THERE and turned <= _ALIGNED:
            return BasePath((), request.goal.yaw)
        floor = _Floor(request)
        if touched := floor.touched(request.goal, request.goal, 0.0):
            return NoMotion(f"at its goal the base would touch {touched}")
        found = floor.ways(request.start, request.goal)
        if isinstance(found, NoMotion):
            return found
        paths = (BasePath(_legs(request.start, way, floor.space), request.goal.yaw) for way in found)
        return min(paths, key=lambda path: _duration(path, request.start))


def _legs(start: Pose, way: Sequence[Point], space: DiscSpace) -> tuple[BaseLeg, ...]:
    """Returns the legs of a way that begins where there is room to turn."""
    apart = [point for before, point in pairwise(way) if math.dist(point, before) > _NO_WAY]
    legs = _rounded([way[0], *apart], space)
    if math.dist(way[0], _xy(start)) > _NO_WAY:
        behind = (start.inverse() @ Pose((*way[0], start.position[2]))).position[0] < 0.0
        legs.insert(0, BaseLeg(*way[0], backwards=behind))
    return tuple(legs)


_TYPICAL = Speeds(0.8, 1.2, 0.5, 1.5)
"""Limits of the base for which the fastest way is chosen."""
_STOP = 0.5
"""Time that a stop takes, until the base stands [s]."""


def _duration(path: BasePath, start: Pose) -> float:
    """Returns about how long a path takes [s]."""
    duration, here = 0.0, start
    for leg in path.legs:
        begin = Pose.of(*here.position, yaw=leg.heading(here))
        duration += _TYPICAL.turning(wrap_angle(begin.yaw - here.yaw)) + _TYPICAL.duration(Curve(leg, begin)) + _STOP
        here = leg.poses(begin)[-1]
    return duration + _TYPICAL.turning(wrap_angle(path.heading - here.yaw))


_SHARPEST = math.radians(100.0)
"""The base turns on the spot at sharper corners."""
_WIDEST = 1.5
"""Longest way before and after a corner on which it is rounded [m]."""
_NARROWEST = 0.1
"""Shortest [m]."""
_FINE = 0.04
"""Distance between points on a rounded corner [m]."""


def _rounded(way: Sequence[Point], space: DiscSpace) -> list[BaseLeg]:
    """Returns the legs along a polyline with rounded corners: one leg for all that is driven without a stop."""
    legs: list[BaseLeg] = []
    via: list[Point] = []
    room = [math.dist(a, b) / 2.0 for a, b in pairwise(way)]
    for number in range(1, len(way)):
        corner = None
        if number < len(way) - 1:
            last = number == len(way) - 2  # the end of the last stretch stays straight
            half = min(room[number - 1], 2.0 * room[number] - _RUN_UP if last else room[number], _WIDEST)
            corner = _corner(way[number - 1], way[number], way[number + 1], half, space)
        if corner is None:
            legs.append(BaseLeg(*way[number], via=tuple(via)))
            via = []
        else:
            via += corner
    return legs


def _corner(before: Point, at: Point, after: Point, half: float, space: DiscSpace) -> list[Point] | None:
    """Returns points around a corner, as wide as there is room; None where the base has to turn on the spot.

    The curve is a cubic B-spline: its curvature grows from zero and falls back to it, so the base need not stop to
    steer.

    Args:
        before: Where the way comes from.
        at: The corner.
        after: Where the way goes to.
        half: How long before and after the corner it may leave the straight lines [m].
        space: Where the middle of the base may be.
    """
    middle, incoming, outgoing = np.array(at), np.subtract(at, before), np.subtract(after, at)
    incoming, outgoing = incoming / np.linalg.norm(incoming), outgoing / np.linalg.norm(outgoing)
    if float(incoming @ outgoing) < math.cos(_SHARPEST):
        return None
    while half >= _NARROWEST:
        along = np.linspace(-half, half, 2 * math.ceil(half / _FINE) + 1)
        ahead = np.where(along < 0.0, (along + half) ** 3, 6.0 * half**2 * along + (half - along) ** 3) / (
            6.0 * half**2
        )
        points = middle + np.outer(along - ahead, incoming) + np.outer(ahead, outgoing)
        if space.all_free(points):
            return [(float(x), float(y)) for x, y in points]
        half *= 0.7
    return None


def _outlines(obstacles: Sequence[Obstacle], layer: Layer) -> dict[str, BaseGeometry]:
    """Returns the floor areas of the obstacles at some heights, by id: a robot has several."""
    found: dict[str, BaseGeometry] = {}
    for obstacle in obstacles:
        area = floor_area(obstacle.solid, obstacle.pose, layer.bottom, layer.top)
        if not area.is_empty:
            found[obstacle.id] = shapely.union(found.get(obstacle.id, shapely.Polygon()), area)
    return found


_ROOM = (0.3, 0.12, 0.0)
"""What may be kept besides the clearance, so that corners can be rounded [m]."""
_EARLIER = (0.0, 0.4, 0.8, 1.2)
"""How far before the last straight stretch the base may come in already [m]."""


class _Floor:
    """The free space of the robot among the outlines of one request."""

    def __init__(self, request: BasePathRequest) -> None:
        self._layers = [(layer.outline, _outlines(request.obstacles, layer)) for layer in request.shape]
        self._clearance = min(_DOCK_CLEARANCE, request.clearance)
        discs = [(area, reach(outline)) for outline, areas in self._layers for area in areas.values()]
        self._spaces = [DiscSpace(discs, request.clearance + room) for room in _ROOM]
        self.space = self._spaces[-1]

    def ways(self, start: Pose, goal: Pose) -> list[list[Point]] | NoMotion:
        """Returns ways from where there is room to turn to the goal, or why there is none.

        They are short, or have more room to round corners.
        """
        found, why = [], NoMotion("there is no way to the goal that is wide enough for the base")
        for space in reversed(self._spaces):
            out, entries = self._out(start, space), self._entries(goal, space)
            if space is self.space and out is None:
                return NoMotion(f"the base cannot leave where it stands: {self.nearest(start)} is in the way")
            if space is self.space and not entries:
                return NoMotion(f"the base cannot drive straight into its goal past {self.nearest(goal)}")
            ways = (space.shortest(_xy(out), _xy(entry)) for entry in entries) if out is not None else ()
            found += [[*way, _xy(goal)] for way in ways if way is not None]
        return found or why

    def _out(self, start: Pose, space: DiscSpace) -> Pose | None:
        """Returns where there is room to turn: straight behind the start, as if it stood in a dock, or else ahead."""
        clearance = self._clearance_at(start)
        behind = self._first_free(start, space, -1.0, 0.0, clearance)
        return behind or self._first_free(start, space, 1.0, 0.0, clearance)

    def _entries(self, goal: Pose, space: DiscSpace) -> list[Pose]:
        """Returns where the last straight stretch may begin: behind the goal, or at it if nothing behind is free."""
        clearance = self._clearance_at(goal)
        run_up = self._first_free(goal, space, -1.0, _RUN_UP, clearance)
        if run_up is None:
            return [goal] if space.free(_xy(goal)) else []
        entries = [run_up @ Pose((-earlier, 0.0, 0.0)) for earlier in _EARLIER]
        return [entry for entry in entries if not self.touched(goal, entry, clearance)]

    def nearest(self, pose: Pose) -> str:
        """Returns the obstacle nearest to the robot at a pose."""
        return min(self._distances(pose), default=(0.0, ""))[1]

    def _distances(self, pose: Pose) -> Iterator[tuple[float, str]]:
        for outline, areas in self._layers:
            here = placed(outline, pose)
            yield from ((float(shapely.distance(area, here)), name) for name, area in areas.items())

    def _first_free(self, dock: Pose, space: DiscSpace, sign: float, least: float, clearance: float) -> Pose | None:
        """Returns the first pose straight ahead of a dock, or behind it, where there is room to turn."""
        for step in range(math.ceil(least / _STEP), math.ceil(_FARTHEST / _STEP) + 1):
            pose = dock @ Pose((sign * step * _STEP, 0.0, 0.0))
            if self.touched(dock, pose, clearance):
                return None
            if space.free(_xy(pose)):
                return pose
        return None

    def _clearance_at(self, dock: Pose) -> float:
        """Returns the docking clearance, or what there is of it where the robot stands closer already."""
        return min(self._clearance, 0.9 * min(self._distances(dock), default=(math.inf, ""))[0])

    def touched(self, start: Pose, end: Pose, clearance: float) -> str:
        """Returns the first obstacle nearer than the clearance to the robot on a straight stretch, or an empty text."""
        for outline, areas in self._layers:
            area = swept(outline, (start, end))[0]
            for name, one in areas.items():
                if shapely.dwithin(one, area, clearance):
                    return name
        return ""


def _xy(pose: Pose) -> Point:
    return pose.position[0], pose.position[1]
