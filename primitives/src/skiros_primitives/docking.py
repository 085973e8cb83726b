"""Where a base docks: at the driving pose of a location, or where its arm reaches more of what is wanted there.

The other poses are in front of each side of what stands there on the floor, as near as the base can dock. What is
wanted is what the next steps are about, where that is known, or else all at the location that they can be about.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise, product
from typing import Any

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from skiros_primitives.arm_moves import LIFTS, above_routes
from skiros_primitives.floor_obstacles import rides
from skiros_primitives.looking import possible_looks
from skiros_primitives.part_models import downward, leaning, level
from skiros_primitives.put_down import fitting_quarters
from skiros_primitives.sighting import on_floor
from skiros_primitives.surfaces import inner_region, support_region
from skiros_py.devices.arm import ArmSpec
from skiros_py.devices.gripper import GripperSpec
from skiros_py.geometry import Array, Pose, wrap_angle
from skiros_py.messages import Message, listed
from skiros_py.ports.cell import RobotSpec
from skiros_py.ports.kinematics import BASE_LINK, Kinematics
from skiros_py.ports.motion import (
    SHARES,
    ArmPlanner,
    Held,
    MotionPlan,
    MotionRequest,
    ReachChecker,
    Reached,
    ReachRequest,
    Vector,
)
from skiros_py.ports.paths import Outline, floor_area, placed
from skiros_py.ports.values import Pending
from skiros_py.skills.context import RunContext
from skiros_py.skills.outcome import Failure, tick
from skiros_py.skills.primitive import Execution, Primitive
from skiros_py.skills.surroundings import held_by, map_pose, obstacles, owner, solid_of
from skiros_py.world import vocabulary as v

_DROP, _GRASP = 0.004, 0.03
"""How far above a surface a part is released, and how far parts are grasped whose place is not known [m]."""
_QUARTERS = tuple(quarter * math.pi / 2.0 for quarter in range(4))
_GAP = 0.03
"""Smallest distance between a base that has docked and what it docks at [m]: it keeps 2 cm on its way."""
_ROUNDING = 1e-3
"""What is nearer by less than this counts as that far [m]."""
_BESIDE = (0.0, 0.12, -0.12)
"""How far beside what is wanted an arm may be [m]."""
_TURNED = (math.radians(30.0), math.radians(-30.0))
"""How a base may be turned besides as taught [rad]."""
_SHIFTED = 0.25
"""How far beside it a base docks that has a docking place of its own, for itself among others [m, rad]."""
_TURN = 0.4
"""How much a turn counts as way between two docks [m/rad]."""
_COMFORT = 0.5
"""How much way it is worth to stay away from joint limits by half of a joint's range [m]."""
_AT_ONCE, _ENOUGH = 6, 3
"""So many poses are looked at together; among so many from which all is reached the best one is chosen."""
_PLANNED = 4
"""For so many of them motions are planned, until there are some."""
_CORNER = 0.8
"""Where a part may lie on a surface, as a share of the way from its middle to its corners."""


@dataclass(frozen=True, slots=True)
class Wanted:
    """Something that an arm is to reach.

    Attributes:
        id: Id of what it is; empty for one of several places where it may be.
        tools: Alternative poses of the tip in the map, to which it comes from straight above.
        others: Those with a hand that leans, where it does not reach these.
    """

    id: str
    tools: tuple[Pose, ...]
    others: tuple[Pose, ...] = ()


@dataclass(frozen=True, slots=True)
class Task:
    """What an arm is to do at a location.

    Attributes:
        wanted: What it is to reach, what is farthest away first.
        looks: Alternative poses of the tip in the map for each look from above.
        touching: Ids of what may be touched.
        held: What the gripper holds, or None.
    """

    wanted: tuple[Wanted, ...]
    looks: tuple[tuple[Pose, ...], ...]
    touching: frozenset[str]
    held: Held | None

    def targets(self) -> tuple[tuple[tuple[Pose, ...], ...], ...]:
        """Returns what is wanted, and then the looks, as a :class:`ReachRequest` has it."""
        high = Pose((0.0, 0.0, LIFTS[-1]))
        tools = tuple(tuple((tool, high @ tool) for tool in (*one.tools, *one.others)) for one in self.wanted)
        return (*tools, *(tuple((pose,) for pose in poses) for poses in self.looks))


def docking_pose(
    primitive: Primitive[Any], robot: RobotSpec, location: str, taught: Pose, is_free: Callable[[Pose], Execution[bool]]
) -> Execution[Pose | Failure]:
    """Returns where to dock at a location, in the map; a failure where all that the next steps need is out of reach.

    That is the driving pose, unless the arm does not reach from there what is farthest away of what is wanted; then the
    pose from which it reaches most, with the least way and joints away from their limits.

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
    task = task_at(context, arm, gripper, location, taught)
    docks = Docks(primitive, robot, arm, location, task)
    if not task.wanted or (yield from docks.suits(taught)):
        return taught
    return (yield from docks.best(taught, is_free))


class Docks:
    """The poses from which one arm works at one location.

    Args:
        primitive: What runs.
        robot: The robot.
        arm: Its arm.
        location: The location.
        task: What the arm is to do there.
    """

    def __init__(self, primitive: Primitive[Any], robot: RobotSpec, arm: ArmSpec, location: str, task: Task) -> None:
        self._primitive, self._context = primitive, primitive.context
        self._robot, self._arm, self._location, self._task = robot, arm, location, task
        self._known: dict[tuple[Pose, Wanted], bool] = {}

    def planned(self, base: Pose, wanted: Sequence[Wanted], least: int = 0) -> Execution[int]:
        """Returns how many of some things the arm comes to from straight above, by whole motions.

        Args:
            base: Where its base stands, in the map.
            wanted: The things.
            least: It ends early where it cannot be as many any more.
        """
        count = 0
        for number, one in enumerate(wanted):
            if count + len(wanted) - number < least:
                break
            if (base, one) not in self._known:
                self._known[base, one] = yield from self._comes_to(base, one)
            count += self._known[base, one]
        return count

    def _comes_to(self, base: Pose, one: Wanted) -> Execution[bool]:
        """Returns whether there is a motion: one that keeps away from things also comes as near to them as possible."""
        planner = self._context.port(ArmPlanner, self._arm.id)
        for tools, lift in product(filter(None, (one.tools, one.others)), reversed(LIFTS)):
            request = MotionRequest(
                device=self._arm.id,
                start=self._arm.home,
                base=base,
                routes=tuple(above_routes(tools, self._task.touching, lift)),
                obstacles=obstacles(self._context, parts=False),
                held=self._task.held,
                seed=self._primitive.seed(),
                shares=SHARES[-1:],
            )
            if isinstance((yield from self._primitive.wait(planner.plan(request))), MotionPlan):
                return True
        return False

    def reaches(self, taught: Pose) -> Execution[bool]:
        """Returns whether all that is wanted is within reach from the driving pose or another one."""
        if None not in (yield from self._primitive.wait(self._reached((taught,))))[0]:
            return True
        others = sorted(self._others(taught), key=lambda pose: pose.distance(taught))
        found = yield from self._primitive.wait(self._reached(others))
        return any(None not in there for there in found)

    def suits(self, base: Pose) -> Execution[bool]:
        """Returns whether the arm comes from a pose to what is farthest away, and all else is within its reach."""
        planning = self.planned(base, self._task.wanted[:1])
        checking = self._primitive.wait(self._reached((base,)))
        planned, reached = tick(planning), tick(checking)
        while planned is None or reached is None:
            yield
            planned = tick(planning) if planned is None else planned
            reached = reached or tick(checking)
        return planned > 0 and None not in reached[0]

    def best(self, taught: Pose, is_free: Callable[[Pose], Execution[bool]]) -> Execution[Pose | Failure]:
        """Returns the best pose besides the driving pose, or that one where none is better."""
        bases = [taught, *sorted(self._others(taught), key=lambda pose: pose.distance(taught))]
        reached: list[Reached] = []
        while len(reached) < len(bases) and all(None in there for there in reached):  # the nearest first
            some = bases[len(reached) : len(reached) + _AT_ONCE]
            reached += yield from self._primitive.wait(self._reached(some))
        if missing := self._out_of_reach(reached):
            return self._refusal(missing)
        everything, best, left = len(self._task.targets()), taught, _PLANNED
        most = (yield from self.planned(taught, self._within_reach(reached[0]))) + self._looks(reached, 0)
        for number in self._ranked(bases, reached, taught):
            if most == everything or left == 0:
                break
            if self._count(reached[number]) > most and (yield from is_free(bases[number])):
                left -= 1
                wanted = self._within_reach(reached[number])
                looks = self._looks(reached, number)
                count = (yield from self.planned(bases[number], wanted, most + 1 - looks)) + looks
                best, most = (bases[number], count) if count > most else (best, most)
        return best

    def _reached(self, bases: Sequence[Pose]) -> Pending[tuple[Reached, ...]]:
        """Asks what is reached from some poses, as far as postures tell."""
        request = ReachRequest(
            device=self._arm.id,
            bases=tuple(bases),
            targets=self._task.targets(),
            near=self._arm.home,
            obstacles=obstacles(self._context, parts=False),
            held=self._task.held,
            touching=self._task.touching,
            enough=_ENOUGH,
            seed=self._primitive.seed(),
        )
        return self._context.port(ReachChecker, self._arm.id).reach(request)

    def _within_reach(self, there: Reached) -> list[Wanted]:
        """Returns what is wanted that postures reach: for the rest, no motion has to be searched."""
        return [one for one, left in zip(self._task.wanted, there, strict=False) if left is not None]

    def _looks(self, reached: Sequence[Reached], number: int) -> int:
        return self._count(reached[number][len(self._task.wanted) :])

    @staticmethod
    def _count(reached: Reached) -> int:
        return sum(one is not None for one in reached)

    def _ranked(self, bases: Sequence[Pose], reached: Sequence[Reached], taught: Pose) -> list[int]:
        """Returns the numbers of the poses besides the driving pose, those first from which more is reached."""

        def rank(number: int) -> tuple[int, float]:
            there, turn = reached[number], abs(wrap_angle(bases[number].yaw - taught.yaw))
            comfort = min((one for one in there if one is not None), default=0.0)
            way = math.dist(bases[number].position, taught.position) + _TURN * turn
            return -sum(one is not None for one in there), way - _COMFORT * min(0.5, comfort)

        return sorted(range(1, len(reached)), key=rank)

    def _out_of_reach(self, reached: Sequence[Reached]) -> list[str]:
        """Returns the ids of what the next steps need, where all of that is out of reach from everywhere."""
        named = [(number, one.id) for number, one in enumerate(self._task.wanted)]
        if not all(id_ in self._context.ahead for _, id_ in named):
            return []
        missing = [id_ for number, id_ in named if all(there[number] is None for there in reached)]
        return missing if len(missing) == len(named) else []

    def _refusal(self, missing: Sequence[str]) -> Failure:
        reason = Message(
            "{things} is out of reach of {robot} from every side of {location}",
            things=listed(missing),
            robot=self._robot.id,
            location=self._location,
        )
        return Failure(reason, values={"cause": "reach", "out_of_reach": list(missing)})

    def _others(self, taught: Pose) -> list[Pose]:
        thing = on_floor(self._context, self._location)
        if thing is None:
            return []
        wanted = np.array([tool.position[:2] for one in self._task.wanted for tool in one.tools[:1]])
        mount = _mount(self._context, self._arm)
        poses = docks_around(floor_area(thing.solid, thing.pose), self._robot.outline, mount, taught, wanted)
        around = shapely.union_all([floor_area(one.solid, one.pose) for one in obstacles(self._context, parts=False)])
        free = (p for p in poses if not shapely.dwithin(placed(self._robot.outline, p), around, _GAP - _ROUNDING))
        if _kit(self._context, self._location) != self._location:  # other robots have docking places of their own
            return [
                pose
                for pose in free
                if pose.distance(taught) < _SHIFTED and abs(wrap_angle(pose.yaw - taught.yaw)) < _SHIFTED
            ]
        return list(free)


def docks_around(place: BaseGeometry, outline: Outline, mount: Pose, taught: Pose, wanted: Array) -> list[Pose]:
    """Returns poses in front of each side of a place from which an arm may reach what is wanted.

    The base stands to each side as it does to that where it was taught to dock, or turned a little, as near as it may.

    Args:
        place: The area of what it docks at [m, map].
        outline: Outline of the base.
        mount: Where the arm is on the base.
        taught: Where the base was taught to dock.
        wanted: Where what it wants is [m, map], shape (n, 2).
    """
    corners = shapely.get_coordinates(shapely.minimum_rotated_rectangle(place))[:-1]
    middle, aim = corners.mean(axis=0), wanted.mean(axis=0)
    sides = [((one + other) / 2.0, _away(one, other, middle)) for one, other in pairwise((*corners, corners[0]))]
    _, nearest = max(sides, key=lambda side: float((taught.position[:2] - side[0]) @ side[1]))
    offset, found = taught.yaw - _facing(nearest), []
    for (edge, out), (turned, beside) in product(
        sides, (*((0.0, one) for one in _BESIDE), *((one, 0.0) for one in _TURNED))
    ):
        turn = Pose.of(0.0, 0.0, 0.0, yaw=_facing(out) + offset + turned)
        covered, at = (
            turn.apply(np.array([(x, y, 0.0) for x, y in points]))[:, :2] for points in (outline, [mount.position[:2]])
        )
        along = np.array((-out[1], out[0]))
        ahead = edge @ out + _GAP - float((covered @ out).min())
        x, y = (ahead * out + ((aim - at[0]) @ along + beside) * along).tolist()
        found.append(Pose((x, y, taught.position[2])) @ turn)
    return found


def _away(one: Array, other: Array, middle: Array) -> Array:
    """Returns the unit vector across an edge, away from the middle."""
    across = np.array((other[1] - one[1], one[0] - other[0])) / np.linalg.norm(other - one)
    return np.asarray(math.copysign(1.0, float((one - middle) @ across)) * across)


def _facing(out: Array) -> float:
    """Returns the heading of what faces a side [rad]."""
    return math.atan2(-out[1], -out[0])


def _mount(context: RunContext, arm: ArmSpec) -> Pose:
    """Returns where an arm stands on its base."""
    kinematics = context.port(Kinematics, arm.id)
    link = arm.tip
    while (parent := kinematics.parents.get(link, BASE_LINK)) != BASE_LINK:
        link = parent
    return kinematics.pose(link, {})


def can_put_down(
    primitive: Primitive[Any], robot: RobotSpec, arm: ArmSpec, part: str, grasps: Sequence[Pose]
) -> Execution[bool]:
    """Returns whether an arm can put a part down where the next steps want it; True where they are not known.

    Args:
        primitive: What runs.
        robot: The robot.
        arm: Its arm.
        part: The part.
        grasps: Poses of the tip in the frame of the part, in one of which it is grasped.
    """
    context, solid = primitive.context, solid_of(primitive.context.world, part)
    if context.ports.find(ReachChecker, arm.id) is None:
        return True
    for location in filter(context.world.has, sorted(context.ahead)):
        place, driving = map_pose(context, location), context.world.value(location, v.DRIVING_POSE)
        carried = rides(context, _kit(context, location), robot)
        if solid is None or place is None or not isinstance(driving, Pose) or carried:
            continue
        held = [Held(solid, grasp.inverse()) for grasp in grasps]
        wanted = [one for one in _releases(context, location, held) if one.id in context.ahead]
        task = Task(tuple(wanted), (), _touching(context, location), held[0])
        if wanted and not (yield from Docks(primitive, robot, arm, location, task).reaches(place @ driving)):
            return False
    return True


def task_at(context: RunContext, arm: ArmSpec, gripper: GripperSpec, location: str, taught: Pose) -> Task:
    """Returns what an arm is to do at a location."""
    holding = held_by(context, gripper.id)
    held = holding[1] if holding else None
    found = [*_wanted(context, location, held)]
    named = [one for one in found if one.id in context.ahead]
    wanted = sorted(named or found, key=lambda one: -one.tools[0].distance(taught))
    looks = tuple(possible_looks(context, arm, taught, point) for point in _looked_at(context, location, held, wanted))
    return Task(tuple(wanted), tuple(filter(None, looks)), _touching(context, location), held)


def _touching(context: RunContext, location: str) -> frozenset[str]:
    kit = _kit(context, location)
    return frozenset({location, kit, *context.world.objects(kit, v.HAS_A)})


def _kit(context: RunContext, location: str) -> str:
    """Returns the location itself, or what it is a docking place of."""
    return owner(context.world, location, v.CONTAINER) or location


def _wanted(context: RunContext, location: str, held: Held | None) -> Iterator[Wanted]:
    """Yields each place at which something may be taken or put down at a location."""
    world = context.world
    if held is not None:
        yield from _releases(context, location, [held])
        return
    is_a = world.ontology.is_a
    parts = [one for one in world.subjects(v.IN, location) if is_a(world.element(one).type, v.MANIPULATABLE)]
    known = {part: pose for part in parts if (pose := map_pose(context, part)) is not None}
    for part, pose in known.items():
        yield _grasps(part, pose)
    region = support_region(context, location)
    if len(known) < len(parts) and not isinstance(region, str):
        x, y = (_CORNER * half for half in region.half_extents)
        for corner in ((0.0, 0.0), (x, y), (x, -y), (-x, y), (-x, -y)):
            yield _grasps("", region.pose @ Pose((*corner, 0.0)))


def _releases(context: RunContext, location: str, held: Sequence[Held]) -> Iterator[Wanted]:
    """Yields each empty compartment at a location, for a part that is held in one of some ways."""
    low, high = held[0].solid.bounds()
    half = ((high - low)[:2] / 2.0).tolist()
    for compartment in context.world.objects(_kit(context, location), v.HAS_A):
        region = inner_region(context, compartment)
        if not isinstance(region, str) and not context.world.subjects(v.IN, compartment):
            yaws = [quarter * math.pi / 2.0 for quarter in fitting_quarters(half, region.half_extents)]
            turned = [level(region.pose @ Pose.of(0.0, 0.0, _DROP, yaw=yaw)) for yaw in yaws]
            tools = tuple(pose @ one.pose.inverse() for pose, one in product(turned, held))
            yield Wanted(compartment, tools)


def _grasps(part: str, pose: Pose) -> Wanted:
    """Returns how a part may be grasped, or something at a place where parts may be."""
    x, y, z = pose.position
    tools = tuple(downward(x, y, z + _GRASP, yaw) for yaw in _QUARTERS)
    return Wanted(part, tools, leaning(tools))


def _looked_at(context: RunContext, location: str, held: Held | None, wanted: Sequence[Wanted]) -> list[Vector]:
    """Returns the points that are looked at from above: what something is put into, or what is taken."""
    if held is not None:
        place = map_pose(context, _kit(context, location))
        return [] if place is None else [place.position]
    region = support_region(context, location)
    seen = (map_pose(context, one.id) for one in wanted if one.id)
    return [*([] if isinstance(region, str) else [region.pose.position]), *(pose.position for pose in seen if pose)]
