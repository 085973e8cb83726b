"""What a scanner sees in a robot's way and no belief explains."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.geometry.base import BaseGeometry

from skiros_primitives.contact import believe_obstacle
from skiros_primitives.floor_obstacles import bodies, standing
from skiros_py.devices.scanner import ScannerSpec, ScannerState
from skiros_py.geometry import Array, Pose, Primitive
from skiros_py.messages import Message
from skiros_py.ports.cell import RobotSpec
from skiros_py.ports.motion import Obstacle
from skiros_py.ports.paths import TALLEST, Layer, Path, floor_area, swept
from skiros_py.skills.context import RunContext
from skiros_py.world import vocabulary as v
from skiros_py.world.world import World

_FLOOR = 0.05
"""What is lower is the floor [m]."""
_EXPLAINED = 0.06
"""What is this near to something believed belongs to it [m]: scan, map and localisation are not exact."""
_ON_TOP = 0.25
"""Height of what may stand on something known, such as parts whose places are not known yet [m]."""
_NEAR = 2.5
"""Distance from a scanner beyond which an error in heading moves known things too far to explain points [m]."""
_AHEAD = 2.2
"""How far from the middle of the base a thing in the way stops it [m]: it brakes within a third of that."""
_FEWEST = 3
"""Number of points of the last scans that make a thing."""
_SCANS = 5
_THROUGH = 8
"""Number of rays that go through the foot of an obstacle until it is forgotten."""
_CORE, _FOOT = 0.6, 0.1
"""Share of its length and width, and its height [m], that count as its foot."""
_BESIDE = 0.25
"""Points closer than this to each other belong to one thing [m]: about twice the distance between rays that far off."""
_AROUND = 0.15
"""Points this near to another robot belong to it [m]: a robot moves between scan and localisation."""
_BELOW = 0.10
"""How far a thing may reach below and above what was seen of it: the distance between layers [m]."""
_GROWN = 0.05
"""By how much a thing is taken to be larger than what was seen of it [m]."""


class Lookout:
    """Watches one drive along a path.

    Attributes:
        strange: Points of the last scans that nothing believed explains, in the map [m], shape (n, 3).

    Args:
        context: The run.
        robot: The robot that drives.
        shape: What it covers.
        start: Where it stands.
        path: Its path.
        known: What is believed to stand around.
        met: Ids of obstacles that the base has met in this drive: what it did not see before, it does not see now.
    """

    def __init__(
        self,
        context: RunContext,
        robot: RobotSpec,
        shape: Sequence[Layer],
        start: Pose,
        path: Path,
        known: Sequence[Obstacle],
        met: Sequence[str] = (),
    ) -> None:
        self._context = context
        self._robot = robot
        self._known = known
        poses = [pose for _, pose in path.poses(start)]
        self._ways = [(layer, shapely.union_all(swept(layer.outline, poses))) for layer in shape]
        for _, way in self._ways:
            shapely.prepare(way)
        self._scans = {spec.id: self._scan(spec).number for spec in robot.of(ScannerSpec)}
        self.strange: Array = np.empty((0, 3))
        self._seen: list[Array] = []
        world = context.world
        on_floor = (one for one in known if one.pose.position[2] < _FLOOR and one.id not in met)
        doubted = (one for one in on_floor if world.ontology.is_a(world.element(one.id).type, v.OBSTACLE))
        self._doubted = dict.fromkeys(doubted, 0.0)

    def is_blocked(self) -> bool:
        """Returns True when a new scan shows something in the way; to be asked once per cycle."""
        for spec in self._robot.of(ScannerSpec):
            scan = self._scan(spec)
            if scan.number == self._scans[spec.id]:
                continue
            self._scans[spec.id] = scan.number
            scanner = self._context.frames.at(self._context.board.snapshot).located(spec.id)
            points = np.reshape(scan.points, (-1, 3))
            points = scanner.apply(points)
            self._doubt(scanner, points)
            points = points[np.hypot(*(points[:, :2] - scanner.position[:2]).T) < _NEAR]
            points = points[(points[:, 2] > _FLOOR) & (points[:, 2] < TALLEST)]
            points = points[unexplained(points, self._known)]
            points = points[~shapely.contains_xy(self._others(), points[:, :2])]
            self._seen = [*self._seen[1 - _SCANS :], points]
            self.strange = np.vstack(self._seen)
            if self._in_the_way(self.strange) >= _FEWEST:
                return True
        return False

    def gone(self) -> list[str]:
        """Returns the ids of obstacles whose places the scans have seen through; each is returned once."""
        found = [obstacle for obstacle, through in self._doubted.items() if through >= _THROUGH]
        for obstacle in found:
            del self._doubted[obstacle]
        return [obstacle.id for obstacle in found]

    def _doubt(self, scanner: Pose, points: Array) -> None:
        """Counts the rays of a scan that went through the foot of each obstacle; one that ends in it clears it."""
        for obstacle in self._doubted:
            for block in obstacle.solid.primitives:
                to_block = (obstacle.pose @ block.pose).inverse()
                start, ends, half = to_block.apply(np.array(scanner.position)), to_block.apply(points), half_size(block)
                inside = (np.abs(ends) < half + _EXPLAINED).all(axis=1) & (points[:, 2] > _FLOOR)
                foot = _CORE * half[0], _CORE * half[1], _FOOT / 2.0
                rise = (0.0, 0.0, foot[2] - half[2])
                through = float(crossed(start - rise, ends - rise, np.array(foot)).sum())
                self._doubted[obstacle] += -math.inf if inside.any() else through

    def _scan(self, spec: ScannerSpec) -> ScannerState:
        return self._context.board.snapshot.state(spec.id, ScannerState)

    def _others(self) -> BaseGeometry:
        """Returns the floor around the other robots and below their arms, wherever they are now."""
        robot = self._robot.id
        them = (*bodies(self._context, robot), *standing(self._context, robot, margin=0.0))
        return shapely.union_all([floor_area(one.solid, one.pose) for one in them]).buffer(_AROUND)

    def _in_the_way(self, points: Array) -> int:
        x, y, _ = self._robot.pose(self._context.board.snapshot, self._context.board.guard).position
        near = points[np.hypot(points[:, 0] - x, points[:, 1] - y) < _AHEAD]
        inside = np.zeros(len(near), dtype=bool)
        for layer, way in self._ways:
            level = (near[:, 2] >= layer.bottom) & (near[:, 2] <= layer.top)
            inside |= level & shapely.contains_xy(way, near[:, :2])
        return int(inside.sum())


def forget(world: World, author: str, obstacles: Sequence[str]) -> None:
    """Removes obstacles that are not there any more."""
    with world.transaction(author=author, reason=Message("a scanner sees through its place")) as tx:
        for obstacle in obstacles:
            tx.remove(obstacle)


def unexplained(
    points: Array, known: Iterable[Obstacle], near: float = _EXPLAINED, on_top: float = _ON_TOP
) -> NDArray[np.bool_]:
    """Returns which points in the map belong to nothing believed, shape (n,).

    Args:
        points: In the map [m], shape (n, 3).
        known: What is believed to stand around.
        near: What is this near to something believed belongs to it [m].
        on_top: Height of what may stand on it [m].
    """
    found = np.ones(len(points), np.bool_)
    for one in known:
        for block in one.solid.primitives:
            found[found] = _distances(points[found], one.pose @ block.pose, block, on_top) > near
    return found


def believe_seen(world: World, author: str, points: Array) -> list[str]:
    """Writes the things that points show, each as a block around them; returns their ids.

    Args:
        world: The world model.
        author: Who saw them.
        points: In the map [m], shape (n, 3).
    """
    found, reason = [], Message("seen by a scanner")
    for area, low, high in _things(points):
        (x0, y0), (x1, y1), (x2, y2), *_ = shapely.get_coordinates(area).tolist()
        middle = area.centroid
        length, width = math.hypot(x1 - x0, y1 - y0), math.hypot(x2 - x1, y2 - y1)
        pose = Pose.of(middle.x, middle.y, low, yaw=math.atan2(y1 - y0, x1 - x0))
        found.append(believe_obstacle(world, author, pose, (length, width, high - low), reason))
    return found


def _things(points: Array) -> Iterator[tuple[BaseGeometry, float, float]]:
    """Yields a rectangle around each thing, and the heights between which it was seen [m]."""
    for part in shapely.get_parts(shapely.MultiPoint(points[:, :2]).buffer(_BESIDE / 2.0)):
        mine = shapely.contains_xy(part, points[:, :2])
        if mine.any():
            around = shapely.MultiPoint(points[mine, :2]).buffer(_GROWN).minimum_rotated_rectangle
            low, high = float(points[mine, 2].min()), float(points[mine, 2].max())
            yield around, 0.0 if low < 3.0 * _BELOW else low - _BELOW, high + _BELOW


def _distances(points: Array, pose: Pose, block: Primitive, on_top: float) -> Array:
    """Returns the distances of points from a block and what may stand on it, so high [m], shape (n,).

    A cylinder counts as the box around it.
    """
    half = half_size(block)
    local = pose.inverse().apply(points)
    local[:, 2] = np.minimum(local[:, 2], np.maximum(half[2], local[:, 2] - on_top))
    outside = np.abs(local) - half
    return np.asarray(np.linalg.norm(np.maximum(outside, 0.0), axis=1))


def half_size(block: Primitive) -> Array:
    """Returns half of the size of the box around a block [m]."""
    size = block.size if block.kind == "box" else (2.0 * block.size[0], 2.0 * block.size[0], block.size[1])
    return np.array(size) / 2.0


def crossed(start: Array, ends: Array, half: Array) -> Array:
    """Returns which rays from a start to some ends come into a box around the origin, shape (n,)."""
    way = ends - start
    way = np.where(np.abs(way) < 1e-9, 1e-9, way)
    sides = np.stack([(-half - start) / way, (half - start) / way])
    enters, leaves = sides.min(axis=0).max(axis=1), sides.max(axis=0).min(axis=1)
    return np.asarray((enters < leaves) & (leaves > 0.0) & (enters < 1.0))
