"""Where the middle of a disc may be among obstacles on the floor, and the shortest way for it there."""

from __future__ import annotations

import heapq
import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from skiros_py.geometry import Array

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

    def sees(self, start: Point, goal: Point) -> bool:
        """Returns True when it touches nothing on the straight line between two points [m]."""
        return not shapely.intersects(self._closed, shapely.LineString([start, goal]))

    def shortest(self, start: Point, goal: Point, gates: Sequence[tuple[Point, Point]] = ()) -> list[Point] | None:
        """Returns the way points from start to goal, both included, or None: there is no way.

        It is the shortest way through the corners of the obstacles, where each turn counts as 0.3 m more.

        Args:
            start: Where it begins [m].
            goal: Where it ends [m].
            gates: Ends of straight ways that are free besides, although there is no room to turn.
        """
        ends = np.reshape(gates, (-1, 2))
        nodes = np.vstack([start, goal, ends, self._corners])
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
            through_gate = [2 + (here - 2 ^ 1)] if 2 <= here < 2 + len(ends) else []
            for there in (*self._seen_from(nodes, here, ~closed), *through_gate):
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
