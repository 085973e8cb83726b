"""Shortest way of a disc among polygons: a visibility graph, searched with A*, edges looked at only when needed."""

from __future__ import annotations

import heapq
import math
from collections.abc import Sequence

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from skiros_py.geometry import Array

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
