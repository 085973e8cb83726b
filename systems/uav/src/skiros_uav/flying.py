"""Primitives that fly an aerial base: take off, fly to where a place can be worked at, land."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import chain
from typing import ClassVar

import shapely

from skiros_primitives import floor_obstacles
from skiros_primitives.driving import DrivingPrimitive
from skiros_primitives.postures import unstowed
from skiros_primitives.surfaces import support_region
from skiros_py.geometry import Pose, wrap_angle
from skiros_py.messages import Message, listed
from skiros_py.ports.board import Mobile
from skiros_py.ports.cell import RobotSpec
from skiros_py.ports.motion import BasePathRequest, BasePlanner, NoMotion, Obstacle
from skiros_py.ports.paths import Layer, Outline, Path, PosePath, floor_area, reach, swept
from skiros_py.skills.outcome import OBSTRUCTED, Failure, Outcome, Success
from skiros_py.skills.parameters import Kind, param
from skiros_py.skills.primitive import Execution
from skiros_py.skills.surroundings import map_pose, obstacles
from skiros_py.world import vocabulary as v
from skiros_uav import names
from skiros_uav.aerial_base import AerialBaseSpec, AerialState, AerialTwist

_CRUISE = 1.0
"""Height of the skids above the ground on the way [m]."""
_APART = 0.25
"""Distance kept from things above and below on the way [m]."""
_CLEARANCE = 0.15
"""Distance kept from things beside it on the way [m]."""
_STRAIGHT = 0.05
"""Greatest distance of straight stretches from the way that was planned [m]."""
_SAME = 1e-6
_SIDES = 16
_COURTESY = 120.0
"""Longest wait for other robots [s]."""
_DESCENT = 0.25
"""Speed at which it lands [m/s]."""
_THERE, _FACING = 0.03, math.radians(1.0)
"""Greatest distance from where it should hover [m], and of its heading."""
_PATIENCE = 30.0
"""Longest time for a descent [s]."""


class FlyingPrimitive(DrivingPrimitive):
    """Base of the primitives that fly; their parameters have fields ``base`` and ``robot``."""

    @property
    def spec(self) -> AerialBaseSpec:
        """The description of the base."""
        return self.context.cell.device(self.params.base, AerialBaseSpec)

    @property
    def state(self) -> AerialState:
        """What the autopilot says in this cycle."""
        return self.context.board.snapshot.state(self.params.base, AerialState)

    @property
    def base(self) -> Mobile:
        """The base."""
        return Mobile(self.context.board, self.params.base)

    @property
    def group(self) -> RobotSpec:
        """The robot."""
        return self.context.cell.group_of(self.params.base)

    def write_landed(self, *, landed: bool, reason: str) -> None:
        """Writes whether the robot stands on the ground."""
        if self.world.value(self.params.robot, names.LANDED) is not landed:
            with self.world.transaction(author=self.name, reason=reason) as tx:
                tx.set(self.params.robot, names.LANDED, landed)

    def fly(self, path: Path) -> Execution[Failure | None]:
        """Waits until the air is free, and flies."""
        outline = floor_obstacles.outline(floor_obstacles.shape(self.context, self.group))
        deadline = self.context.now + _COURTESY
        with self.context.floor.ask(self.params.robot, outline, self.pose, path) as way:
            while not way.free:
                if self.context.now >= deadline:
                    reason = Message(
                        "waited {seconds:g} s for {robots}", seconds=_COURTESY, robots=listed([*way.waits_for()])
                    )
                    return Failure(reason, code=OBSTRUCTED)
                yield
            stuck = yield from self.drive(self.base, path, way)
        return None if stuck is None else Failure(Message("{base} got too far from its path", base=self.params.base))

    def around(self) -> tuple[Obstacle, ...]:
        """Returns what it must not touch: things, and other robots."""
        there = obstacles(self.context, parts=False)
        carried = frozenset(one.id for one in there if floor_obstacles.rides(self.context, one.id, self.group))
        unknown = chain.from_iterable(self.context.pictures.unknown.values())
        standing = floor_obstacles.standing(self.context, self.params.robot, margin=_CLEARANCE)
        return (*obstacles(self.context, parts=False, without=carried), *unknown, *standing)

    def layers(self, low: float, high: float) -> tuple[Layer, ...]:
        """Returns what the robot covers, however it is turned; its skids are between two heights [m]."""
        hanging = floor_obstacles.shape(self.context, self.group)[1:]
        own = (Layer(tuple(self.spec.footprint), 0.0, self.spec.height), *hanging)
        return tuple(Layer(_around(one.outline), one.bottom + low - _APART, one.top + high + _APART) for one in own)

    def plan_flight(self, goal: Pose) -> Execution[PosePath | Failure]:
        """Plans up to the cruising height, along at that height, and down to a pose."""
        start = self.pose
        cruise = max(_CRUISE, goal.position[2], start.position[2])
        planner = self.context.port(BasePlanner, self.params.base)
        request = BasePathRequest(
            start, goal, self.layers(cruise, cruise), self.around(), _CLEARANCE, self.params.base, glides=True
        )
        path = yield from self.wait(planner.plan(request))
        if isinstance(path, NoMotion):
            return Failure(Message("no way through the air: {reason}", reason=path.reason), values=path.values)
        along = [pose for _, pose in path.poses(start)]
        level = [Pose((*pose.position[:2], cruise), goal.orientation) for pose in along]
        return PosePath((*_corners(level), goal))


def _around(outline: Outline) -> tuple[tuple[float, float], ...]:
    """Returns the circle that an outline turns in."""
    angles = (math.tau * number / _SIDES for number in range(_SIDES))
    radius = reach(outline) / math.cos(math.pi / _SIDES)
    return tuple((radius * math.cos(angle), radius * math.sin(angle)) for angle in angles)


def _corners(poses: list[Pose]) -> list[Pose]:
    """Returns as few of the poses of a way as stay near to all of it, its ends included."""
    line = shapely.LineString([pose.position[:2] for pose in poses]) if len(poses) > 1 else None
    if line is None or line.length < _THERE:
        return poses[:1]
    kept = shapely.get_coordinates(line.simplify(_STRAIGHT)).tolist()
    corners, left = [], iter(poses)
    for x, y in kept[:-1]:
        corners.append(next(pose for pose in left if math.dist(pose.position[:2], (x, y)) < _SAME))
    return [*corners, poses[-1]]


class TakeOff(FlyingPrimitive):
    """Climbs straight up to an altitude; one that flies already only climbs or descends."""

    name: ClassVar[str] = "take_off"
    takes: ClassVar[tuple[str, ...]] = ("robot",)

    @dataclass(frozen=True, slots=True)
    class Params:
        """Parameters."""

        base: str = param(names.AERIAL_BASE, "The base that flies.", kind=Kind.HARDWARE)
        robot: str = param(v.ROBOT, "The robot it carries.", kind=Kind.PLANNING)
        altitude: float = param("number", "Height of the skids above the ground.", default=1.0, unit="m")

    def execute(self) -> Execution[Outcome]:
        """Climbs, and writes that it flies when it has left the ground."""
        here = self.pose
        stuck = yield from self.fly(PosePath((Pose((*here.position[:2], self.params.altitude), here.orientation),)))
        if stuck is not None:
            return stuck
        if self.state.failsafe:
            return Failure(Message("{base} does not take off: its battery is nearly empty", base=self.params.base))
        if self.state.landed or self.pose.position[2] < 0.5 * self.params.altitude:
            return Failure(Message("{base} does not lift off: is it overloaded?", base=self.params.base))
        self.write_landed(landed=False, reason=Message("{height:.2f} m above the ground", height=self.pose.position[2]))
        return Success(Message("flies at {height:.2f} m", height=self.pose.position[2]))


@dataclass(frozen=True, slots=True)
class _ToPlace:
    """Parameters of what flies to a place."""

    base: str = param(names.AERIAL_BASE, "The base that flies.", kind=Kind.HARDWARE)
    robot: str = param(v.ROBOT, "The robot it carries.", kind=Kind.PLANNING)
    location: str = param(v.LOCATION, "Where to go; it has a driving pose.")


class FlyToPlace(FlyingPrimitive):
    """Flies to where its arm works best at a place, at a height at which it touches nothing; arms are stowed before."""

    name: ClassVar[str] = "fly_to_place"
    takes: ClassVar[tuple[str, ...]] = ("robot",)

    Params = _ToPlace

    def execute(self) -> Execution[Outcome]:
        """Plans, flies, and writes where the robot is once it hovers."""
        location = self.params.location
        goal = hover_pose(self, location)
        if isinstance(goal, Failure):
            return goal
        if self.state.landed:
            if math.dist(self.pose.position[:2], goal.position[:2]) < _LANDED_THERE:
                return Success(Message("has landed at {location}", location=location))
            climbed = yield from self.call("take_off", base=self.params.base, robot=self.params.robot)
            if isinstance(climbed, Failure):
                return climbed
        if unstowed(self.context, self.group, None):
            stowed = yield from self.call("stow_arms", robot=self.params.robot)
            if isinstance(stowed, Failure):
                return stowed
        path = yield from self.plan_flight(goal)
        if isinstance(path, Failure):
            return path
        self.leave(Message("flies off"))
        stuck = yield from self.fly(path)
        if stuck is not None:
            return stuck
        away, turned = self.pose.distance(goal), abs(wrap_angle(self.pose.yaw - goal.yaw))
        if away > _THERE or turned > _FACING:
            said = {"distance": away, "turned": math.degrees(turned), "location": location}
            return Failure(Message("stopped {distance:.3f} m and {turned:.1f} deg off {location}", **said))
        with self.world.transaction(author=self.name, reason=Message("hovers {mm:.0f} mm off", mm=1e3 * away)) as tx:
            tx.place(self.params.robot, v.AT, location)
        return Success(Message("at {location}", location=location))


_LANDED_THERE = 0.2
"""How far from a landing place it may stand [m]."""


def hover_pose(primitive: FlyingPrimitive, location: str) -> Pose | Failure:
    """Returns the pose from which the arm works best at a place; above a landing place that at cruising height."""
    context, spec = primitive.context, primitive.spec
    place, driving = map_pose(context, location), context.world.value(location, v.DRIVING_POSE)
    if place is None or not isinstance(driving, Pose):
        return Failure(Message("{location} has no driving pose: teach one", location=location))
    docked = place @ driving
    if context.world.ontology.is_a(context.world.element(location).type, v.STATION):
        return Pose((*docked.position[:2], docked.position[2] + _CRUISE), docked.orientation)
    region = support_region(context, location)
    centre = place if isinstance(region, str) else region.pose  # kits are worked at from above their floor
    x, y, below = spec.work_offset
    level = Pose.of(*centre.position, yaw=docked.yaw)
    return level @ Pose((-x, -y, below))


class LandAt(FlyingPrimitive):
    """Lands straight below, at a landing place or where it is."""

    name: ClassVar[str] = "land_at"
    takes: ClassVar[tuple[str, ...]] = ("robot",)

    Params = _ToPlace

    def execute(self) -> Execution[Outcome]:
        """Descends until its skids stand on the ground."""
        deadline = self.context.now + _PATIENCE
        below = self.layers(0.0, 0.0)
        here = self.pose.position
        in_the_way = [
            one.id
            for one in self.around()
            for layer in below
            if floor_area(one.solid, one.pose, layer.bottom + _APART, here[2]).intersects(
                swept(layer.outline, (self.pose, self.pose))[0]
            )
        ]
        if in_the_way:
            return Failure(Message("it cannot land there: {things} stands below", things=listed(in_the_way)))
        while not self.state.landed and self.context.now < deadline:
            self.base.command(AerialTwist(climb=-min(_DESCENT, 0.1 + 0.5 * max(0.0, self.pose.position[2]))))
            yield
        if not self.state.landed:
            return Failure(Message("{base} does not come down", base=self.params.base))
        self.write_landed(landed=True, reason=Message("stands on its skids"))
        placement = self.world.placement(self.params.robot)
        if placement is None or placement.place != self.params.location:
            with self.world.transaction(author=self.name, reason=Message("stands on its skids")) as tx:
                tx.place(self.params.robot, v.AT, self.params.location)
        return Success(Message("has landed at {location}", location=self.params.location))
