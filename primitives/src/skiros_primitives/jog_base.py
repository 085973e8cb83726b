"""Jogs a base by a small step, for robot setup."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import ClassVar

import shapely
from shapely.geometry.base import BaseGeometry

from skiros_primitives import other_robots
from skiros_primitives.driving import DrivingPrimitive
from skiros_primitives.floor_outlines import covered, placed
from skiros_py.devices.arm import ArmSpec, ArmState
from skiros_py.devices.base import Base, BaseTwist
from skiros_py.geometry import Pose, wrap_angle
from skiros_py.ports.cell import RobotSpec
from skiros_py.ports.motion import BaseLeg, BasePath, Obstacle
from skiros_py.skills.floor import Outline
from skiros_py.skills.outcome import Failure, Outcome, Success
from skiros_py.skills.parameters import Kind, param
from skiros_py.skills.primitive import Execution
from skiros_py.skills.surroundings import obstacles
from skiros_py.world.vocabulary import BASE, ROBOT

_FARTHEST = 0.2
"""Longest step [m]."""
_TURN = 0.35
"""Greatest turn in one step [rad]."""
_SPEED, _TURNING = 0.1, 0.3
"""Greatest speeds [m/s, rad/s]."""
_CLOSE = 0.02
"""Distance kept from everything [m]; things already nearer must not get nearer."""
_NEARER = 0.001
"""Approaching by less than this does not count [m]."""
_SHORT = 0.002
"""A shorter distance counts as zero [m]."""
_STEP = math.radians(3.0)
"""Turn between two checked outlines [rad]."""
_STOWED = 0.05
"""Maximum joint error of an arm in its travelling posture [rad]."""
_PATIENCE = 20.0
"""Time limit for the straight path and for each turn [s]."""


class JogBase(DrivingPrimitive):
    """Drives a base by at most 0.2 m and 0.35 rad, with its arms at home, if nothing is touched.

    A sideways step is a turn, a straight path and a turn back: wheels do not roll sideways.
    """

    name: ClassVar[str] = "jog_base"
    takes: ClassVar[tuple[str, ...]] = ("robot",)

    @dataclass(frozen=True, slots=True)
    class Params:
        """Parameters."""

        base: str = param(BASE, "The base that drives.", kind=Kind.HARDWARE)
        robot: str = param(ROBOT, "The robot it carries along.", kind=Kind.PLANNING)
        dx: float = param("number", "How far ahead; 0.2 m at most.", default=0.0, unit="m")
        dy: float = param("number", "How far to the left; 0.2 m at most.", default=0.0, unit="m")
        dyaw: float = param("number", "How far it turns to the left; 0.35 rad at most.", default=0.0, unit="rad")

    def start(self) -> Failure | None:
        """Checks that the step is small and the arms are in their travelling posture."""
        way = math.hypot(self.params.dx, self.params.dy)
        if way > _FARTHEST or abs(self.params.dyaw) > _TURN:
            said = f"{way:.3g} m and {abs(self.params.dyaw):.3g} rad"
            return Failure(f"one step is at most {_FARTHEST:g} m and {_TURN:g} rad long, not {said}")
        stretched = [arm.id for arm in self._robot.of(ArmSpec) if not self._is_stowed(arm.id, arm.home)]
        if stretched:
            return Failure(f"{', '.join(stretched)} is stretched out: bring it home before the base moves")
        return None

    def execute(self) -> Execution[Outcome]:
        """Drives if the way is free, and returns how far it got."""
        base = Base(self.context.board, self.params.base)
        before = base.state.pose
        goal = before @ Pose.of(self.params.dx, self.params.dy, 0.0, yaw=self.params.dyaw)
        path = _path(before, goal)
        touched = self._touched(before, path)
        if touched:
            return Failure(f"{self.params.base} would touch {touched}")
        with self.context.floor.ask(self.params.robot, self._robot.outline, before, path) as way:
            if not way.free:
                return Failure(f"{' and '.join(way.waits_for())} is in the way")
            self.leave("is moved by hand")
            arrived = yield from self._drive(base, path)
        return self._came(before.inverse() @ base.state.pose, arrived=arrived)

    @property
    def _robot(self) -> RobotSpec:
        return self.context.cell.group_of(self.params.base)

    def _is_stowed(self, arm: str, home: tuple[float, ...]) -> bool:
        now = self.context.board.snapshot.state(arm, ArmState).positions
        return max(abs(is_ - wanted) for is_, wanted in zip(now, home, strict=True)) <= _STOWED

    # ------------------------------------------------------------------ obstacles

    def _touched(self, start: Pose, path: BasePath) -> str:
        """Returns the first thing that would be touched or come too near; empty if the way is free.

        Folded arms are above everything except other robots.
        """
        things = [o for o in obstacles(self.context, parts=False) if not self.rides(o.id)]
        robots = other_robots.standing(self.context, self.params.robot, margin=0.0)
        outline = other_robots.outline(self.context, self._robot)
        near = _nearing(things, self._robot.outline, start, path) + _nearing(robots, outline, start, path)
        return " and ".join(near)

    # ------------------------------------------------------------------ driving

    def _drive(self, base: Base, path: BasePath) -> Execution[bool]:
        for leg in path.legs:
            x, y, _ = base.state.pose.position
            along = math.atan2(leg.y - y, leg.x - x) + (math.pi if leg.backwards else 0.0)
            if not ((yield from self._turn(base, along)) and (yield from self._straight(base, leg))):
                return False
        arrived = yield from self._turn(base, path.heading)
        yield from self.stand(base)
        return arrived

    def _turn(self, base: Base, heading: float) -> Execution[bool]:
        return (yield from self.turn(base, heading, fastest=_TURNING, patience=_PATIENCE))

    def _straight(self, base: Base, leg: BaseLeg) -> Execution[bool]:
        """Drives along its heading until it is level with the leg's end."""
        limit, deadline = base.spec.max_linear_acceleration, self.context.now + _PATIENCE
        while self.context.now < deadline:
            left = _ahead(base.state.pose, leg)
            if abs(left) < _SHORT:
                return True
            speed = min(_SPEED, math.sqrt(1.6 * limit * abs(left)), 4.0 * abs(left))
            base.command(BaseTwist(math.copysign(speed, left), 0.0))
            yield
        return False

    def _came(self, step: Pose, *, arrived: bool) -> Outcome:
        x, y, _ = step.position
        said = f"by {x:.3f} m ahead, {y:.3f} m to the left and {step.yaw:.3f} rad"
        return Success(f"moved {said}") if arrived else Failure(f"{self.params.base} is stuck: it moved {said}")


def _path(start: Pose, goal: Pose) -> BasePath:
    """The straight path, driven forwards or backwards, whichever needs the smaller turn."""
    x, y, _ = (start.inverse() @ goal).position
    if math.hypot(x, y) < _SHORT:
        return BasePath((), goal.yaw)
    return BasePath((BaseLeg(goal.position[0], goal.position[1], backwards=x < 0.0),), goal.yaw)


def _ahead(pose: Pose, leg: BaseLeg) -> float:
    """How far a leg's end is ahead of the base [m]; negative if behind."""
    dx, dy = leg.x - pose.position[0], leg.y - pose.position[1]
    return dx * math.cos(pose.yaw) + dy * math.sin(pose.yaw)


def _stations(start: Pose, path: BasePath) -> Iterator[Pose]:
    """Yields poses along the path, close enough for collision checks of the outline."""
    at, heading = start.position, start.yaw
    for leg in path.legs:
        along = math.atan2(leg.y - at[1], leg.x - at[0]) + (math.pi if leg.backwards else 0.0)
        yield from _turning(at, heading, along)
        middle = ((at[0] + leg.x) / 2.0, (at[1] + leg.y) / 2.0, 0.0)
        yield Pose.of(*middle, yaw=along)
        at, heading = (leg.x, leg.y, 0.0), along
    yield from _turning(at, heading, path.heading)


def _turning(at: tuple[float, float, float], before: float, after: float) -> Iterator[Pose]:
    turn = wrap_angle(after - before)
    count = max(1, math.ceil(abs(turn) / _STEP))
    for number in range(count + 1):
        yield Pose.of(at[0], at[1], 0.0, yaw=before + turn * number / count)


def _nearing(around: Sequence[Obstacle], outline: Outline, start: Pose, path: BasePath) -> list[str]:
    """Returns the ids of things that an outline comes too near to: nearer than the margin and than at the start."""
    standing = placed(outline, start)
    area = shapely.union_all([placed(outline, pose) for pose in _stations(start, path)])
    return [obstacle.id for obstacle in around if _too_near(covered(obstacle), standing, area)]


def _too_near(thing: BaseGeometry, standing: BaseGeometry, area: BaseGeometry) -> bool:
    now, then = float(shapely.distance(standing, thing)), float(shapely.distance(area, thing))
    return then < _CLOSE and (then <= 0.0 or then < now - _NEARER)
