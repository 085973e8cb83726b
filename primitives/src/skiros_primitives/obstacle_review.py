"""Looks again at obstacles that are only believed: what a picture sees through is not there."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from skiros_primitives.lookout import unexplained
from skiros_py.geometry import Array, Pose, Solid
from skiros_py.messages import Message
from skiros_py.ports.motion import DepthView, Obstacle
from skiros_py.skills.context import RunContext
from skiros_py.world import vocabulary as v

_GRID = 0.02
"""Distance of the points of an obstacle that are looked at [m]."""
_BEHIND = 0.03
"""A ray that ends so far behind a point has passed through it [m]."""
_NOTHING = 0.1
"""Where a smaller share of an obstacle may still be there, it is not there at all."""
_SMALLER = 0.8
"""Share of its volume from which on it counts as smaller than believed."""
_AWAY = 0.35
"""Distance of the camera from what is looked at again [m]."""
_RAISED = math.radians(45.0)
"""How far above it the camera is, as an angle from the horizontal ..."""
_AROUND = (0.0, math.radians(60.0), math.radians(-60.0))
"""... and from which sides it looks, from that of the robot on."""


def review_obstacles(context: RunContext, author: str, view: DepthView) -> None:
    """Forgets obstacles, or parts of them, that a picture sees through.

    What is left where something else is known, such as between the walls of a kit, is that: then it was met there.

    Args:
        context: The run.
        author: Who took the picture.
        view: The picture.
    """
    doubted = [one for one in view.known if context.world.has(one.id)]
    doubted = [one for one in doubted if context.world.element(one.id).type == v.OBSTACLE]
    others = [one for one in view.known if one not in doubted]
    for one in doubted:
        points = _points(one.solid)
        in_map = one.pose.apply(points)
        through = _seen_through(view, in_map)
        if not through.any():
            continue
        left = points[~through & unexplained(in_map, others, _BEHIND, 0.0)]
        if len(left) < _NOTHING * len(points):
            with context.world.transaction(author=author, reason=Message("a picture sees through it")) as tx:
                tx.remove(one.id)
        elif len(left) < len(points):
            low, high = left.min(axis=0) - _GRID / 2.0, left.max(axis=0) + _GRID / 2.0
            before = np.subtract(*reversed(one.solid.bounds()))
            if np.prod(high - low) < _SMALLER * np.prod(before):
                box = {"kind": "box", "size": (high - low).tolist(), "at": ((low + high) / 2.0).tolist()}
                with context.world.transaction(
                    author=author, reason=Message("a picture sees through some of it")
                ) as tx:
                    tx.set(one.id, v.SOLID, json.dumps([box]))


def _points(solid: Solid) -> Array:
    """Returns points all over a block around a solid, in its frame [m], shape (n, 3)."""
    axes = [
        np.arange(low + step / 2.0, high, step)
        for low, high in zip(*solid.bounds(), strict=True)
        for step in ((high - low) / max(1, round((high - low) / _GRID)),)
    ]
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)


def _seen_through(view: DepthView, points: Array) -> NDArray[np.bool_]:
    """Returns which points in the map are in a picture and in front of what it shows."""
    k = view.intrinsics
    x, y, z = view.camera_pose.inverse().apply(points).T
    ahead = z > k.near
    depth = np.where(ahead, z, 1.0)
    u, w = (np.rint(f * a / depth + c).astype(int) for f, a, c in ((k.fx, x, k.cx), (k.fy, y, k.cy)))
    inside = ahead & (u >= 0) & (u < k.width) & (w >= 0) & (w < k.height)
    through = np.zeros(len(points), np.bool_)
    through[inside] = view.depth[w[inside], u[inside]] > z[inside] + _BEHIND
    return through


def views_of(thing: Obstacle, base: Pose) -> Iterator[Pose]:
    """Yields poses of a camera, in the map, from which it sees an obstacle from the side and from above.

    Args:
        thing: The obstacle.
        base: The base of the robot, in the map.
    """
    low, high = thing.solid.bounds()
    x, y, z = (thing.pose @ Pose(tuple(((low + high) / 2.0).tolist()))).position
    away = _AWAY + float(np.linalg.norm(high - low)) / 2.0
    to_robot = math.atan2(base.position[1] - y, base.position[0] - x)
    for around in _AROUND:
        side, flat = to_robot + around, away * math.cos(_RAISED)
        camera = Pose.of(
            x + flat * math.cos(side),
            y + flat * math.sin(side),
            z + away * math.sin(_RAISED),
            roll=math.pi,
            pitch=_RAISED - math.pi / 2.0,
            yaw=side + math.pi,
        )
        yield from (camera @ Pose.of(0.0, 0.0, 0.0, yaw=quarters * math.pi / 2.0) for quarters in range(4))
