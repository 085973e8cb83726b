"""Pictures for the planner of an arm, with all that they may show and that is known."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from skiros_primitives.surfaces import support_region
from skiros_py.devices.arm import ArmSpec
from skiros_py.devices.gripper import GripperSpec
from skiros_py.geometry import Array, Pose, Primitive, Solid
from skiros_py.ports.cell import RobotSpec
from skiros_py.ports.frames import FrameTree
from skiros_py.ports.kinematics import BASE_LINK
from skiros_py.ports.motion import DepthView, Obstacle
from skiros_py.ports.values import DepthImage
from skiros_py.skills.context import RunContext
from skiros_py.skills.surroundings import held_by, map_pose, solid_of
from skiros_py.world import vocabulary as v

_STRIDE = 2
"""Of the rows and columns of a picture, every so many is used."""
_HEIGHT = 1.2
"""Height of a robot whose links are not known [m]."""
_LINK = 0.12
"""How far links stick out around the line between their joints, and bases above where links begin on them [m]."""
_FINGER = 0.03
"""The same around what is on a hand [m]."""
_NEAR = 2.5
"""How far from a camera places may be that it shows [m]."""
_APART = 0.05
"""Where another robot is, is uncertain by so much [m]."""


def depth_view(context: RunContext, arm: str, image: DepthImage, camera: str, around: Sequence[Obstacle]) -> DepthView:
    """Returns a picture for the planner of an arm.

    Args:
        context: The run.
        arm: Id of the arm.
        image: The picture.
        camera: Id of the camera that took it.
        around: What is believed to stand around, with the errors of where it is.
    """
    tree, k = context.frames.at(image.snapshot), image.intrinsics
    depth = image.depth[::_STRIDE, ::_STRIDE].copy()
    height, width = depth.shape
    cx, cy = k.cx / _STRIDE, k.cy / _STRIDE
    intrinsics = replace(k, width=width, height=height, fx=k.fx / _STRIDE, fy=k.fy / _STRIDE, cx=cx, cy=cy)
    own, camera_pose = context.cell.group_of(arm), tree.located(camera)
    near = (one for one in around if math.dist(one.pose.position, camera_pose.position) < _NEAR)
    known = (*around, *(block for one in near if (block := _unlocated(context, one.id)) is not None))
    moving = tuple(
        replace(one, error=0.0 if robot is own else _APART)
        for robot in context.cell.robots
        for one in _robot(context, robot, tree)
    )
    return DepthView(arm, depth, intrinsics, camera_pose, image.snapshot.time, known, moving)


def _unlocated(context: RunContext, place: str) -> Obstacle | None:
    """Returns the space on a place in which things may be that were put there and not been seen yet; None for none."""
    world, height = context.world, 0.0
    for thing in world.subjects(v.IN, place):
        solid = solid_of(world, thing) if map_pose(context, thing) is None else None
        if solid is not None:
            low, high = solid.bounds()
            height = max(height, float((high - low).max()))
    region = support_region(context, place) if height else ""
    if isinstance(region, str):
        return None
    (x, y), lift = region.half_extents, Pose((0.0, 0.0, height / 2.0))
    return Obstacle(place, Solid.box(2.0 * x, 2.0 * y, height), region.pose @ lift)


def _robot(context: RunContext, robot: RobotSpec, tree: FrameTree) -> Iterator[Obstacle]:
    """Yields a robot as blocks: its base, its links and what its grippers hold."""
    base, height = robot.pose(tree.snapshot, context.board.guard), _HEIGHT
    kinematics = context.frames.kinematics(robot)
    if kinematics is not None:
        links = {BASE_LINK: Pose(), **kinematics.poses(tree.joints(robot))}
        places = dict(zip(links, base.apply(np.array([pose.position for pose in links.values()])), strict=True))
        height, hands = _LINK, {kinematics.parents.get(arm.tip) for arm in robot.of(ArmSpec)}
        for link, parent in kinematics.parents.items():
            if parent == BASE_LINK:
                height = max(height, links[link].position[2] + _LINK)
            else:
                yield _rod(robot.id, places[parent], places[link], _FINGER if parent in hands else _LINK)
    xs, ys = zip(*robot.outline, strict=True)
    middle = Pose(((min(xs) + max(xs)) / 2.0, (min(ys) + max(ys)) / 2.0, height / 2.0))
    block = Primitive("box", (max(xs) - min(xs), max(ys) - min(ys), height))
    yield Obstacle(robot.id, Solid((block,)), base @ middle)
    for gripper in robot.of(GripperSpec):
        holding = held_by(context, gripper.id)
        if holding is not None:
            part, held = holding
            yield Obstacle(part, held.solid, tree.located(gripper.arm) @ held.pose)


def _rod(name: str, start: Array, end: Array, radius: float) -> Obstacle:
    """Returns a rod around the line between the places of two links in the map [m], which may be one place."""
    way = end - start
    length = float(np.linalg.norm(way))
    x, y, z = (start + way / 2.0).tolist()
    tilt = math.acos(max(-1.0, min(1.0, float(way[2]) / length))) if length > 0.0 else 0.0
    block = Primitive("cylinder", (radius, length + 2.0 * radius))
    return Obstacle(name, Solid((block,)), Pose.of(x, y, z, pitch=tilt, yaw=math.atan2(way[1], way[0])))
