"""Drives a mobile base to where a place can be worked at, around all obstacles."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, ClassVar

from skiros_primitives import floor_obstacles
from skiros_primitives.floor_obstacles import reach
from skiros_py.devices.base import Base, BaseSpec, BaseTwist
from skiros_py.geometry import Pose, wrap_angle
from skiros_py.ports.motion import BaseLeg, BasePath, BasePathRequest, BasePlanner, NoMotion, Obstacle
from skiros_py.skills.context import Outline, Way
from skiros_py.skills.outcome import Failure, Outcome, Success
from skiros_py.skills.parameters import Kind, param
from skiros_py.skills.primitive import Execution, Primitive
from skiros_py.skills.surroundings import map_pose, obstacles
from skiros_py.world.vocabulary import AT, BASE, DRIVING_POSE, FLOOR, LOCATION, POSE_FRAME, ROBOT

_ALIGNED = math.radians(0.3)


class DrivingPrimitive(Primitive[Any]):
    """Base of the primitives that drive; their parameters have fields ``base`` and ``robot``."""

    @property
    def pose(self) -> Pose:
        """Pose of the robot in the map, as localised."""
        return self.context.cell.group_of(self.params.base).pose(self.context.board.snapshot)

    def rides(self, element: str) -> bool:
        """Returns True when an element moves with the base."""
        frames = self.world.objects(element, POSE_FRAME)
        return any(frame == self.params.base or self.rides(frame) for frame in frames)

    def leave(self, reason: str) -> None:
        """Places the robot on the floor: it is at no location while it drives."""
        floors = self.world.instances(FLOOR)
        placement = self.world.placement(self.params.robot)
        if floors and (placement is None or placement.place != floors[0]):
            with self.world.transaction(author=self.name, reason=reason) as tx:
                tx.place(self.params.robot, AT, floors[0])

    def turn(self, base: Base, heading: float, *, fastest: float, patience: float) -> Execution[bool]:
        """Turns on the spot.

        Args:
            base: The base.
            heading: Heading in the map at the end [rad].
            fastest: Greatest turning speed [rad/s].
            patience: Longest time [s].

        Returns:
            Whether it reached the heading.
        """
        limit, deadline = base.spec.max_angular_acceleration, self.context.now + patience
        while self.context.now < deadline:
            error = wrap_angle(heading - self.pose.yaw)
            if abs(error) < _ALIGNED:
                return True
            speed = min(fastest, math.sqrt(1.6 * limit * abs(error)), 4.0 * abs(error))
            base.command(BaseTwist(0.0, math.copysign(speed, error)))
            yield
        return False

    def stand(self, base: Base) -> Execution[None]:
        """Brakes, and waits for localisation to settle."""
        deadline = self.context.now + 5.0
        yield
        while not base.state.still and self.context.now < deadline:
            yield
        settled = self.context.now + 0.1
        while self.context.now < settled:
            yield


_ARRIVED = 0.03
"""Greatest distance from the driving pose after standstill [m]."""
_FACING = math.radians(2.0)
_ASIDE = 0.06
"""Greatest distance from the line of a leg [m]; paths keep a larger distance from obstacles."""
_PATIENCE = 60.0
"""Longest time for one leg [s]."""
_COURTESY = 120.0
"""Longest wait for other robots [s]."""
_LOOK_AGAIN = 5.0
"""Longest time between two plans while another robot blocks the way [s]."""
_APART = 0.02
"""Distance between two robots that both deviate from their paths by the maximum [m]."""


class DriveBase(DrivingPrimitive):
    """Turns, drives straight, turns, as a differential drive can; follows localisation, ends at standstill."""

    name: ClassVar[str] = "drive_base"

    @dataclass(frozen=True, slots=True)
    class Params:
        """Parameters."""

        base: str = param(BASE, "The base that drives.", kind=Kind.HARDWARE)
        robot: str = param(ROBOT, "The robot it carries along.", kind=Kind.PLANNING)
        location: str = param(LOCATION, "Where to go; it has a driving pose.")

    _waits_for = ""

    def execute(self) -> Execution[Outcome]:
        """Plans, waits until the way is free, drives, and writes where the robot is once it has stopped."""
        goal = self._goal()
        if isinstance(goal, Failure):
            return goal
        base = Base(self.context.board, self.params.base)
        outline = self._outline()
        deadline = self.context.now + _COURTESY
        while True:
            path = yield from self._plan(goal, outline)
            if isinstance(path, NoMotion):
                return Failure(f"no way to {self.params.location}: {path.reason}")
            if path is not None:
                with self.context.floor.ask(self.params.robot, outline, self.pose, path) as way:
                    if (yield from self._is_free(way, deadline)):
                        return (yield from self._follow(base, path, way, goal))
            if self.context.now >= deadline:
                return Failure(f"no way to {self.params.location}: waited {_COURTESY:g} s for {self._waits_for}")
            yield from self._pause(deadline)

    def _follow(self, base: Base, path: BasePath, way: Way, goal: Pose) -> Execution[Outcome]:
        if path.legs:
            self.leave("drives off")
        for number, leg in enumerate(path.legs):
            self.progress(number + 1, f"leg {number + 1} of {len(path.legs)}")
            if not (yield from self._drive(base, leg, way, number)):
                return Failure(f"stuck on leg {number + 1} of {len(path.legs)} to {self.params.location}")
        if not (yield from self._turn(base, path.heading)):
            return Failure(f"stuck while turning at {self.params.location}")
        yield from self.stand(base)
        return self._arrived(self.pose, goal)

    def _goal(self) -> Pose | Failure:
        location = self.params.location
        place, driving = map_pose(self.context, location), self.world.value(location, DRIVING_POSE)
        if place is None or not isinstance(driving, Pose):
            return Failure(f"{location} has no driving pose: nobody taught how to stand there")
        return place @ driving

    def _plan(self, goal: Pose, outline: Outline) -> Execution[BasePath | NoMotion | None]:
        """Plans around everything at rest; None if only another standing robot blocks the way."""
        margin = max(_ASIDE, reach(outline) - reach(self._spec().footprint)) + _APART
        standing = floor_obstacles.standing(self.context, self.params.robot, margin=margin)
        path = yield from self._path(goal, standing)
        if not isinstance(path, NoMotion) or not standing:
            return path
        alone = yield from self._path(goal, ())
        if isinstance(alone, NoMotion):
            return alone
        self._tell(o.id for o in standing)
        return None

    def _path(self, goal: Pose, robots: tuple[Obstacle, ...]) -> Execution[BasePath | NoMotion]:
        planner = self.context.port(BasePlanner, self.params.base)
        carried = frozenset(o.id for o in obstacles(self.context, parts=False) if self.rides(o.id))
        around = obstacles(self.context, parts=False, without=carried)
        request = BasePathRequest(self.pose, goal, self._spec().footprint, (*around, *robots), base=self.params.base)
        return (yield from self.wait(planner.plan(request)))

    def _outline(self) -> Outline:
        """The robot's outline while it drives; not needed if it is alone in its cell."""
        if len(self.context.cell.robots) == 1:
            return self._spec().footprint
        robot = self.context.cell.group_of(self.params.base)
        return floor_obstacles.outline(self.context, robot)

    def _is_free(self, way: Way, deadline: float) -> Execution[bool]:
        """Waits for robots in the way, up to a deadline; not for one that stands still."""
        while not way.free:
            self._tell(way.waits_for())
            if way.blocked or self.context.now >= deadline:
                return False
            yield
        return True

    def _tell(self, robots: Iterable[str]) -> None:
        waits_for = " and ".join(dict.fromkeys(robots))
        if waits_for != self._waits_for:
            self._waits_for = waits_for
            self.progress(1, f"waits for {waits_for} to clear the way")

    def _pause(self, deadline: float) -> Execution[None]:
        """Waits until another robot drives off or has arrived; some robots only moved an arm."""
        end = min(deadline, self.context.now + _LOOK_AGAIN)
        before = self._driving()
        while self.context.now < end and self._driving() == before:
            yield

    def _driving(self) -> list[str]:
        others = floor_obstacles.others(self.context, self.params.robot)
        return [other.id for other in others if self.context.floor.is_driving(other.id)]

    def _spec(self) -> BaseSpec:
        return self.context.cell.device(self.params.base, BaseSpec)

    def _drive(self, base: Base, leg: BaseLeg, way: Way, driven: int) -> Execution[bool]:
        pose = self.pose
        heading = math.atan2(leg.y - pose.position[1], leg.x - pose.position[0])
        if not (yield from self._turn(base, heading + (math.pi if leg.backwards else 0.0))):
            return False
        return (yield from self._straight(base, leg, way, driven))

    def _turn(self, base: Base, heading: float) -> Execution[bool]:
        return (yield from self.turn(base, heading, fastest=self._spec().max_angular, patience=_PATIENCE))

    def _straight(self, base: Base, leg: BaseLeg, way: Way, driven: int) -> Execution[bool]:
        """Follows the line from here to the leg's end, steering by heading and distance from the line."""
        spec, deadline = self._spec(), self.context.now + _PATIENCE
        x0, y0, _ = self.pose.position
        length = math.hypot(leg.x - x0, leg.y - y0)
        if length < 0.002:
            return True
        ux, uy, sign = (leg.x - x0) / length, (leg.y - y0) / length, -1.0 if leg.backwards else 1.0
        along = math.atan2(sign * uy, sign * ux)
        while self.context.now < deadline:
            x, y, _ = self.pose.position
            left = length - ((x - x0) * ux + (y - y0) * uy)
            way.passed(driven + 1.0 - left / length)
            if left < 0.002:
                return True
            aside = -(x - x0) * uy + (y - y0) * ux
            if abs(aside) > _ASIDE:
                return False
            turned = wrap_angle(along - self.pose.yaw)
            speed = min(spec.max_linear, math.sqrt(2.0 * 0.8 * spec.max_linear_acceleration * left), 4.0 * left)
            speed *= max(0.0, math.cos(turned))
            steer = 2.5 * turned - sign * 4.0 * aside * speed
            base.command(BaseTwist(sign * speed, max(-spec.max_angular, min(spec.max_angular, steer))))
            yield
        return False

    def _arrived(self, pose: Pose, goal: Pose) -> Outcome:
        distance = math.dist(pose.position[:2], goal.position[:2])
        turned = abs(wrap_angle(pose.yaw - goal.yaw))
        location = self.params.location
        if distance > _ARRIVED or turned > _FACING:
            return Failure(f"stopped {distance:.3f} m and {math.degrees(turned):.1f} deg off {location}")
        placement = self.world.placement(self.params.robot)
        if placement is None or placement.place != location:
            with self.world.transaction(author=self.name, reason=f"localised {distance * 1e3:.0f} mm off") as tx:
                tx.place(self.params.robot, AT, location)
        return Success(f"at {location}")
