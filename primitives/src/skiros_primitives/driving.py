"""Drives a mobile base to where a place can be worked at, around all obstacles."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, ClassVar

from skiros_primitives import floor_obstacles
from skiros_primitives.floor_obstacles import driving, reach
from skiros_py.geometry import Pose, wrap_angle
from skiros_py.ports.board import Mobile
from skiros_py.ports.device import MobileSpec
from skiros_py.ports.motion import BasePathRequest, BasePlanner, NoMotion, Obstacle
from skiros_py.ports.paths import Outline, Path
from skiros_py.skills.context import Way
from skiros_py.skills.outcome import Failure, Outcome, Success
from skiros_py.skills.parameters import Kind, param
from skiros_py.skills.primitive import Execution, Primitive
from skiros_py.skills.surroundings import map_pose, obstacles
from skiros_py.world import vocabulary as v

_PATIENCE = 60.0
"""Longest time without progress on the path [s]."""


class DrivingPrimitive(Primitive[Any]):
    """Base of the primitives that drive; their parameters have fields ``base`` and ``robot``."""

    @property
    def pose(self) -> Pose:
        """Pose of the robot in the map, as localised."""
        return self.context.cell.group_of(self.params.base).pose(self.context.board.snapshot, self.context.board.guard)

    def rides(self, element: str) -> bool:
        """Returns True when an element moves with the base."""
        frames = self.world.objects(element, v.POSE_FRAME)
        return any(frame == self.params.base or self.rides(frame) for frame in frames)

    def leave(self, reason: str) -> None:
        """Places the robot on the floor: it is at no location while it drives."""
        floors = self.world.instances(v.FLOOR)
        placement = self.world.placement(self.params.robot)
        if floors and (placement is None or placement.place != floors[0]):
            with self.world.transaction(author=self.name, reason=reason) as tx:
                tx.place(self.params.robot, v.AT, floors[0])

    def drive(
        self, base: Mobile, path: Path, way: Way, *, max_linear: float = math.inf, max_angular: float = math.inf
    ) -> Execution[float | None]:
        """Follows a path, and waits until the base stands.

        Args:
            base: The base.
            path: The path.
            way: The floor that was granted for it.
            max_linear: Greatest speed [m/s], besides the limit of the base.
            max_angular: Greatest turning speed [rad/s], besides the limit of the base.

        Returns:
            None, or how many legs were driven where the base got stuck.
        """
        follower = base.follow(path, lambda: self.pose, max_linear=max_linear, max_angular=max_angular)
        driven, deadline = -1.0, 0.0
        while True:
            try:
                reached, target = next(follower)
            except StopIteration as end:
                if not end.value:
                    return driven
                break
            if reached > driven:
                leg, legs = int(reached) + 1, len(path.legs)
                if (leg > int(driven) + 1 or driven < 0.0) and leg <= legs:
                    self.progress(leg, f"leg {leg} of {legs}")
                driven, deadline = reached, self.context.now + _PATIENCE
            elif self.context.now >= deadline:
                return driven
            way.passed(reached)
            base.command(target)
            yield
        yield from self.stand(base)
        return None

    def stand(self, base: Mobile) -> Execution[None]:
        """Brakes, and waits for localisation to settle."""
        deadline = self.context.now + 5.0
        yield
        while not base.still and self.context.now < deadline:
            yield
        settled = self.context.now + 0.1
        while self.context.now < settled:
            yield


_ARRIVED = 0.03
"""Greatest distance from the driving pose after standstill [m]."""
_FACING = math.radians(2.0)
_ASIDE = 0.06
"""Greatest distance of a base from its path [m]; paths keep a larger distance from obstacles."""
_COURTESY = 120.0
"""Longest wait for other robots [s]."""
_LOOK_AGAIN = 5.0
"""Longest time between two plans while another robot blocks the way [s]."""
_APART = 0.02
"""Distance between two robots that both deviate from their paths by the maximum [m]."""


class DriveBase(DrivingPrimitive):
    """Drives a base of any kind along a planned path; follows localisation, ends at standstill."""

    name: ClassVar[str] = "drive_base"

    @dataclass(frozen=True, slots=True)
    class Params:
        """Parameters."""

        base: str = param(v.BASE, "The base that drives.", kind=Kind.HARDWARE)
        robot: str = param(v.ROBOT, "The robot it carries along.", kind=Kind.PLANNING)
        location: str = param(v.LOCATION, "Where to go; it has a driving pose.")

    _waits_for = ""

    def execute(self) -> Execution[Outcome]:
        """Plans, waits until the way is free, drives, and writes where the robot is once it has stopped."""
        goal = self._goal()
        if isinstance(goal, Failure):
            return goal
        base = Mobile(self.context.board, self.params.base)
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

    def _follow(self, base: Mobile, path: Path, way: Way, goal: Pose) -> Execution[Outcome]:
        if path.legs:
            self.leave("drives off")
        stuck = yield from self.drive(base, path, way)
        if stuck is None:
            return self._arrived(self.pose, goal)
        leg, legs = int(stuck) + 1, len(path.legs)
        place = f"on leg {leg} of {legs} to" if leg <= legs else "while turning at"
        return Failure(f"stuck {place} {self.params.location}")

    def _goal(self) -> Pose | Failure:
        location = self.params.location
        place, driving = map_pose(self.context, location), self.world.value(location, v.DRIVING_POSE)
        if place is None or not isinstance(driving, Pose):
            return Failure(f"{location} has no driving pose: teach one")
        return place @ driving

    def _plan(self, goal: Pose, outline: Outline) -> Execution[Path | NoMotion | None]:
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

    def _path(self, goal: Pose, robots: tuple[Obstacle, ...]) -> Execution[Path | NoMotion]:
        planner = self.context.port(BasePlanner, self.params.base)
        carried = frozenset(o.id for o in obstacles(self.context, parts=False) if self.rides(o.id))
        around = obstacles(self.context, parts=False, without=carried)
        request = BasePathRequest(self.pose, goal, self._spec().footprint, (*around, *robots), device=self.params.base)
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
        before = driving(self.context, self.params.robot)
        while self.context.now < end and driving(self.context, self.params.robot) == before:
            yield

    def _spec(self) -> MobileSpec[Any, Any]:
        return Mobile(self.context.board, self.params.base).spec

    def _arrived(self, pose: Pose, goal: Pose) -> Outcome:
        distance = math.dist(pose.position[:2], goal.position[:2])
        turned = abs(wrap_angle(pose.yaw - goal.yaw))
        location = self.params.location
        if distance > _ARRIVED or turned > _FACING:
            return Failure(f"stopped {distance:.3f} m and {math.degrees(turned):.1f} deg off {location}")
        placement = self.world.placement(self.params.robot)
        if placement is None or placement.place != location:
            with self.world.transaction(author=self.name, reason=f"localised {distance * 1e3:.0f} mm off") as tx:
                tx.place(self.params.robot, v.AT, location)
        return Success(f"at {location}")
