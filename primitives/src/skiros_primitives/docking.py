"""Where a base docks: at the driving pose of a location, or beside it where its arm reaches more of what is wanted."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from itertools import product
from typing import Any

from skiros_primitives.arm_moves import LIFTS, above_routes
from skiros_primitives.part_models import downward, level
from skiros_primitives.surfaces import inner_region, support_region
from skiros_py.devices.arm import ArmSpec
from skiros_py.devices.gripper import GripperSpec
from skiros_py.geometry import Pose
from skiros_py.ports.cell import RobotSpec
from skiros_py.ports.motion import ArmPlanner, Held, MotionPlan, MotionRequest
from skiros_py.skills.context import RunContext
from skiros_py.skills.primitive import Execution, Primitive
from skiros_py.skills.surroundings import held_by, map_pose, obstacles, owner
from skiros_py.world import vocabulary as v

_BESIDE = tuple(
    Pose((x, y, 0.0)) for x, y in ((0.06, 0.0), (0.06, 0.12), (0.06, -0.12), (0.0, 0.12), (0.0, -0.12), (-0.06, 0.0))
)
"""Where it may dock instead, seen from the driving pose [m]."""
_DROP, _GRASP = 0.004, 0.03
"""How far above a surface a part is released, and how far parts are grasped whose place is not known [m]."""
_QUARTERS = tuple(quarter * math.pi / 2.0 for quarter in range(4))


def docking_pose(
    primitive: Primitive[Any], robot: RobotSpec, location: str, taught: Pose, is_free: Callable[[Pose], Execution[bool]]
) -> Execution[Pose]:
    """Returns where to dock at a location, in the map.

    That is the driving pose, unless the arm does not reach from there what is farthest away of what is wanted; then the
    place from which it reaches most.

    Args:
        primitive: What runs.
        robot: The robot.
        location: The location.
        taught: Its driving pose in the map.
        is_free: Tells whether the base can drive to a pose.
    """
    context = primitive.context
    grippers = (one for one in robot.of(GripperSpec) if context.ports.find(ArmPlanner, one.arm) is not None)
    gripper = next(grippers, None)
    if gripper is None:
        return taught
    arm = next(arm for arm in robot.of(ArmSpec) if arm.id == gripper.arm)
    holding = held_by(context, gripper.id)
    held, touching = holding[1] if holding else None, _touching(context, location)
    wanted = sorted(_wanted(context, location, held), key=lambda tools: -tools[0].distance(taught))

    def reaches(base: Pose, tools: Sequence[Pose]) -> Execution[bool]:
        """Tells whether the arm comes to one of several poses of the tool from straight above."""
        for tool, lift in product(tools, LIFTS):
            request = MotionRequest(
                device=arm.id,
                start=arm.home,
                base=base,
                routes=tuple(above_routes([tool], touching, lift)),
                obstacles=obstacles(context, parts=False),
                held=held,
                seed=primitive.seed(),
            )
            if isinstance((yield from primitive.wait(context.port(ArmPlanner, arm.id).plan(request))), MotionPlan):
                return True
        return False

    def reached(base: Pose, some: Sequence[Sequence[Pose]]) -> Execution[int]:
        """Returns how many of some places the arm reaches."""
        count = 0
        for tools in some:
            count += yield from reaches(base, tools)
        return count

    if (yield from reached(taught, wanted[:1])) == len(wanted[:1]):
        return taught
    best, most = taught, (yield from reached(taught, wanted[1:]))
    for beside in _BESIDE:
        pose = taught @ beside
        if most < len(wanted) and (yield from is_free(pose)):
            count = yield from reached(pose, wanted)
            best, most = (pose, count) if count > most else (best, most)
    return best


def _touching(context: RunContext, location: str) -> set[str]:
    kit = _kit(context, location)
    return {location, kit, *context.world.objects(kit, v.HAS_A)}


def _kit(context: RunContext, location: str) -> str:
    """Returns the location itself, or what it is a docking place of."""
    return owner(context.world, location, v.CONTAINER) or location


def _wanted(context: RunContext, location: str, held: Held | None) -> Iterator[list[Pose]]:
    """Yields for each place at which something is taken or put down at a location the poses of the tool there."""
    world = context.world
    if held is not None:
        compartments = (one for one in world.objects(_kit(context, location), v.HAS_A) if not world.subjects(v.IN, one))
        regions = (inner_region(context, one) for one in compartments)
        sits = held.pose.inverse()
        for floor in (region.pose for region in regions if not isinstance(region, str)):
            yield [level(floor @ Pose.of(0.0, 0.0, _DROP, yaw=yaw)) @ sits for yaw in _QUARTERS]
    elif parts := [
        one for one in world.subjects(v.IN, location) if world.ontology.is_a(world.element(one).type, v.MANIPULATABLE)
    ]:
        known = [pose for part in parts if (pose := map_pose(context, part)) is not None]
        region = support_region(context, location)
        for x, y, z in [pose.position for pose in known or ([] if isinstance(region, str) else [region.pose])]:
            yield [downward(x, y, z + _GRASP, yaw) for yaw in _QUARTERS]
