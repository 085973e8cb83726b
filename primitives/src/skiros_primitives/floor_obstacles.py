"""What a robot must not touch on the floor: things seen from above, and other robots."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import chain, product
from types import MappingProxyType

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from skiros_py.devices.arm import ArmSpec, ArmState
from skiros_py.devices.gripper import GripperSpec
from skiros_py.geometry import Array, Pose, Solid
from skiros_py.ports.cell import RobotSpec
from skiros_py.ports.kinematics import BASE_LINK, Kinematics
from skiros_py.ports.motion import Obstacle
from skiros_py.ports.paths import TALLEST, Layer, Outline, floor_area, hull, reach, swept
from skiros_py.skills.context import RunContext
from skiros_py.skills.surroundings import held_by, map_pose, obstacles
from skiros_py.world import vocabulary as v

_HEIGHT = 1.2
"""Assumed height of a base with its folded arm [m]."""
_HAND = 0.12
"""How far hand and camera stick out around the arm's tip [m]."""
_CORNERS = 8
_LINK = 0.08
"""How far links stick out around the line between their joints [m]."""
_END = 0.03
"""How far they stick out at its ends [m]."""
_PARTS = 0.15
"""Height of parts that may stand on things [m]."""
_APART = 0.03
"""Smallest distance from things in a posture for travelling [m]."""


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
        found += [_arm(context, other, tip, margin) for tip in _tips(context, resting)]
    return tuple(found)


def _arm(context: RunContext, robot: RobotSpec, tip: Pose, margin: float) -> Obstacle:
    """The block below an arm, from the centre of its base to its hand."""
    x, y, _ = tip.position
    along = Pose.of(x / 2.0, y / 2.0, 0.0, yaw=math.atan2(y, x))
    length, width = math.hypot(x, y) + 2.0 * (_HAND + margin), 2.0 * (_HAND + margin)
    base = robot.pose(context.board.snapshot, context.board.guard)
    return Obstacle(robot.id, Solid.box(length, width, _HEIGHT), base @ along)


def shape(
    context: RunContext, robot: RobotSpec, postures: Mapping[str, Sequence[float]] = MappingProxyType({})
) -> tuple[Layer, ...]:
    """Returns what a robot covers: its base up to its full height, and what of its arms sticks out.

    Args:
        context: The run.
        robot: The robot.
        postures: Joint angles of arms, by id [rad]; the others are as they are.
    """
    layers = [Layer(tuple(robot.outline))]
    base = hull(robot.outline)
    for arm in robot.of(ArmSpec):
        kinematics = context.ports.find(Kinematics, arm.id)
        if kinematics is not None:
            around = [
                covered_by_link(*piece) for piece in _pieces(context, robot, arm, kinematics, postures.get(arm.id))
            ]
            out = [layer for layer in around if not base.covers(hull(layer.outline))]
            if out:
                corners = tuple((float(x), float(y)) for x, y in shapely.get_coordinates(hull(outline(out)))[:-1])
                layers.append(Layer(corners, min(one.bottom for one in out), max(one.top for one in out)))
    return tuple(layers)


def reaches_over(context: RunContext, robot: RobotSpec, arm: str, posture: Sequence[float], *poses: Pose) -> bool:
    """Returns whether an arm would touch something, or a part that may stand on it, while its robot drives along poses.

    Args:
        context: The run.
        robot: The robot.
        arm: Id of the arm.
        posture: Its joint angles [rad].
        *poses: Poses of the base in the map; one alone for where it stands.
    """
    things = [one for one in obstacles(context, parts=False) if not rides(context, one.id, robot)]
    things += chain.from_iterable(context.pictures.unknown.values())
    lowest, highest = (end(pose.position[2] for pose in poses) for end in (min, max))  # a robot may fly
    for layer in shape(context, robot, {arm: posture})[1:]:
        area = shapely.union_all(swept(layer.outline, (poses[0], *poses)))
        bottom, top = layer.bottom + lowest - _PARTS, layer.top + highest
        if any(shapely.dwithin(floor_area(one.solid, one.pose, bottom, top), area, _APART) for one in things):
            return True
    return False


def rides(context: RunContext, element: str, robot: RobotSpec) -> bool:
    """Returns whether an element moves with the base of a robot."""
    frames = context.world.objects(element, v.POSE_FRAME)
    return any(robot.has(frame) or rides(context, frame, robot) for frame in frames)


def _pieces(
    context: RunContext, robot: RobotSpec, arm: ArmSpec, kinematics: Kinematics, posture: Sequence[float] | None
) -> Iterator[tuple[Array, float]]:
    """Yields the ends of each link of an arm, and the corners of what it holds, with how far it sticks out around them.

    All in the frame of the base [m].
    """
    positions = context.board.snapshot.state(arm.id, ArmState).positions if posture is None else posture
    poses = kinematics.poses(dict(zip(arm.joints, positions, strict=True)))
    link = arm.tip
    while (parent := kinematics.parents.get(link, BASE_LINK)) != BASE_LINK:
        yield np.array([poses[link].position, poses[parent].position]), _HAND if link == arm.tip else _LINK
        link = parent
    for gripper in robot.of(GripperSpec):
        if gripper.arm == arm.id and (holding := held_by(context, gripper.id)) is not None:
            corners = np.array(list(product(*np.transpose(holding[1].solid.bounds()))))
            yield (poses[arm.tip] @ holding[1].pose).apply(corners), 0.0


def covered_by_link(points: Array, radius: float) -> Layer:
    """Returns what a link covers that sticks out around the line between two points, or a body between its corners.

    Args:
        points: In the frame of the base [m], shape (n, 3).
        radius: How far it sticks out [m].
    """
    turns = np.linspace(0.0, 2.0 * np.pi, _CORNERS, endpoint=False)
    around = (points[:, None, :2] + radius * np.column_stack([np.cos(turns), np.sin(turns)])).reshape(-1, 2)
    way = points[1] - points[0]
    rise = abs(way[2]) / max(1e-9, float(np.linalg.norm(way)))
    beyond = max(min(radius, _END), radius * math.sqrt(max(0.0, 1.0 - rise**2)))  # as a rod that sticks out all around
    bottom, top = float(points[:, 2].min()) - beyond, float(points[:, 2].max()) + beyond
    return Layer(tuple((float(x), float(y)) for x, y in around), bottom, min(TALLEST, top))


def outline(layers: Sequence[Layer]) -> Outline:
    """Returns the outline of a robot on the floor, whatever the height."""
    return [point for layer in layers for point in layer.outline]


def _tips(context: RunContext, robot: RobotSpec) -> list[Pose]:
    """Returns the poses of the tips of a robot's arms in the frame of its base, as far as known."""
    states = context.board.snapshot.of(ArmState)
    found = [(arm, context.ports.find(Kinematics, arm.id)) for arm in robot.of(ArmSpec)]
    return [
        kinematics.pose(arm.tip, dict(zip(arm.joints, states[arm.id].positions, strict=True)))
        for arm, kinematics in found
        if kinematics is not None
    ]


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
    context: RunContext, outline: Outline, start: Pose, around: Sequence[Obstacle], area: BaseGeometry
) -> list[Pose]:
    """Returns poses to which a base may drive to give way, the nearest ones first; some may not be reachable.

    There is room to turn there, and they are in the part of the floor that the base stands in.

    Args:
        context: The run.
        outline: Outline of the robot while it drives.
        start: Where it stands.
        around: What it must not touch.
        area: Where its middle must not be.
    """
    here = shapely.Point(start.position[:2])
    narrowest = shapely.Point(0.0, 0.0).distance(hull(outline).boundary)
    closed = shapely.union_all([floor_area(one.solid, one.pose) for one in around])
    parts = shapely.get_parts(_floor(context, here).difference(closed.buffer(0.9 * narrowest)))
    within = shapely.union_all([part for part in parts if part.intersects(here)])
    room = within.difference(closed.buffer(reach(outline) + _CLEARANCE)).difference(area)
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
