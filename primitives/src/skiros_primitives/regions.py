"""The flat part of a place on which things lie."""

from __future__ import annotations

from skiros_py.geometry import Pose, Solid
from skiros_py.ports.perception import Region
from skiros_py.skills.context import RunContext
from skiros_py.skills.surroundings import map_pose
from skiros_py.world.vocabulary import SOLID, SUPPORT_HALF_EXTENTS, SUPPORT_OFFSET


def support_region(context: RunContext, place: str) -> Region | str:
    """Returns the support area of a storage place in the map, or why there is none."""
    pose = map_pose(context, place)
    half, offset = context.world.value(place, SUPPORT_HALF_EXTENTS), context.world.value(place, SUPPORT_OFFSET)
    if pose is None or not isinstance(half, tuple) or not isinstance(offset, tuple):
        return f"{place} has no pose or no support area: nothing can be looked for there"
    return Region(pose @ Pose((offset[0], offset[1], offset[2])), (half[0], half[1]))


def inner_region(context: RunContext, compartment: str) -> Region | str:
    """Returns the floor of a compartment in the map, or why it is unknown."""
    pose = map_pose(context, compartment)
    solid = context.world.value(compartment, SOLID)
    if pose is None or solid is None:
        return f"{compartment} has no pose or no inner volume"
    low, high = Solid.from_json(str(solid)).bounds()
    return Region(pose, (float(high[0] - low[0]) / 2.0, float(high[1] - low[1]) / 2.0))
