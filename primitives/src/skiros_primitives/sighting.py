"""Where a scanner shows a thing that stands on the floor: its outline is fitted to the rays, robustly.

Rays that ended on it say how far its sides are, and rays that passed beside it where they end. A direction of which the
rays say nothing, as that along a wall, keeps what was believed.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from skiros_primitives.lookout import unexplained
from skiros_py.devices.scanner import ScannerSpec, ScannerState
from skiros_py.geometry import Array, Pose, Primitive, Solid, rotation_matrix, wrap_angle
from skiros_py.ports.board import Mobile
from skiros_py.ports.cell import RobotSpec
from skiros_py.ports.motion import Obstacle
from skiros_py.ports.paths import floor_area
from skiros_py.ports.values import Snapshot
from skiros_py.skills.context import RunContext
from skiros_py.skills.surroundings import map_pose, obstacles, solid_of
from skiros_py.world import vocabulary as v

Flags = NDArray[np.bool_]

_NEAR = 0.3
"""Greatest distance between a point and the believed side that it belongs to [m]."""
_NOISE = 0.01
"""Standard deviation of how far a ray went [m]."""
_BESIDE = 0.005
"""Standard deviation of where a ray passes [m]."""
_MARGIN = 0.005
"""Rays that meet or miss a thing by less than this push its edge away, so that it comes to lie between them [m]."""
_OUTLIER = 0.03
"""What deviates more than this counts less and less [m]."""
_WIDE_OUTLIER = 0.2
"""The same in the first step of a wider search [m]; it falls by the factor below with each step."""
_FALL = 0.6
_EDGE = 0.05
"""Rays that pass an edge within this tell how far a side reaches [m]."""
_OTHERS = 40
"""So many of the other rays of a scan are enough."""
_STEPS = 12
_DONE = 1e-4
"""Size of the step that is the last one [m, rad]."""
_PRIOR = np.array([0.2, 0.2, math.radians(10.0)])
"""Standard deviations of the believed place [m] and heading [rad] before anything is seen."""
_RIM = 0.02
"""What is this near to the lower or upper rim of a block says nothing [m]."""
_MANY = 100
"""So many rays show something reliably."""
_FEW = 0.1
"""Greatest share of rays that may speak against where a thing is seen."""
_UPRIGHT = 0.999
"""Cosine of the angle at which an axis still counts as upright."""
_BEHIND = 0.05
"""A ray that goes on so far behind a block passed it [m]."""
_DEEP = 0.05
"""A ray that passes a block has gone through it if that much of it is on both sides [m]."""


@dataclass(frozen=True, slots=True)
class Rays:
    """Rays of scans in the map.

    Attributes:
        starts, ends: Where each began and ended [m], shape (n, 3).
        met: Which of them met something at their ends, shape (n,).
    """

    starts: Array
    ends: Array
    met: Flags

    @classmethod
    def joined(cls, scans: Sequence[Rays]) -> Rays:
        """Returns the rays of several scans."""
        starts, ends, met = ([getattr(scan, name) for scan in scans] for name in ("starts", "ends", "met"))
        return cls(np.concatenate(starts), np.concatenate(ends), np.concatenate(met))

    def towards(self, pose: Pose, radius: float) -> Rays:
        """Returns those that pass or end within a distance [m] of a pose, seen from above."""
        seen = _Seen(self, pose)
        aside = np.abs(seen.along[:, 0] * seen.starts[:, 1] - seen.along[:, 1] * seen.starts[:, 0])
        ahead = -(seen.along * seen.starts).sum(axis=1)
        kept = (aside < radius) & (ahead > 0.0) & (seen.length > ahead - radius)
        return self.only(np.flatnonzero(kept))

    def only(self, which: NDArray[np.int_]) -> Rays:
        """Returns some of them, by their numbers."""
        return Rays(self.starts[which], self.ends[which], self.met[which])


@dataclass(frozen=True, slots=True)
class Match:
    """How rays fit to a thing.

    Attributes:
        pose: Where they show it, in the map.
        on: Number of rays that ended on it, if it is there.
        against: Number of rays that ended near it, but in it or beside it.
        through: Number of rays that went through it.
        sigma: Standard deviations of its place along its x and y axes [m], and of its heading [rad].
    """

    pose: Pose
    on: int
    against: int
    through: int
    sigma: tuple[float, float, float]

    @property
    def fits(self) -> bool:
        """True when enough rays ended on it, and few speak against that."""
        return self.on >= _MANY and self.against + self.through <= _FEW * self.on


class _Seen:
    """Rays in the frame of a thing, from above.

    Attributes:
        starts, along: Where each begins [m] and its direction, shape (n, 2).
        length: How far each went [m], shape (n,).
    """

    def __init__(self, rays: Rays, pose: Pose) -> None:
        back = pose.inverse()
        starts, self.ends = back.apply(rays.starts), back.apply(rays.ends)
        way = self.ends - starts
        self.starts, self._height = starts[:, :2], starts[:, 2]
        self.length = np.maximum(np.hypot(way[:, 0], way[:, 1]), 1e-9)
        self.along, self._rise = way[:, :2] / self.length[:, None], way[:, 2] / self.length

    def height(self, way: Array) -> Array:
        """Returns how high each is after a way [m]."""
        return np.asarray(self._height + self._rise * way)


class _Block:
    """One block of a thing, from above."""

    def __init__(self, block: Primitive) -> None:
        solid = Solid((block,))
        outline = floor_area(solid, Pose(), -math.inf, math.inf)
        corners = shapely.get_coordinates(outline)[:-1]
        self._corners = corners if shapely.is_ccw(shapely.get_exterior_ring(outline)) else corners[::-1]
        sides = np.roll(self._corners, -1, axis=0) - self._corners
        self._normals = np.column_stack([sides[:, 1], -sides[:, 0]]) / np.linalg.norm(sides, axis=1)[:, None]
        self._offsets = (self._normals * self._corners).sum(axis=1)
        low, high = solid.bounds()
        upright = rotation_matrix(block.pose.orientation)[2, 2] > _UPRIGHT
        self._axis = np.array(block.pose.position[:2]) if block.kind == "cylinder" and upright else None
        self._bottom, self._top = float(low[2]) + _RIM, float(high[2]) - _RIM
        self.radius = float(np.linalg.norm(self._corners, axis=1).max())

    def _level(self, heights: Array) -> Flags:
        return np.asarray((heights > self._bottom) & (heights < self._top))

    def ended(self, seen: _Seen, met: Flags) -> tuple[Array, Array, Array]:
        """Returns how far outside of it each ray ended.

        Returns:
            The distance from the side that the ray came to, negative inside [m]; how far it is outside of any side [m],
            infinite where the ray did not end near it; and by how much a motion of the block changes the first one.
        """
        points = seen.ends[:, :2]
        outside = points @ self._normals.T - self._offsets
        facing = seen.starts @ self._normals.T > self._offsets
        distances = np.where(facing, outside, -np.inf)
        side = distances.argmax(axis=1)
        deep, far = distances.max(axis=1), outside.max(axis=1)
        near = met & self._level(seen.ends[:, 2]) & (far < _NEAR) & (deep > -_NEAR)
        normals = self._normals[side]
        return deep, np.where(near, far, np.inf), -self._moved(normals, points)

    def passed(self, seen: _Seen) -> tuple[Array, Flags, Array]:
        """Returns how the line of each ray crosses it.

        Returns:
            How much of it is on the side of the line where less is, negative where the line passes beside it [m];
            whether the ray went on behind it; and by how much a motion of the block changes the first one.
        """
        to_corner = self._corners[None] - seen.starts[:, None]
        left = np.column_stack([-seen.along[:, 1], seen.along[:, 0]])
        aside, ahead = (np.einsum("ncd,nd->nc", to_corner, axis) for axis in (left, seen.along))
        first, last = ahead.min(axis=1), ahead.max(axis=1)
        level = self._level(seen.height(first)) & self._level(seen.height(last))
        is_left = aside.max(axis=1) <= -aside.min(axis=1)
        corner = np.where(is_left, aside.argmax(axis=1), aside.argmin(axis=1))
        sign = np.where(is_left, 1.0, -1.0)
        inside = sign * np.take_along_axis(aside, corner[:, None], axis=1)[:, 0]
        beyond = (first > 0.0) & level & (seen.length > last + _BEHIND)
        return inside, beyond, sign[:, None] * self._moved(left, self._corners[corner])

    def _moved(self, normals: Array, points: Array) -> Array:
        """Returns how far points move along normals where it moves along x and y, and turns; shape (n, 3)."""
        if self._axis is not None:  # what is round looks the same from all sides
            points = np.broadcast_to(self._axis, points.shape)
        turned = normals[:, 1] * points[:, 0] - normals[:, 0] * points[:, 1]
        return np.column_stack([normals, turned])


class Silhouette:
    """What a thing that stands on the floor looks like to a scanner.

    Args:
        solid: Its shape.
    """

    def __init__(self, solid: Solid) -> None:
        self._blocks = [_Block(block) for block in solid.primitives]
        self.radius = max(block.radius for block in self._blocks) + _NEAR

    def telling(self, rays: Rays, pose: Pose) -> Rays:
        """Returns the rays that tell most of it, about where it is: all at its edges, and some of the others."""
        rays = rays.towards(pose, self.radius)
        inside = np.stack([block.passed(_Seen(rays, pose))[0] for block in self._blocks])
        edges = np.abs(inside).min(axis=0) < _EDGE
        others = np.flatnonzero(~edges & (rays.met | (inside.max(axis=0) > 0.0)))
        return rays.only(np.concatenate([np.flatnonzero(edges), others[:: max(1, len(others) // _OTHERS)]]))

    def match(self, rays: Rays, believed: Pose, guess: Pose) -> Match:
        """Fits its pose on the floor to rays.

        Args:
            rays: The rays.
            believed: Where it is believed to be.
            guess: Where it may rather be.

        Returns:
            The fit that begins at the guess, or else that of a wider search; how the rays fit to where it is believed
            to be, if neither is good.
        """
        for start, outlier in ((guess, _OUTLIER), (believed, _WIDE_OUTLIER)):
            found = self._fitted(rays, believed, start, outlier)
            if found.fits:
                return found
        return self._judged(rays, believed, _PRIOR)

    def _fitted(self, rays: Rays, believed: Pose, pose: Pose, outlier: float) -> Match:
        for _ in range(_STEPS):
            information, pull = np.diag(_PRIOR**-2.0), _PRIOR**-2.0 * _difference(believed, pose)
            for residuals, motion, sigma in self._residuals(_Seen(rays, pose), rays.met, 2.0 * outlier):
                weights = 1.0 / (sigma * (1.0 + (residuals / outlier) ** 2)) ** 2  # Geman-McClure
                information += (motion * weights[:, None]).T @ motion
                pull += motion.T @ (weights * residuals)
            x, y, turn = (-np.linalg.solve(information, pull)).tolist()
            pose = pose @ Pose.of(x, y, 0.0, yaw=turn)
            if outlier == _OUTLIER and max(abs(x), abs(y), abs(turn)) < _DONE:
                break
            outlier = max(_OUTLIER, _FALL * outlier)
        return self._judged(rays, pose, np.sqrt(np.diag(np.linalg.inv(information))))

    def _judged(self, rays: Rays, pose: Pose, sigma: Array) -> Match:
        """Counts the rays that speak for a pose, and those against it; what ended before it was held up."""
        seen, met = _Seen(rays, pose), rays.met
        ended, nearest = self._nearest(seen, met)
        on, against, through = np.zeros((3, len(met)), dtype=bool)
        for number, (block, (deep, far, _)) in enumerate(zip(self._blocks, ended, strict=True)):
            there = (np.abs(deep) < _OUTLIER) & (far < _OUTLIER)
            on |= (nearest == number) & there
            against |= (nearest == number) & ~there & (deep < _OUTLIER)
            inside, beyond, _ = block.passed(seen)
            through |= beyond & (inside > _DEEP)
        x, y, turn = sigma.tolist()
        return Match(pose, int(on.sum()), int(against.sum()), int(through.sum()), (x, y, turn))

    def _nearest(self, seen: _Seen, met: Flags) -> tuple[list[tuple[Array, Array, Array]], Array]:
        """Returns how rays ended at each block, and which of the blocks each ray ended nearest to."""
        ended = [block.ended(seen, met) for block in self._blocks]
        distances = np.stack(
            [np.where(np.isfinite(far), np.maximum(np.abs(deep), far), np.inf) for deep, far, _ in ended]
        )
        return ended, np.where(np.isfinite(distances.min(axis=0)), distances.argmin(axis=0), -1)

    def _residuals(self, seen: _Seen, met: Flags, before: float) -> Iterator[tuple[Array, Array, float]]:
        """Yields deviations [m], by how much a motion changes them, and their standard deviation [m].

        What ended farther before it was held up by something else [m], and says nothing.
        """
        ended, nearest = self._nearest(seen, met)
        for number, (block, (deep, _, motion)) in enumerate(zip(self._blocks, ended, strict=True)):
            mine = (nearest == number) & (deep < before)
            yield deep[mine], motion[mine], _NOISE
            inside, beyond, across = block.passed(seen)
            for wrong, margin in ((beyond & (inside > -_MARGIN), _MARGIN), (mine & (inside < _MARGIN), -_MARGIN)):
                yield inside[wrong] + margin, across[wrong], _BESIDE


def _difference(believed: Pose, pose: Pose) -> Array:
    between = believed.inverse() @ pose
    return np.array([*between.position[:2], wrap_angle(between.yaw)])


_SCANS = 25
"""Number of scans that are kept."""
_FEWEST = 4
"""Number of scans from which on they are fitted."""
_APART = 0.04
"""What a base drives [m] or turns [rad] from one to the next."""
_SOON = 2.5
"""Distance from which on a place is looked at [m]."""
_LOW = 0.05
"""What stands lower stands on the floor [m]."""


class Sighting:
    """What scans show of a thing; all in the frame of the odometry, which knows short ways best.

    Attributes:
        match: How the last scans fit to it; None before there are enough of them.
        seen: Where it was when they fitted last; None when they never did.

    Args:
        solid: Its shape.
        believed: Where it is believed to be.
    """

    def __init__(self, solid: Solid, believed: Pose) -> None:
        self._silhouette, self._believed = Silhouette(solid), believed
        self._scans: list[Rays] = []
        self._last: Pose | None = None
        self.match: Match | None = None
        self.seen: Pose | None = None

    def add(self, rays: Rays, base: Pose) -> None:
        """Takes a scan.

        Args:
            rays: Its rays.
            base: Where the base was.
        """
        guess = self.seen or self._believed
        moved = self._last is None or base.distance(self._last) + abs(wrap_angle(base.yaw - self._last.yaw)) > _APART
        if moved:
            self._last = base
        kept = self._scans if moved else self._scans[:-1]
        self._scans = [*kept, self._silhouette.telling(rays, guess)][-_SCANS:]
        if len(self._scans) >= _FEWEST:
            self.match = self._silhouette.match(Rays.joined(self._scans), self._believed, guess)
            if self.match.fits:
                self.seen = self.match.pose


def on_floor(context: RunContext, location: str) -> Obstacle | None:
    """Returns a location, or on what it stands, that stands on the floor; None where nothing there does."""
    at: str | None = location
    while at is not None:
        solid, pose = solid_of(context.world, at), map_pose(context, at)
        if solid is not None and pose is not None and pose.position[2] < _LOW:
            return Obstacle(at, solid, pose)
        placement = context.world.placement(at)
        whole = next(iter(context.world.subjects(v.HAS_A, at)), None)
        at = whole if placement is None else placement.place
    return None


class PlaceInSight:
    """The place that a base drives to, as the scanners of its robot see it.

    Attributes:
        body: What is looked at: the place, or on what it stands.

    Args:
        context: The run.
        robot: The robot.
        base: Its base.
        goal: Where the base drives there, in the map.
        thing: What is looked at.
    """

    def __init__(self, context: RunContext, robot: RobotSpec, base: Mobile, goal: Pose, thing: Obstacle) -> None:
        self.body = thing.id
        self._goal = goal
        self._context, self._robot, self._base = context, robot, base
        self._solid, self._believed = thing.solid, thing.pose
        self._around = obstacles(context, parts=False, without=frozenset({thing.id}))
        self._numbers = {spec.id: self._scan(spec).number for spec in robot.of(ScannerSpec)}
        self._sighting: Sighting | None = None
        self._known: tuple[Snapshot, Pose] | None = None

    @classmethod
    def of(cls, context: RunContext, robot: RobotSpec, base: Mobile, location: str, goal: Pose) -> PlaceInSight | None:
        """Returns the view of a location, or None: the robot has no scanner, or nothing there stands on the floor."""
        thing = on_floor(context, location) if robot.of(ScannerSpec) else None
        return None if thing is None else cls(context, robot, base, goal, thing)

    def look(self) -> None:
        """Takes the new scans; to be asked once per cycle."""
        snapshot = self._context.board.snapshot
        for spec in self._robot.of(ScannerSpec):
            scan = self._scan(spec)
            if scan.number == self._numbers[spec.id]:
                continue
            self._numbers[spec.id] = scan.number
            scanner = self._context.frames.at(snapshot).located(spec.id)
            if math.dist(scanner.position[:2], self._believed.position[:2]) > _SOON:
                continue
            to_odometry = self._odometry @ self._localised.inverse()
            if self._sighting is None:
                self._sighting = Sighting(self._solid, to_odometry @ self._believed)
            points = scanner.apply(np.reshape(scan.points, (-1, 3)))
            met = points[unexplained(points, self._around)]
            ends = to_odometry.apply(np.vstack([met, scanner.apply(np.reshape(scan.clear, (-1, 3)))]))
            start = np.asarray((to_odometry @ scanner).position)
            flags = np.arange(len(ends)) < len(met)
            self._sighting.add(Rays(np.broadcast_to(start, ends.shape), ends, flags), self._odometry)
            self._known = None

    @property
    def is_contradicted(self) -> bool:
        """True when rays say that it is not where it is believed to be, and do not show where it is."""
        sighting = self._sighting
        match = None if sighting is None or sighting.seen is not None else sighting.match
        return match is not None and match.through + match.against > max(_MANY, match.on)

    @property
    def pose(self) -> Pose | None:
        """Where it is in the map, seen from where the robot is localised; None if it is not seen."""
        if self._sighting is None or self._sighting.seen is None:
            return None
        return self._localised @ self._odometry.inverse() @ self._sighting.seen

    @property
    def robot_pose(self) -> Pose:
        """Where the robot is in the map, if the place is where it is believed to be; as localised if it is not seen.

        That takes effect little by little on the way: a small error in how the place is turned is a large one of where
        a robot is that is far from it, and no base follows a pose that jumps.
        """
        corrected, localised = self._corrected, self._localised
        left = math.dist(localised.position[:2], self._goal.position[:2])
        share = min(1.0, max(0.0, (_BEGINS - left) / (_BEGINS - _WHOLE)))
        between = localised.inverse() @ corrected
        x, y, _ = (share * one for one in between.position)
        return localised @ Pose.of(x, y, 0.0, yaw=share * between.yaw)

    @property
    def _corrected(self) -> Pose:
        """Where the robot would be in the map if all that is off were where it is localised."""
        snapshot = self._context.board.snapshot
        if self._known is None or self._known[0] is not snapshot:
            seen, localised = self.pose, self._localised
            self._known = snapshot, localised if seen is None else self._believed @ seen.inverse() @ localised
        return self._known[1]

    @property
    def is_far_off(self) -> bool:
        """True when it is not where it is believed to be, by more than a base should correct on its way."""
        corrected, localised = self._corrected, self._localised
        turned = abs(wrap_angle(corrected.yaw - localised.yaw))
        return math.dist(corrected.position[:2], localised.position[:2]) > _FAR or turned > _TURNED

    @property
    def _localised(self) -> Pose:
        return self._robot.pose(self._context.board.snapshot, self._context.board.guard)

    @property
    def _odometry(self) -> Pose:
        return self._context.board.guard.pose(self._base.spec, self._base.state)

    def _scan(self, spec: ScannerSpec) -> ScannerState:
        return self._context.board.snapshot.state(spec.id, ScannerState)


_BEGINS, _WHOLE = 1.5, 0.4
"""Distances from the goal between which that takes effect [m]."""
_FAR, _TURNED = 0.04, math.radians(1.5)
"""By what the place of a base may be corrected while it drives [m, rad]."""
