"""The floor of a cell: areas that robots stand on and drive over, so that no two are ever in one place.

A base asks for its whole way at once and gets all of it or nothing, so no base stops half way to wait for another.
Paths are planned around robots that stand; so a claimed way waits only for robots that drive, and those arrive: one
robot always moves. If that is no longer so, because a robot has stopped on it meanwhile, or stretches an arm over it,
the way is blocked and its robot must plan another one.

A robot whose way is blocked by others that stand may keep asking for it, and gets it when they have left. Robots that
wait for each other in a ring would stand for ever: the last one of them that can is to give way, to where it is in no
way that the others wait for. So is a robot that waits for a further one that works, while others wait only for it.

An arm takes the floor below its whole motion before it moves. It waits for robots that are on their way there, and for
no one else, not even for wishes, so that no arm and no base ever wait for each other.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from itertools import pairwise

import shapely
from shapely.geometry.base import BaseGeometry

from skiros_py.execution.claims import Claims
from skiros_py.geometry import Pose
from skiros_py.ports.board import DeviceBoard
from skiros_py.ports.cell import RobotSpec
from skiros_py.ports.paths import Outline, Path, placed, swept
from skiros_py.world.terms import reached

_MARGIN = 0.06
"""Greatest distance of a base from its path [m]."""


class FloorAreas:
    """The areas of all robots of a cell; a :class:`skiros_py.skills.context.Floor`. For the control thread only.

    Args:
        board: Says where the robots are.
        robots: The robots of the cell.
        claims: Says whose devices are in use.
    """

    def __init__(self, board: DeviceBoard, robots: Sequence[RobotSpec], claims: Claims) -> None:
        self._board = board
        self._claims = claims
        self._robots = {robot.id: robot for robot in robots}
        self._outlines: dict[str, Outline] = {robot.id: robot.outline for robot in robots}
        self._owners = {device.id: robot.id for robot in robots for device in robot.devices}
        self._stretched: dict[str, Outline] = {}
        self._ways: list[FloorWay] = []

    def is_driving(self, robot: str) -> bool:
        """Returns True when a robot is on its way."""
        return any(way.granted for way in self._ways if way.robot == robot)

    def ask(self, robot: str, outline: Outline, start: Pose, path: Path) -> FloorWay:
        """Asks for the way along a path: all of it or nothing; first come, first served."""
        self._outlines[robot] = outline
        way = FloorWay(self, robot, _stretches(outline, start, path))
        self._ways.append(way)
        self.settle(changed=True)
        return way

    def stretch(self, arm: str, outline: Outline) -> tuple[str, ...]:
        """Takes the floor below an arm's motion; returns the robots that have to pass there before."""
        self.settle()
        robot = self._owners[arm]
        outline = outline or self._outlines[robot]
        area = self._placed(robot, outline)
        there = [way.robot for way in self._ways if way.granted and way.robot != robot and way.area.intersects(area)]
        if not there:
            self._stretched[arm] = outline
            self.settle(changed=True)
        return tuple(dict.fromkeys(there))

    def stretched(self, arm: str) -> Outline:
        """Returns above what an arm is or moves; nothing where it has not moved yet."""
        return self._stretched.get(arm, ())

    def settle(self, *, changed: bool = False) -> None:
        """Forgets the ways of those who have left them and stand; looks again who may go if anything is new."""
        left = [way for way in self._ways if way.released and self._stands(way.robot)]
        for way in left:
            self._ways.remove(way)
        changed = changed or bool(left)
        while changed:  # a robot that may go does not stand in the way of earlier ones any more
            changed = False
            for number, way in enumerate(self._ways):
                if not way.granted:
                    self._judge(way, self._ways[:number])
                    changed = changed or way.granted

    def remove(self, way: FloorWay) -> None:
        """Takes back a wish, or gives back a way, as soon as its base stands."""
        if not way.granted:
            self._ways.remove(way)
        self.settle(changed=True)

    def idle(self, robots: Sequence[str]) -> tuple[str, ...]:
        """Returns those of some robots that nothing runs on: they stay where they stand."""
        return tuple(r for r in robots if not any(self._claims.wanted(d.id) for d in self._robots[r].devices))

    def awaiting(self, way: FloorWay) -> list[FloorWay]:
        """Returns the ways that would become free if robots left that wait for a way themselves, with this one's."""
        waiting = {other.robot for other in self._ways if other.standing}
        return [o for o in self._ways if way.robot in o.standing and waiting.issuperset(o.standing)]

    def ring(self, way: FloorWay) -> list[FloorWay]:
        """Returns the ways, oldest first, whose robots wait for each other in a ring with this one's; or none."""
        standing = {other.robot: other.standing for other in self._ways if other.standing}
        behind = {robot: reached(ahead, lambda other: standing.get(other, ())) for robot, ahead in standing.items()}
        own = behind.get(way.robot, ())
        return [o for o in self._ways if o.robot in own and way.robot in behind.get(o.robot, ())]

    def _judge(self, way: FloorWay, before: Sequence[FloorWay]) -> None:
        others = [robot for robot in self._robots if robot != way.robot]
        standing = [robot for robot in others if not self.is_driving(robot) and self._stands_in(robot, way.area)]
        taken = [other for other in self._ways if other.granted and other.robot != way.robot]
        earlier = [other for other in before if not other.standing]  # one that cannot go delays no other
        moving = [other.robot for other in (*taken, *earlier) if other.area.intersects(way.area)]
        way.standing = tuple(standing)
        way.others = tuple(dict.fromkeys((*standing, *(robot for robot in moving if robot != way.robot))))
        way.granted = not way.others

    def _stands(self, robot: str) -> bool:
        carrier = self._robots[robot].carrier
        return carrier is None or self._board.stand([carrier.id])

    def _stands_in(self, robot: str, area: BaseGeometry) -> bool:
        arms = [outline for arm, outline in self._stretched.items() if self._owners[arm] == robot]
        return any(self._placed(robot, outline).intersects(area) for outline in (self._outlines[robot], *arms))

    def _placed(self, robot: str, outline: Outline) -> BaseGeometry:
        return placed(outline, self._robots[robot].pose(self._board.snapshot, self._board.guard))


class FloorWay(AbstractContextManager["FloorWay"]):
    """A way that a robot asked for; a :class:`skiros_py.skills.context.Way`.

    Attributes:
        robot: Whose it is.
        granted: True once the robot may go.
        released: True when it has been given back.
        standing: Ids of the robots that stand on it and are not driving, or have an arm above it.
        refused: True when its robot cannot give way.
        others: Ids of the robots because of which it is not free.
        area: What is left of it to drive over.
    """

    def __init__(self, floor: FloorAreas, robot: str, stretches: list[_Stretch]) -> None:
        self.robot = robot
        self.granted = False
        self.released = False
        self.standing: tuple[str, ...] = ()
        self.refused = False
        self.others: tuple[str, ...] = ()
        self._floor = floor
        self._stretches = stretches
        self.area = _union(stretches)

    @property
    def free(self) -> bool:
        """True when the base may go."""
        self._floor.settle()
        return self.granted

    @property
    def blocked(self) -> bool:
        """True when somebody who is not driving stands there, or has an arm there."""
        return bool(self.standing)

    def waits_for(self) -> tuple[str, ...]:
        """Returns the ids of the robots because of which it is not free."""
        return self.others

    def idle(self) -> tuple[str, ...]:
        """Returns the ids of robots that stand there, and that nothing runs on."""
        return self._floor.idle(self.standing)

    def to_leave(self) -> BaseGeometry | None:
        """Returns the floor that others wait for, if it is this robot that is to give way; else None."""
        awaiting = [] if self.refused or not self.standing else self._floor.awaiting(self)
        able = [way for way in self._floor.ring(self) if not way.refused and self._floor.awaiting(way)]
        if not awaiting or (able and able[-1] is not self):
            return None
        return shapely.union_all([way.area for way in awaiting])

    def refuse(self) -> None:
        """Says that the robot has no room to give way: another one of the ring is to."""
        self.refused = True

    def deadlock(self) -> tuple[str, ...]:
        """Returns the ids of robots that wait for each other in a ring with this one, if none of them can give way."""
        ring = self._floor.ring(self)
        asked = [way for way in ring if self._floor.awaiting(way)]
        return tuple(w.robot for w in ring if w is not self) if asked and all(w.refused for w in asked) else ()

    def passed(self, legs: float) -> None:
        """Gives back what lies behind: so many legs have been driven, 1.5 being half of the second."""
        if self._stretches[0].end <= legs:
            self._stretches = [stretch for stretch in self._stretches if stretch.end > legs]
            self.area = _union(self._stretches)
            self._floor.settle(changed=True)

    def release(self) -> None:
        """Gives the rest back; while the base still rolls, it stays taken."""
        if not self.released:
            self.released = True
            self._floor.remove(self)

    def __exit__(self, *_: object) -> None:
        self.release()


@dataclass(frozen=True, slots=True)
class _Stretch:
    """A piece of a way: what the robot covers there, and how many legs have been driven at its end."""

    area: BaseGeometry
    end: float


def _stretches(outline: Outline, start: Pose, path: Path) -> list[_Stretch]:
    """Returns the stretches of a path, and where the base ends; a turn is given back with the way after it."""
    progress, poses = zip(*path.poses(start), strict=True)
    stretches = [_Stretch(placed(outline, poses[-1]), math.inf)]
    areas = list(pairwise(progress)), swept(outline, poses)
    for (before, after), area in reversed(list(zip(*areas, strict=True))):
        last = stretches[-1]
        if after > before:
            stretches.append(_Stretch(area, after))
        else:
            stretches[-1] = _Stretch(shapely.union(last.area, area), last.end)
    return [_Stretch(shapely.buffer(one.area, _MARGIN), one.end) for one in reversed(stretches)]


def _union(stretches: Sequence[_Stretch]) -> BaseGeometry:
    return shapely.union_all([stretch.area for stretch in stretches])
