"""Paths of a differential-drive base: backwards out of a dock, around obstacles, straight ahead into the next dock."""

from __future__ import annotations

import heapq
import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from skiros_py.geometry import Array, Pose, wrap_angle
from skiros_py.ports.motion import BasePathRequest, NoMotion, Obstacle
from skiros_py.ports.paths import BaseLeg, BasePath, floor_area, placed, swept

_QUARTER = 2  # way points per quarter of a rounded corner
_TURN = 0.3  # [m] what a way point costs besides its way: the base stops there to turn
_SLACK = 0.002  # [m] by which way points lie outside what must not be entered

Point = tuple[float, float]


class DiscSpace:
    """Where the middle of a disc may be.

    Args:
        obstacles: Outlines of what stands on the floor [m].
        radius: Of the disc, clearance included [m].
    """

    def __init__(self, obstacles: Sequence[BaseGeometry], radius: float) -> None:
        union = shapely.union_all(list(obstacles))
        self._closed = shapely.buffer(union, radius, quad_segs=16)
        # Corners of polygons around each arc, so that the edges between them stay clear of the arc; and the one corner
        # outside of all, where there is room to turn but once.
        around = (radius + _SLACK) / math.cos(math.pi / (4 * _QUARTER))
        close = shapely.buffer(union, around, quad_segs=_QUARTER)
        wide = shapely.buffer(union, radius + _SLACK, join_style="mitre", mitre_limit=2.0)
        self._corners = np.vstack([self._outside(close), self._outside(wide)])
        shapely.prepare(self._closed)

    def free(self, point: Point) -> bool:
        """Returns True when the disc touches nothing with its middle at a point [m]."""
        return not shapely.intersects_xy(self._closed, *point)

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


_THERE = 0.01  # [m] this near the goal ...
_ALIGNED = math.radians(1.0)  # ... and this well aligned, the base need not move
_RUN_UP = 0.25  # [m] the last straight stretch is at least as long, so that the base comes in without sideways error
_FARTHEST = 3.0  # [m] a dock deeper than this is not looked for
_STEP = 0.02  # [m]
_DOCK_CLEARANCE = 0.02  # [m] kept by the base's outline while it docks
_NO_WAY = 1e-6  # [m]


class BasePaths:
    """Plans base paths synchronously, in tens of milliseconds.

    In the open the base is a disc around its outline, so that it may turn anywhere on the way; docked it is the outline
    itself and only drives straight.
    """

    def plan(self, request: BasePathRequest) -> BasePath | NoMotion:
        """Plans one path."""
        turned = abs(wrap_angle(request.goal.yaw - request.start.yaw))
        if math.dist(_xy(request.start), _xy(request.goal)) <= _THERE and turned <= _ALIGNED:
            return BasePath((), request.goal.yaw)
        floor = _Floor(request)
        if touched := floor.touched(placed(request.footprint, request.goal), 0.0):
            return NoMotion(f"at its goal the base would touch {touched}")
        out = floor.way_out(request.start)
        if out is None:
            return NoMotion(f"the base cannot leave where it stands: {floor.nearest(request.start)} is in the way")
        run_up = floor.run_up(request.goal)
        if run_up is None:
            return NoMotion(f"the base cannot drive straight into its goal past {floor.nearest(request.goal)}")
        way = floor.space.shortest(_xy(out), _xy(run_up))
        if way is None:
            return NoMotion("there is no way to the goal that is wide enough for the base")
        return BasePath(_legs(request, out, [*way, _xy(request.goal)]), request.goal.yaw)


def _legs(request: BasePathRequest, out: Pose, way: list[tuple[float, float]]) -> tuple[BaseLeg, ...]:
    legs = [BaseLeg(x, y) for before, (x, y) in pairwise(way) if math.dist((x, y), before) > _NO_WAY]
    if out.distance(request.start) > _NO_WAY:
        behind = (request.start.inverse() @ out).position[0] < 0.0
        legs.insert(0, BaseLeg(*_xy(out), backwards=behind))
    return tuple(legs)


def _outlines(obstacles: Sequence[Obstacle]) -> dict[str, BaseGeometry]:
    """Returns the floor areas of the obstacles, by id: a robot has one for its base and one for its arm."""
    found: dict[str, BaseGeometry] = {}
    for obstacle in obstacles:
        area = floor_area(obstacle.solid, obstacle.pose)
        found[obstacle.id] = shapely.union(found.get(obstacle.id, shapely.Polygon()), area)
    return found


class _Floor:
    """The free space of the base among the outlines of one request."""

    def __init__(self, request: BasePathRequest) -> None:
        self._footprint = request.footprint
        self._outlines = _outlines(request.obstacles)
        self._clearance = min(_DOCK_CLEARANCE, request.clearance)
        radius = max(math.hypot(x, y) for x, y in request.footprint)
        self.space = DiscSpace(list(self._outlines.values()), radius + request.clearance)

    def way_out(self, start: Pose) -> Pose | None:
        """Returns where turning is free, straight behind the start (or ahead if not behind)."""
        clearance = self._clearance_at(start)
        return self._first_free(start, -1.0, 0.0, clearance) or self._first_free(start, 1.0, 0.0, clearance)

    def run_up(self, goal: Pose) -> Pose | None:
        """Returns where turning is free straight behind the goal; or the goal, if it is free and nothing behind is."""
        pose = self._first_free(goal, -1.0, _RUN_UP, self._clearance_at(goal))
        return goal if pose is None and self.space.free(_xy(goal)) else pose

    def nearest(self, pose: Pose) -> str:
        """Returns the obstacle nearest to the base at a pose."""
        outline = placed(self._footprint, pose)
        return min(self._outlines, key=lambda name: float(shapely.distance(self._outlines[name], outline)))

    def _first_free(self, dock: Pose, sign: float, least: float, clearance: float) -> Pose | None:
        for step in range(math.ceil(least / _STEP), math.ceil(_FARTHEST / _STEP) + 1):
            pose = dock @ Pose((sign * step * _STEP, 0.0, 0.0))
            if self.touched(swept(self._footprint, (dock, pose))[0], clearance):
                return None
            if self.space.free(_xy(pose)):
                return pose
        return None

    def _clearance_at(self, dock: Pose) -> float:
        """Returns the docking clearance, or what there is of it where the base stands closer already."""
        outline = placed(self._footprint, dock)
        nearest = min((float(shapely.distance(other, outline)) for other in self._outlines.values()), default=math.inf)
        return min(self._clearance, 0.9 * nearest)

    def touched(self, area: BaseGeometry, clearance: float) -> str:
        """Returns the first obstacle nearer to an area than the clearance, or an empty text."""
        return next((name for name, one in self._outlines.items() if shapely.dwithin(one, area, clearance)), "")


def _xy(pose: Pose) -> tuple[float, float]:
    return pose.position[0], pose.position[1]
