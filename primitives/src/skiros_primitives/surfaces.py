"""Surfaces on which a part may lie, also where it was not put, and which of the things seen there is it."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from skiros_py.geometry import Pose, Solid
from skiros_py.messages import Message
from skiros_py.ports.perception import Detection, DetectionResult, Region
from skiros_py.skills.context import RunContext
from skiros_py.skills.surroundings import map_pose, solid_of
from skiros_py.world import vocabulary as v
from skiros_py.world.view import WorldView

_WIDEST = 0.6
"""Half the side length of the area of a larger surface, such as the floor, that is searched around a kit [m]."""
_SAME = 0.05
"""What is seen within this distance of a part that is known is that part [m]."""
_ASLANT = 0.10
"""How far from where a part was let go a thing may lie that is not recognised, and is still taken for it [m]."""


def support_region(context: RunContext, place: str) -> Region | str:
    """Returns the support area of a storage place in the map, or why there is none."""
    pose = map_pose(context, place)
    half, offset = context.world.value(place, v.SUPPORT_HALF_EXTENTS), context.world.value(place, v.SUPPORT_OFFSET)
    if pose is None or not isinstance(half, tuple) or not isinstance(offset, tuple):
        return Message("{place} has no pose or no support area: nothing can be looked for there", place=place)
    return Region(pose @ Pose((offset[0], offset[1], offset[2])), (half[0], half[1]))


def inner_region(context: RunContext, compartment: str) -> Region | str:
    """Returns the floor of a compartment in the map, or why it is unknown."""
    pose = map_pose(context, compartment)
    solid = context.world.value(compartment, v.SOLID)
    if pose is None or solid is None:
        return Message("{compartment} has no pose or no inner volume", compartment=compartment)
    low, high = Solid.from_json(str(solid)).bounds()
    return Region(pose, (float(high[0] - low[0]) / 2.0, float(high[1] - low[1]) / 2.0), exact=True)


def kit_of(view: WorldView, compartment: str) -> str | None:
    """Returns what a compartment is a piece of."""
    return next(iter(view.subjects(v.HAS_A, compartment)), None)


@dataclass(frozen=True, slots=True)
class Surface:
    """A place on which a part may lie.

    Attributes:
        relation: How it would be related to the place.
        place: The place.
        region: Its surface.
    """

    relation: str
    place: str
    region: Region


def surfaces(context: RunContext, kit: str, without: str) -> Iterator[Surface]:
    """Yields where a part may lie that was let go over a kit: from its other compartments down to the floor.

    Args:
        context: The run.
        kit: The kit.
        without: The compartment in which it does not lie.
    """
    world = context.world
    for compartment in world.objects(kit, v.HAS_A):
        inner = inner_region(context, compartment)
        if compartment != without and isinstance(inner, Region) and not world.subjects(v.IN, compartment):
            yield Surface(v.IN, compartment, inner)
    middle, below = map_pose(context, kit) or Pose(), kit
    while True:
        pose, solid, size = map_pose(context, below), solid_of(world, below), world.value(below, v.SIZE)
        extents = solid.bounds() if solid is not None else np.array([np.zeros(3), np.resize(np.asarray(size), 3)])
        if pose is not None and (solid is not None or isinstance(size, tuple)):
            half_x, half_y, _ = (float(length) / 2.0 for length in extents[1] - extents[0])
            top = pose @ Pose((0.0, 0.0, float(extents[1][2]) if solid is not None else 0.0))
            if max(half_x, half_y) > _WIDEST:
                top, half_x, half_y = Pose((*middle.position[:2], top.position[2])), _WIDEST, _WIDEST
            yield Surface(v.ON, below, Region(top, (half_x, half_y), exact=True))
        placement = world.placement(below)
        if placement is None or placement.relation != v.ON:
            return
        below = placement.place


def lost_part(context: RunContext, part: str, look: DetectionResult, let_go: Pose | None) -> Pose | None:
    """Returns where a look shows a part that is searched, in the map; None if it does not.

    Args:
        context: The run.
        part: The part.
        look: What is seen on one surface; things near to other known parts are those.
        let_go: Where it was let go, if what is seen there and not recognised may be it: it need not stand upright.
    """
    world = context.world
    others = [pose for one in world.instances(v.MANIPULATABLE) if one != part and (pose := map_pose(context, one))]
    new = [seen for seen in look.detections if all(_beside(seen.pose, pose) > _SAME for pose in others)]
    known = next((seen.pose for seen in new if seen.type == world.element(part).type), None)
    if known is not None or let_go is None:
        return known
    strange = [seen for seen in new if seen.type is None and _beside(seen.pose, let_go) <= _ASLANT]
    nearest = min(strange, key=lambda seen: _beside(seen.pose, let_go), default=None)
    return None if nearest is None else _taken_for(context, part, nearest)


def _taken_for(context: RunContext, part: str, seen: Detection) -> Pose | None:
    """Returns the pose of a part that would be as long and as high as what is seen."""
    solid = solid_of(context.world, part)
    if solid is None:
        return None
    length, width, height = solid.bounds()[1] - solid.bounds()[0]
    x, y, z = seen.pose.position
    yaw = seen.pose.yaw + (math.pi / 2.0 if width > length else 0.0)
    return Pose.of(x, y, z + seen.size[2] - float(height), yaw=yaw)


def _beside(one: Pose, other: Pose) -> float:
    return math.dist(one.position[:2], other.position[:2])
