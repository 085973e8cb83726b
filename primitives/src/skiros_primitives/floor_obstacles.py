"""What a robot must not touch on the floor: things seen from above, and other robots."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from skiros_py.devices.arm import ArmSpec, ArmState
from skiros_py.geometry import Pose, Solid
from skiros_py.ports.cell import RobotSpec
from skiros_py.ports.kinematics import Kinematics
from skiros_py.ports.motion import Obstacle
from skiros_py.ports.paths import Outline, floor_area
from skiros_py.skills.context import RunContext
from skiros_py.skills.surroundings import map_pose
from skiros_py.world import vocabulary as v

_HEIGHT = 1.2
"""Assumed height of a base with its folded arm [m]."""
_HAND = 0.12
"""How far hand and camera stick out around the arm's tip [m]."""
_CORNERS = 8


def others(context: RunContext, robot: str) -> tuple[RobotSpec, ...]:
    """Returns all robots of the cell except one."""
    return tuple(other for other in context.cell.robots if other.id != robot)


def driving(context: RunContext, robot: str) -> list[str]:
    """Returns the ids of the other robots that are on their way."""
    return [other.id for other in others(context, robot) if context.floor.is_driving(other.id)]


def bodies(context: RunContext, robot: str) -> tuple[Obstacle, ...]:
    """Returns the robots besides one as obstacles: a block around each at its current pose."""
    return tuple(_block(context, other, other.outline, 0.0) for other in others(context, robot))


def _block(context: RunContext, robot: RobotSpec, outline: Outline, margin: float) -> Obstacle:
    """The block around an outline in the frame of a robot's base."""
    xs, ys = zip(*outline, strict=True)
    middle = Pose(((min(xs) + max(xs)) / 2.0, (min(ys) + max(ys)) / 2.0, 0.0))
    size = max(xs) - min(xs) + 2.0 * margin, max(ys) - min(ys) + 2.0 * margin
    base = robot.pose(context.board.snapshot, context.board.guard)
    return Obstacle(robot.id, Solid.box(*size, _HEIGHT), base @ middle)


def standing(context: RunContext, robot: str, *, margin: float) -> tuple[Obstacle, ...]:
    """Returns the other robots that do not drive, with their arms as currently or soon extended.

    Args:
        context: The run.
        robot: Id of the robot that is not to touch them.
        margin: By how much each is enlarged on each side [m].
    """
    there = [other for other in others(context, robot) if not context.floor.is_driving(other.id)]
    found = [_block(context, other, other.outline, margin) for other in there]
    for other in there:
        taken = {arm.id: context.floor.stretched(arm.id) for arm in other.of(ArmSpec)}
        found += [_block(context, other, outline, margin) for outline in taken.values() if outline]
        resting = replace(other, devices=tuple(arm for arm in other.of(ArmSpec) if not taken[arm.id]))
        found += [_arm(context, other, tip, margin) for tip in _tips(context, resting, now=True)]
    return tuple(found)


def _arm(context: RunContext, robot: RobotSpec, tip: Pose, margin: float) -> Obstacle:
    """The block below an arm, from the centre of its base to its hand."""
    x, y, _ = tip.position
    along = Pose.of(x / 2.0, y / 2.0, 0.0, yaw=math.atan2(y, x))
    length, width = math.hypot(x, y) + 2.0 * (_HAND + margin), 2.0 * (_HAND + margin)
    base = robot.pose(context.board.snapshot, context.board.guard)
    return Obstacle(robot.id, Solid.box(length, width, _HEIGHT), base @ along)


def outline(context: RunContext, robot: RobotSpec) -> Outline:
    """Returns a robot's floor outline while it drives: its base, and its hands in their travelling posture."""
    points = list(robot.outline)
    for tip in _tips(context, robot, now=False):
        turns = (2.0 * math.pi * corner / _CORNERS for corner in range(_CORNERS))
        points += [(tip.position[0] + _HAND * math.cos(t), tip.position[1] + _HAND * math.sin(t)) for t in turns]
    return points


def reach(points: Outline) -> float:
    """Returns how far an outline reaches from the centre of the base [m]."""
    return max(math.hypot(x, y) for x, y in points)


def _tips(context: RunContext, robot: RobotSpec, *, now: bool) -> list[Pose]:
    """Returns the poses of the tips of a robot's arms in the frame of its base, now or at home, as far as known."""
    states = context.board.snapshot.of(ArmState)
    tips: list[Pose] = []
    for arm in robot.of(ArmSpec):
        kinematics = context.ports.find(Kinematics, arm.id)
        if kinematics is not None:
            positions = states[arm.id].positions if now else arm.home
            tips.append(kinematics.pose(arm.tip, dict(zip(arm.joints, positions, strict=True))))
    return tips


_GRID = 0.25
"""Distance between the places aside that are considered [m]."""
_SPREAD = 1.0
"""Smallest distance between those that are proposed [m]."""
_MOST = 10
_FAR = 15.0
"""How far a robot drives to give way [m]."""
_CLEARANCE = 0.1
"""Distance to obstacles there [m]; a little more than on the way."""


def asides(
    context: RunContext, footprint: Outline, start: Pose, around: Sequence[Obstacle], area: BaseGeometry
) -> list[Pose]:
    """Returns poses to which a base may drive to give way, the nearest ones first; some may not be reachable.

    There is room to turn there, and they are in the part of the floor that the base stands in.

    Args:
        context: The run.
        footprint: Outline of the base.
        start: Where it stands.
        around: What it must not touch.
        area: Where its middle must not be.
    """
    here = shapely.Point(start.position[:2])
    narrowest = shapely.Point(0.0, 0.0).distance(shapely.MultiPoint(list(footprint)).convex_hull.boundary)
    closed = shapely.union_all([floor_area(one.solid, one.pose) for one in around])
    parts = shapely.get_parts(_floor(context, here).difference(closed.buffer(0.9 * narrowest)))
    within = shapely.union_all([part for part in parts if part.intersects(here)])
    room = within.difference(closed.buffer(reach(footprint) + _CLEARANCE)).difference(area)
    if room.is_empty:
        return []
    left, low, right, high = room.bounds
    places = np.stack(np.meshgrid(np.arange(left, right, _GRID), np.arange(low, high, _GRID)), axis=-1).reshape(-1, 2)
    places = places[shapely.contains_xy(room, places)]
    found: list[Pose] = []
    for x, y in places[np.argsort(np.hypot(*(places - start.position[:2]).T), kind="stable")].tolist():
        if len(found) < _MOST and all(math.dist((x, y), other.position[:2]) >= _SPREAD for other in found):
            yaw = math.atan2(y - start.position[1], x - start.position[0])
            found.append(Pose.of(x, y, start.position[2], yaw=yaw))
    return found


def _floor(context: RunContext, here: BaseGeometry) -> BaseGeometry:
    """Returns the floor around a point, as far as a robot drives to give way."""
    near: BaseGeometry = here.buffer(_FAR)
    for floor in context.world.instances(v.FLOOR):
        size, pose = context.world.value(floor, v.SIZE), map_pose(context, floor)
        if pose is not None and isinstance(size, tuple):
            near = near.intersection(floor_area(Solid.box(size[0], size[1], _HEIGHT), pose))
    return near
