"""Paths of bases: backwards out of a dock, around obstacles, straight ahead into the next dock.

An omnidirectional base may also glide, in any direction from its heading: straight to its goal, or out of one dock and
into the next on any side, turning meanwhile. It glides where that is faster.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations, pairwise, product

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from skiros_py.devices.base_curves import Curve, Speeds
from skiros_py.geometry import Array, Pose, wrap_angle
from skiros_py.motion.disc_space import DiscSpace, Point
from skiros_py.ports.motion import BasePathRequest, NoMotion, Obstacle
from skiros_py.ports.paths import BaseLeg, BasePath, Layer, floor_area, placed, reach, swept

_THERE = 0.003  # [m] this near the goal ...
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
            return NoMotion.because("collision", f"at its goal the base would touch {touched}")
        found = floor.ways()
        ways = [] if isinstance(found, NoMotion) else found
        fastest = sorted((_driven(way, floor) for way in ways), key=lambda one: one.duration)[:_BEST]
        paths = [_tightened(one, floor) for one in fastest]
        if request.glides:
            glide = _glide(floor, min((one.duration for one in paths), default=math.inf))
            paths += [glide] if glide is not None else []
        if paths:
            return min(paths, key=lambda one: one.duration).path
        if isinstance(found, NoMotion):
            return found
        reason = f"there is no way to the goal that is wide enough for the base{_without(request)}"
        return NoMotion.because("not found", reason)


def _without(request: BasePathRequest) -> str:
    """Returns in words which single obstacles are to blame, the smallest first: without it there would be a way."""
    areas = _outlines(request.obstacles, Layer((), 0.0))
    names = sorted(areas, key=lambda name: float(areas[name].area))
    without = {name: tuple(one for one in request.obstacles if one.id != name) for name in names}
    ways = {name: _Floor(replace(request, obstacles=without[name])).ways() for name in names}
    blamed = [name for name, found in ways.items() if found and not isinstance(found, NoMotion)]
    return f"; without {' or '.join(blamed)} there would be one" if blamed else ""


@dataclass(frozen=True, slots=True)
class _Driven:
    """A way, its path, and about how long that takes [s]."""

    way: Sequence[Point]
    path: BasePath
    duration: float


def _driven(way: Sequence[Point], floor: _Floor) -> _Driven:
    path = BasePath(_legs(floor.start, way, floor.space), floor.goal.yaw)
    return _Driven(way, path, _duration(path, floor.start))


_BEST = 2
"""How many ways are tightened."""
_MOVES = (0.4, 0.2, 0.1, 0.05)
"""By how much points of a way are moved [m]."""


def _tightened(best: _Driven, floor: _Floor) -> _Driven:
    """Moves the points of a way as long as that makes it faster, like an elastic band."""
    for step in _MOVES:
        before = None
        while before is not best:
            before = best
            for number in range(len(best.way) - 1):
                moved = (_driven(way, floor) for way in floor.moved(best.way, number, step))
                fastest = min(moved, key=lambda one: one.duration, default=best)
                if fastest.duration < best.duration - _WORTH:
                    best = fastest
    return best


_WORTH = 0.02
"""What a move must save [s]."""
_TYPICAL = Speeds(0.8, 1.2, 0.5, 1.5, 0.4)
"""Limits of the base for which the fastest way is chosen."""
_STOP = 0.5
"""Time that a stop takes, until the base stands [s]."""
_COARSE = 0.04
"""Distance between the points at which speeds are compared [m]."""


def _duration(path: BasePath, start: Pose) -> float:
    """Returns about how long a path takes [s]."""
    duration, here = 0.0, start
    for leg in path.legs:
        turn = _TYPICAL.turning(wrap_angle(leg.heading(here) - here.yaw))
        duration += turn + _TYPICAL.duration(Curve(leg, here, _COARSE)) + _STOP
        x, y, yaw = leg.points(here)[-1]
        here = Pose.of(x, y, 0.0, yaw=yaw)
    return duration + _TYPICAL.turning(wrap_angle(path.heading - here.yaw))


_SIDES = ((-1.0, 0.0), (0.0, 1.0), (0.0, -1.0), (1.0, 0.0))
"""Directions in which a base may glide out of a dock, or from which into it: behind, beside, ahead."""
_EXITS = 6
"""How many pairs of ways out of a dock and into the next are searched between, those with the shortest ways first."""
_TURNED_IN = 0.5
"""Way on which a base that glides turns by 1 rad, if there is so much [m]."""
_JUMP = 0.15
"""Greatest turn between two poses [rad]."""
_LONG = 0.4
"""Way between two docks from which a base that glides may look ahead there [m]."""
_ROUNDED = (1.0, 0.5, 0.25, 0.0)
"""Shares of the room at corners on which they are rounded: the widest are tried first."""
_CLOSE = 0.3
"""Within so much way of its docks a base may glide as near to things as there [m]."""


def _glide(floor: _Floor, fastest: float) -> _Driven | None:
    """Returns the fastest path on which an omnidirectional base turns on the way; None where none is faster.

    Args:
        floor: The free space.
        fastest: Duration of the fastest other path [s].
    """
    start, goal = floor.start, floor.goal
    legs = [BaseLeg.gliding(*_between_poses([start, goal], [start.yaw, _same_turn(start.yaw, goal.yaw)]))]
    for way in floor.glides():
        for share in _ROUNDED:
            points = _rounded(way, share)
            legs += [BaseLeg.gliding(*poses) for poses in _headings(points, start, goal, way) if _is_smooth(poses)]
    found = [_Driven((), path, _duration(path, start)) for path in (BasePath((leg,), goal.yaw) for leg in legs)]
    quick = sorted((one for one in found if one.duration < fastest), key=lambda one: one.duration)
    return next((one for one in quick if floor.glides_freely(one.path)), None)


def _same_turn(before: float, yaw: float) -> float:
    return before + wrap_angle(yaw - before)


def _between_poses(ends: Sequence[Pose], yaws: Sequence[float]) -> list[Pose]:
    """Returns poses close together on a straight line, turning evenly."""
    way = max(math.dist(_xy(ends[0]), _xy(ends[1])), abs(yaws[1] - yaws[0]) / math.pi)
    shares = np.linspace(0.0, 1.0, max(2, math.ceil(way / _FINE) + 1))
    (x0, y0), (x1, y1) = map(_xy, ends)
    line = zip(np.interp(shares, (0, 1), (x0, x1)), np.interp(shares, (0, 1), (y0, y1)), strict=True)
    headings = np.interp(_eased(shares), (0, 1), yaws)
    return [Pose.of(float(x), float(y), 0.0, yaw=float(yaw)) for (x, y), yaw in zip(line, headings, strict=True)]


def _eased(share: Array) -> Array:
    """Returns a share that grows without a jump in its rate, from 0 to 1."""
    return np.asarray(share * share * (3.0 - 2.0 * share))


def _rounded(way: Sequence[Point], share: float) -> Array:
    """Returns points close together on a way whose corners are parabolas, shape (n, 2)."""
    corners = np.array(way)
    lengths = np.hypot(*np.diff(corners, axis=0).T)
    points = [corners[0]]
    for number in range(1, len(corners) - 1):
        half = share * min(lengths[number - 1] / 2.0, lengths[number] / 2.0, _WIDEST)
        before, here, after = corners[number - 1 : number + 2]
        first = here + (before - here) * half / lengths[number - 1]
        last = here + (after - here) * half / lengths[number]
        time = np.linspace(0.0, 1.0, 1 + math.ceil(2.0 * half / _FINE))[:, None]
        points += list((1.0 - time) ** 2 * first + 2.0 * time * (1.0 - time) * here + time**2 * last)
    points.append(corners[-1])
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(np.array(points), axis=0).T))])
    even = np.linspace(0.0, along[-1], max(2, math.ceil(along[-1] / _FINE) + 1))
    return np.column_stack([np.interp(even, along, column) for column in np.array(points).T])


def _headings(points: Array, start: Pose, goal: Pose, way: Sequence[Point]) -> Iterator[list[Pose]]:
    """Yields a way with headings: turning evenly from dock to dock; or looking ahead between them.

    While it leaves a dock, and while it comes to the next one, the heading is that of the dock.
    """
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    out, into = math.dist(way[0], way[1]), along[-1] - math.dist(way[-2], way[-1])
    if into - out < _FINE:
        out = into = along[-1] / 2.0
    share = np.clip((along - out) / max(into - out, _FINE), 0.0, 1.0)
    yield _posed(points, start.yaw + wrap_angle(goal.yaw - start.yaw) * _eased(share))
    if into - out < _LONG:
        return
    ahead = np.unwrap(np.arctan2(*np.gradient(points, axis=0).T[::-1]))
    first, last = (float(np.interp(place, along, ahead)) for place in (out + _LONG / 2.0, into - _LONG / 2.0))
    full = start.yaw + wrap_angle(first - start.yaw) - first  # whole turns
    ahead, last = ahead + full, last + full
    end = last + wrap_angle(goal.yaw - last)
    room = [max(_TURNED_IN * abs(angle), _FINE) for angle in (wrap_angle(first - start.yaw), end - last)]
    scale = min(1.0, (into - out) / sum(room))
    left = _eased(np.clip((along - out) / (scale * room[0]), 0.0, 1.0))
    near = _eased(np.clip((along - into) / (scale * room[1]) + 1.0, 0.0, 1.0))
    yield _posed(points, (1.0 - left) * start.yaw + (left - near) * ahead + near * end)


def _is_smooth(poses: Sequence[Pose]) -> bool:
    """Returns whether a base turns little from pose to pose; one that looks ahead does not at sharp corners."""
    return all(abs(wrap_angle(after.yaw - before.yaw)) < _JUMP for before, after in pairwise(poses))


def _posed(points: Array, yaws: Array) -> list[Pose]:
    return [Pose.of(x, y, 0.0, yaw=yaw) for (x, y), yaw in zip(points.tolist(), yaws.tolist(), strict=True)]


_SHARPEST = math.radians(100.0)
"""The base turns on the spot at sharper corners."""
_WIDEST = 1.5
"""Longest way before and after a corner on which it is rounded [m]."""
_NARROWEST = 0.1
"""Shortest [m]."""
_FINE = 0.04
"""Distance between points on a rounded corner [m]."""

Corner = list[tuple[float, float, float]]
"""Points of a rounded corner [m] and the headings there [rad]."""


def _legs(start: Pose, way: Sequence[Point], space: DiscSpace) -> tuple[BaseLeg, ...]:
    """Returns the legs of a way with rounded corners: one leg for all that is driven without a turn on the spot."""
    here = _xy(start)
    points = [here, *(point for before, point in pairwise((here, *way)) if math.dist(point, before) > _NO_WAY)]
    ahead = (math.cos(start.yaw), math.sin(start.yaw))
    behind = len(points) > 1 and float(np.subtract(points[1], here) @ ahead) < -_NO_WAY and here != way[0]
    legs: list[BaseLeg] = []
    via: Corner = []
    room = [math.dist(a, b) / 2.0 for a, b in pairwise(points)]
    for number in range(1, len(points)):
        reverses = behind and number == 1
        corner = None
        if number < len(points) - 1:
            last = number == len(points) - 2  # the end of the last stretch stays straight
            before = 2.0 * room[0] if number == 1 else room[number - 1]
            half = min(before, 2.0 * room[number] - _RUN_UP if last else room[number], _WIDEST)
            corner = _corner(points[number - 1 : number + 2], half, space, reverses=reverses)
        if corner is None:
            legs.append(BaseLeg(*points[number], backwards=reverses, via=tuple(via)))
            via = []
        else:
            via += corner
    return tuple(legs)


_RAMPS = {False: 1.0, True: 0.4}
"""Share of a rounded corner, driven ahead or with a reversal, in which its turn grows or falls."""
_PACE = 0.06
"""Turn between two points of a rounded corner [rad]."""


def _corner(lines: Sequence[Point], half: float, space: DiscSpace, *, reverses: bool) -> Corner | None:
    """Returns a curve around a corner, as wide as there is room; None where the base has to turn on the spot.

    Driven ahead, its curvature grows evenly from zero and falls back to it, so the base need not stop to steer. A base
    that comes backwards turns while it stops and drives ahead: its speed changes evenly. Either way the two halves are
    mirror images, so the curve leaves the first line as far before the corner as it meets the second one behind it.

    Args:
        lines: Where the way comes from, the corner, and where it goes to.
        half: How long before and after the corner it may leave the straight lines [m].
        space: Where the middle of the base may be.
        reverses: Whether the base comes backwards, and leaves ahead.
    """
    incoming, outgoing = np.diff(lines, axis=0)
    incoming, outgoing = incoming / np.linalg.norm(incoming), outgoing / np.linalg.norm(outgoing)
    if float(incoming @ outgoing) < math.cos(_SHARPEST):
        return None
    first, last = (math.atan2(y, x) for x, y in (-incoming if reverses else incoming, outgoing))
    turn = wrap_angle(last - first)
    time = np.linspace(-1.0, 1.0, 2 * math.ceil(max(abs(turn) / _PACE, half / _FINE)) + 1)
    rate = np.minimum(1.0, (1.0 - np.abs(time)) / _RAMPS[reverses])
    turned = np.concatenate([[0.0], np.cumsum(rate[1:] + rate[:-1])])
    yaws = first + turn * turned / turned[-1]
    middles = (yaws[1:] + yaws[:-1]) / 2.0
    steps = np.diff(time**2 if reverses else time)[:, None] * np.column_stack([np.cos(middles), np.sin(middles)])
    path = np.vstack([[0.0, 0.0], np.cumsum(steps, axis=0)])
    path = path * np.linalg.norm(incoming + outgoing) / np.linalg.norm(path[-1]) - incoming
    while half >= _NARROWEST:
        points = lines[1] + half * path
        if space.all_free(points):
            return [(x, y, yaw) for (x, y), yaw in zip(points.tolist(), yaws.tolist(), strict=True)]
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
_FURTHER = (-0.5, 0.5)
"""How much farther than to where there is room to turn the base may drive first [m]."""


class _Floor:
    """The free space of the robot among the outlines of one request."""

    def __init__(self, request: BasePathRequest) -> None:
        self.start, self.goal = request.start, request.goal
        self._layers = [(layer.outline, _outlines(request.obstacles, layer)) for layer in request.shape]
        self._open, self._clearance = request.clearance, min(_DOCK_CLEARANCE, request.clearance)
        discs = [(area, reach(outline)) for outline, areas in self._layers for area in areas.values()]
        self._spaces = [DiscSpace(discs, request.clearance + room) for room in _ROOM]
        self.space = self._spaces[-1]

    def ways(self) -> list[list[Point]] | NoMotion:
        """Returns ways from where there is room to turn to the goal, perhaps none; or why it cannot begin or end there.

        They are short, or have more room to round corners.
        """
        found = []
        gates = self._gates()
        for space in reversed(self._spaces):
            outs, entries = self._outs(space), self._entries(space)
            if space is self.space and not outs:
                reason = f"the base cannot leave where it stands: {self._nearest(self.start)} is in the way"
                return NoMotion.because("collision", reason)
            if space is self.space and not entries:
                reason = f"the base cannot drive straight into its goal: {self._before(self.goal)} is in the way"
                return NoMotion.because("collision", reason)
            for entry in entries:
                way = space.shortest(outs[0], _xy(entry), gates) if outs else None
                if way is not None:
                    others = (out for out in outs[1:] if space.sees(out, way[1]))
                    found += [[out, *way[1:], _xy(self.goal)] for out in (way[0], *others)]
        return found

    def _gates(self) -> list[tuple[Point, Point]]:
        """Returns the ends of straight ways between two obstacles, where there is room to turn again."""
        found = []
        turning = 2.0 * (max(reach(outline) for outline, _ in self._layers) + self._open)
        things = [area for _, areas in self._layers for whole in areas.values() for area in shapely.get_parts(whole)]
        for one, other in combinations(things, 2):
            if 0.0 < one.distance(other) < turning:
                (x0, y0), (x1, y1) = shapely.get_coordinates(shapely.shortest_line(one, other)).tolist()
                middle = Pose.of((x0 + x1) / 2.0, (y0 + y1) / 2.0, 0.0, yaw=math.atan2(x0 - x1, y1 - y0))
                ends = [self._gate_end(middle, sign) for sign in (-1.0, 1.0)]
                if ends[0] is not None and ends[1] is not None:
                    found.append((ends[0], ends[1]))
        return found

    def _gate_end(self, middle: Pose, sign: float) -> Point | None:
        """Returns where there is room to turn straight ahead of the middle of a gate, or behind it."""
        free = self._first_free(middle, self.space, (sign, 0.0), 0.0, self._clearance)
        further = free @ Pose((sign * _RUN_UP, 0.0, 0.0)) if free is not None else None
        found = [pose for pose in (further, free) if pose is not None and self.space.free(_xy(pose))]
        return _xy(found[0]) if found else None

    def _outs(self, space: DiscSpace) -> list[Point]:
        """Returns where there is room to turn: straight behind the start, as if it stood in a dock, or else ahead.

        The first one is the nearest.
        """
        clearance = self._clearance_at(self.start)
        nearest = self._first_free(self.start, space, (-1.0, 0.0), 0.0, clearance)
        nearest = nearest or self._first_free(self.start, space, (1.0, 0.0), 0.0, clearance)
        further = (nearest @ Pose((way, 0.0, 0.0)) for way in _FURTHER) if nearest is not None else ()
        free = (out for out in further if space.free(_xy(out)) and not self.touched(self.start, out, clearance))
        return [_xy(out) for out in (nearest, *free) if out is not None]

    def _entries(self, space: DiscSpace) -> list[Pose]:
        """Returns where the last straight stretch may begin: behind the goal, or at it if nothing behind is free."""
        goal, clearance = self.goal, self._clearance_at(self.goal)
        run_up = self._first_free(goal, space, (-1.0, 0.0), _RUN_UP, clearance)
        if run_up is None:
            return [goal] if space.free(_xy(goal)) else []
        entries = [run_up @ Pose((-earlier, 0.0, 0.0)) for earlier in _EARLIER]
        return [entry for entry in entries if not self.touched(goal, entry, clearance)]

    def glides(self) -> list[list[Point]]:
        """Returns ways on which an omnidirectional base may glide, out of its dock and into the next on any side."""
        start, goal, space = self.start, self.goal, self.space

        def beside(dock: Pose) -> list[Point]:
            free = (self._first_free(dock, space, side, 0.0, self._clearance_at(dock)) for side in _SIDES)
            return list(dict.fromkeys(_xy(pose) for pose in free if pose is not None))

        def length(pair: tuple[Point, Point]) -> float:
            return math.dist(_xy(start), pair[0]) + math.dist(*pair) + math.dist(pair[1], _xy(goal))

        pairs = sorted(product(beside(start), beside(goal)), key=length)[:_EXITS]
        ways = (space.shortest(out, entry) for out, entry in pairs)
        whole = ([_xy(start), *way, _xy(goal)] for way in ways if way is not None)
        return [_without_stops(way) for way in whole]

    def glides_freely(self, path: BasePath) -> bool:
        """Returns whether the robot keeps its distance from everything on a path; near docks, what it keeps there."""
        poses = [pose for _, pose in path.poses(self.start, way=_GLIDED, turn=_GLIDED)]
        docks = (self.start, self._clearance_at(self.start)), (self.goal, self._clearance_at(self.goal))
        clearances = [
            min([self._open, *(kept for dock, kept in docks if math.dist(_xy(pose), _xy(dock)) <= _CLOSE)])
            for pose in poses
        ]
        least = np.minimum(clearances[1:], clearances[:-1])
        for outline, areas in self._layers:
            distances = shapely.distance(shapely.union_all(list(areas.values())), np.array(swept(outline, poses)))
            if (distances <= least).any():  # the distance of nothing is not a number
                return False
        return True

    def moved(self, way: Sequence[Point], number: int, step: float) -> Iterator[list[Point]]:
        """Yields a way with one of its points moved; the first and the last but one stay in line with their docks."""
        last = number == len(way) - 2
        dock = self.start if number == 0 else self.goal if last else None
        frame = Pose.of(*way[number], 0.0, yaw=(dock or self.goal).yaw)
        for x, y in ((step, 0.0), (-step, 0.0), (0.0, step), (0.0, -step))[: 2 if dock else 4]:
            moved = frame @ Pose((x, y, 0.0))
            beside = way[max(0, number - 1) : number + 1 + (not last)]
            if not (self.space.free(_xy(moved)) and all(self.space.sees(_xy(moved), other) for other in beside)):
                continue
            if last and (self.goal.inverse() @ moved).position[0] > -_RUN_UP:
                continue
            if dock is None or not self.touched(dock, moved, self._clearance_at(dock)):
                yield [*way[:number], _xy(moved), *way[number + 1 :]]

    def _before(self, dock: Pose) -> str:
        """Returns the first obstacle behind a dock, from where the base comes; or else the nearest one."""
        poses = (dock @ Pose((-step * _STEP, 0.0, 0.0)) for step in range(math.ceil(_FARTHEST / _STEP)))
        touched = (self.touched(dock, pose, self._clearance_at(dock)) for pose in poses)
        return next(filter(None, touched), self._nearest(dock))

    def _nearest(self, pose: Pose) -> str:
        """Returns the obstacle nearest to the robot at a pose."""
        return min(self._distances(pose), default=(0.0, ""))[1]

    def _distances(self, pose: Pose) -> Iterator[tuple[float, str]]:
        for outline, areas in self._layers:
            here = placed(outline, pose)
            yield from ((float(shapely.distance(area, here)), name) for name, area in areas.items())

    def _first_free(self, dock: Pose, space: DiscSpace, side: Point, least: float, clearance: float) -> Pose | None:
        """Returns the first pose straight ahead of a dock, behind or beside it, where there is room to turn."""
        for step in range(math.ceil(least / _STEP), math.ceil(_FARTHEST / _STEP) + 1):
            pose = dock @ Pose((side[0] * step * _STEP, side[1] * step * _STEP, 0.0))
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


_GLIDED = 0.1
"""Greatest distance [m] and turn [rad] between two poses at which a path is checked on which a base glides."""


def _without_stops(way: Sequence[Point]) -> list[Point]:
    """Returns a way without points that are no way from the one before."""
    return [way[0], *(point for before, point in pairwise(way) if math.dist(point, before) > _NO_WAY)]


def _xy(pose: Pose) -> Point:
    return pose.position[0], pose.position[1]
