"""Drives a mobile base to where a place can be worked at, around all obstacles; what fails is tried otherwise."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import chain
from typing import Any, ClassVar

import shapely
from shapely.geometry.base import BaseGeometry

from skiros_primitives import floor_obstacles
from skiros_primitives.arm_moves import carrying_postures
from skiros_primitives.contact import believe_obstacle
from skiros_primitives.docking import docking_pose
from skiros_primitives.driving import DrivingPrimitive
from skiros_primitives.floor_obstacles import driving
from skiros_primitives.lookout import Lookout
from skiros_primitives.postures import unstowed
from skiros_primitives.sighting import PlaceInSight
from skiros_primitives.travelling import TravellingArms
from skiros_py.devices.arm import ArmSpec
from skiros_py.geometry import Pose, wrap_angle
from skiros_py.messages import Message, listed
from skiros_py.ports.board import Mobile
from skiros_py.ports.cell import RobotSpec
from skiros_py.ports.device import MobileSpec
from skiros_py.ports.motion import BasePathRequest, BasePlanner, NoMotion, Obstacle
from skiros_py.ports.paths import Layer, Outline, Path, reach
from skiros_py.skills.context import Way
from skiros_py.skills.outcome import OBSTRUCTED, Failure, Outcome, Success
from skiros_py.skills.parameters import Kind, param
from skiros_py.skills.primitive import Execution
from skiros_py.skills.surroundings import map_pose, obstacles
from skiros_py.world import vocabulary as v
from skiros_py.world.poses import move

_ARRIVED = 0.005
"""Greatest distance from the driving pose after standstill, as localised [m]."""
_FACING = math.radians(0.5)
_CLOSE = 0.003
"""The same where the place is seen, until it has tried once more [m]: what is seen may be some millimetres off, too."""
_EXACT = 0.001
"""What differs by less is the same [m, rad]."""
_ASIDE = 0.06
"""Greatest distance of a base from its path [m]; paths keep a larger distance from obstacles."""
_COURTESY = 120.0
"""Longest wait for other robots [s]."""
_LOOK_AGAIN = 5.0
"""Longest time between two plans while another robot blocks the way [s]."""
_IDLE = 8.0
"""How long a robot that nothing runs on is waited for [s]."""
_OBSTRUCTED = {
    "busy": partial(Message, "waited {seconds:g} s for {robots}", seconds=_COURTESY),
    "no room": partial(Message, "there is no room to give way, neither for it nor for {robots}"),
    "idle": partial(Message, "{robots} stands there, and nothing moves it"),
}
"""Why there is no way, by what the other robots do."""
_FRESH = 0.3
"""How old a path may be that was planned while the motion of an arm was planned [s]."""
_BLOCK = (0.3, 0.6, 0.6)
"""Length, width and height of the block that is assumed where the base has met something [m]."""
_SURPRISES = 5
"""How often it looks for another way because something unknown is in the way."""
_RETREAT = 0.12
"""How far it drives back from there [m]."""
_SLOWLY = 0.1
"""How fast it does that [m/s]."""
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

    takes: ClassVar[tuple[str, ...]] = ("robot",)

    _shape: tuple[Layer, ...] = ()
    _guess: tuple[Path, Pose, tuple[Layer, ...], float] | None = None
    """A path that was planned before its shape was known, with goal, shape, and when [s]."""
    _waits_for = ""
    _met: Sequence[str] = ()
    """Ids of obstacles that the base has met."""
    _in_use = 0.0
    """When something last ran on every robot that blocks the path [s]."""
    _surprises = 0
    """How often something unknown was in the way."""
    _is_off = False
    """Whether it sees that it stands too far from its goal, for the first time."""
    _again = False
    """Whether another attempt makes sense."""

    def execute(self) -> Execution[Outcome]:
        """Plans, waits until the way is free, drives, and writes where the robot is once it has stopped.

        Its arms are stowed while it leaves, and reach out while it arrives.
        """
        base = Mobile(self.context.board, self.params.base)
        self._in_use = self.context.now
        deadline, docked = self.context.now + _COURTESY, False
        while True:
            goal = self._goal()
            if isinstance(goal, Failure):
                return goal
            arms = TravellingArms(self.context, self._robot, self.params.location, goal)
            plans = [self._stow(arms), self._guess_path(goal), *([] if docked else [self._dock_in_reach(goal)])]
            outcomes, docked = (yield from self.join(*plans)), True
            if (stuck := next((one for one in outcomes if isinstance(one, Failure)), None)) is not None:
                return stuck
            if self._goal() != goal:  # it docks elsewhere, where an arm may have to be stowed otherwise
                continue
            self._shape = floor_obstacles.shape(self.context, self._robot, arms.postures)
            self._again = False
            _, outcome = yield from self.join(arms.move(), self._attempt(base, goal, deadline, arms))
            if not self._again:
                return outcome

    def _stow(self, arms: TravellingArms) -> Execution[Outcome]:
        """Plans how an arm is stowed while the base leaves; several, or one without a planner, are stowed before."""
        robot, location = self.params.robot, self.params.location
        extended = unstowed(self.context, self._robot, location)
        if len(extended) == 1 and arms.plans(extended[0]):
            return (yield from arms.plan_stowing(extended[0]))
        return (yield from self.call("stow_arms", robot=robot, location=location)) if extended else Success()

    def _attempt(self, base: Mobile, goal: Pose, deadline: float, arms: TravellingArms) -> Execution[Outcome]:
        """Plans one path and drives it as soon as it is free; says in ``_again`` whether to try another one."""
        try:
            outline = floor_obstacles.outline(self._shape)
            path = self._guessed(goal) or (yield from self._plan(goal, self._shape))
            if isinstance(path, NoMotion):
                return replace(self._no_way(path.reason), values=path.values)
            with self.context.floor.ask(self.params.robot, outline, self.pose, path) as way:
                found = yield from self._wait_until_free(way, outline, deadline)
                if way.free:
                    outcome = yield from self._follow(base, path, way, goal, arms)
                    if self.bumped or self.seen or self.displaced or self._is_off:
                        self._surprises += 1
                        self._again = self._surprises <= _SURPRISES
                    return outcome
            if found is not None and not isinstance(found, Failure):
                yield from arms.settled()
                found = yield from self._give_way(base, found, outline, deadline)
            self._again = not isinstance(found, Failure)
            return found if isinstance(found, Failure) else Success()
        finally:
            arms.ended = True

    def _follow(self, base: Mobile, path: Path, way: Way, goal: Pose, arms: TravellingArms) -> Execution[Outcome]:
        yield from arms.find_clear(path)
        if path.legs:
            self.leave(Message("drives off"))
        yield  # the way was asked for in this cycle, which takes some milliseconds, too
        known = obstacles(self.context, parts=True)
        lookout = arms.lookout = Lookout(self.context, self._robot, self._shape, self.pose, path, known, self._met)
        place = PlaceInSight.of(self.context, self._robot, base, self.params.location, goal)
        stuck = yield from self.drive(base, path, way, lookout=lookout, place=place, arms=arms)
        if stuck is not None and arms.touched and not self.bumped:
            yield from arms.settled()
            return arms.met or Failure(Message("an arm met something at {location}", location=self.params.location))
        if self.bumped:
            yield from self._back_off(base)
        elif place is not None and place.is_contradicted:
            return self._not_there(place.body)
        elif place is not None and (stuck is None or self.displaced):
            self._correct(place)
        if stuck is None:
            return self._arrived(sees=place is not None and place.pose is not None)
        leg, legs = int(stuck) + 1, len(path.legs)
        location = self.params.location
        if leg <= legs:
            return Failure(Message("stuck on leg {leg} of {legs} to {location}", leg=leg, legs=legs, location=location))
        return Failure(Message("stuck while turning at {location}", location=location))

    def _correct(self, place: PlaceInSight) -> None:
        """Writes where the place is seen to be, with what is on it."""
        pose, before = place.pose, map_pose(self.context, place.body)
        if pose is None or before is None:
            return
        off, turned = math.dist(pose.position, before.position), abs(wrap_angle(pose.yaw - before.yaw))
        if max(off, turned) < _EXACT:
            return
        reason = Message(
            "{body} is seen {distance:.0f} mm and {turned:.1f} deg from where it was believed to be",
            body=place.body,
            distance=1000.0 * off,
            turned=math.degrees(turned),
        )
        with self.world.transaction(author=self.name, reason=reason) as tx:
            move(tx, place.body, pose)
        if self.displaced:
            self.progress(1, reason)
            self.emit("displaced", {"element": place.body, "distance": off, "turned": turned})

    def _not_there(self, body: str) -> Failure:
        reason = Message("{body} is not where it is believed to be, and scans do not show where it is", body=body)
        return Failure(reason, values={"not_seen": body})

    def _back_off(self, base: Mobile) -> Execution[None]:
        """Writes that something is where the base met it, and drives back a little."""
        ahead, aside = self.bumped or (1.0, 0.0)
        edge = max(ahead * x + aside * y for x, y in self._spec().footprint) + _BLOCK[0] / 2.0
        x, y, _ = (self.pose @ Pose((ahead * edge, aside * edge, 0.0))).position
        yaw = self.pose.yaw + (math.atan2(aside, ahead) if self._spec().drives_sideways else 0.0)
        reason = Message("{base} met something", base=self.params.base)
        met = believe_obstacle(self.world, self.name, Pose.of(x, y, 0.0, yaw=yaw), _BLOCK, reason)
        self._met = (*self._met, met)
        self.emit("contact", {"device": self.params.base})
        retreat = base.direct_path(self.pose, self.pose @ Pose((-ahead * _RETREAT, -aside * _RETREAT, 0.0)))
        follower, deadline = base.follow(retreat, lambda: self.pose, max_linear=_SLOWLY), self.context.now + 5.0
        for _, target in follower:
            if self.context.now > deadline:
                break
            base.command(target)
            yield
        yield from self.stand(base)

    def _goal(self) -> Pose | Failure:
        location = self.params.location
        place, driving = map_pose(self.context, location), self.world.value(location, v.DRIVING_POSE)
        if place is None or not isinstance(driving, Pose):
            return Failure(Message("{location} has no driving pose: teach one", location=location))
        return place @ driving

    def _dock_in_reach(self, goal: Pose) -> Execution[Outcome]:
        """Makes the pose from where the arm reaches what is wanted there the driving pose, if that is another one."""
        location = self.params.location

        def is_free(pose: Pose) -> Execution[bool]:
            postures = {arm.id: self._posture_at(arm, pose) for arm in self._robot.of(ArmSpec)}
            shape = floor_obstacles.shape(self.context, self._robot, postures)
            return not isinstance((yield from self._plan(pose, shape)), NoMotion)

        pose = yield from docking_pose(self, self._robot, location, goal, is_free)
        if isinstance(pose, Failure):
            return pose
        place = map_pose(self.context, location)
        if pose != goal and place is not None:
            off = pose.distance(goal) * 1e3
            reason = Message("the arm reaches more from {off:.0f} mm beside", off=off)
            with self.world.transaction(author=self.name, reason=reason) as tx:
                tx.set(location, v.DRIVING_POSE, place.inverse() @ pose)
        return Success()

    def _posture_at(self, arm: ArmSpec, pose: Pose) -> tuple[float, ...]:
        """Returns the first posture for travelling in which an arm touches nothing with its base at a pose."""
        postures = carrying_postures(arm)
        free = (
            one for one in postures if not floor_obstacles.reaches_over(self.context, self._robot, arm.id, one, pose)
        )
        return next(free, postures[0])

    def _guess_path(self, goal: Pose) -> Execution[Outcome]:
        """Plans a path for the first postures for travelling, meanwhile: mostly the arms get into these."""
        stowed = {
            arm.id: carrying_postures(arm)[0] for arm in unstowed(self.context, self._robot, self.params.location)
        }
        shape, made = floor_obstacles.shape(self.context, self._robot, stowed), self.context.now
        path = yield from self._plan(goal, shape)
        self._guess = None if isinstance(path, NoMotion) else (path, goal, shape, made)
        return Success()

    def _guessed(self, goal: Pose) -> Path | None:
        """Returns that path, if it is for how the arms will be, and not older than some plans of arms take."""
        (guess, self._guess), now = (self._guess, None), self.context.now
        fits = guess is not None and guess[1:3] == (goal, self._shape) and now - guess[3] < _FRESH
        return guess[0] if guess is not None and fits else None

    def _plan(self, goal: Pose, shape: Sequence[Layer]) -> Execution[Path | NoMotion]:
        """Plans around everything at rest, or else as if no robot stood there."""
        standing = self._standing()
        path = yield from self._path(goal, standing, shape)
        if isinstance(path, NoMotion) and standing:
            path = yield from self._path(goal, (), shape)
        return path

    def _standing(self) -> tuple[Obstacle, ...]:
        return floor_obstacles.standing(self.context, self.params.robot, margin=_ASIDE + _APART)

    def _path(self, goal: Pose, robots: tuple[Obstacle, ...], shape: Sequence[Layer]) -> Execution[Path | NoMotion]:
        planner = self.context.port(BasePlanner, self.params.base)
        around = (*self._things(), *chain.from_iterable(self.context.pictures.unknown.values()), *robots)
        glides = self._spec().drives_sideways
        request = BasePathRequest(self.pose, goal, tuple(shape), around, device=self.params.base, glides=glides)
        return (yield from self.wait(planner.plan(request)))

    @property
    def _robot(self) -> RobotSpec:
        return self.context.cell.group_of(self.params.base)

    def _things(self) -> tuple[Obstacle, ...]:
        there = obstacles(self.context, parts=False)
        carried = frozenset(one.id for one in there if floor_obstacles.rides(self.context, one.id, self._robot))
        return obstacles(self.context, parts=False, without=carried)

    def _wait_until_free(self, way: Way, outline: Outline, deadline: float) -> Execution[Path | Failure | None]:
        """Waits until a way is free, as long as that is of use.

        Args:
            way: The way that was asked for.
            outline: The outline of the robot while it drives.
            deadline: When waiting ends [s].

        Returns:
            The path to a place where it blocks no other robot, if it is the one to give way; why waiting is no use; or
            None if the way is free, or another one may be.
        """
        again, before = self.context.now + _LOOK_AGAIN, self._driving()
        while not way.free:
            self._tell(way.waits_for())
            now = self.context.now
            if now >= deadline:
                return self._obstructed(way.waits_for(), "busy")
            if deadlocked := way.deadlock():
                return self._obstructed(deadlocked, "no room")
            idle = way.idle()
            if not idle:
                self._in_use = now
            if now >= self._in_use + _IDLE:
                return self._obstructed(idle, "idle")
            area = way.to_leave()
            if area is not None:
                aside = yield from self._aside(area, outline)
                if aside is not None:
                    return aside
                way.refuse()
            elif way.blocked and (now >= again or self._driving() != before):
                return None
            yield
        return None

    def _driving(self) -> list[str]:
        return driving(self.context, self.params.robot)

    def _obstructed(self, robots: Iterable[str], cause: str) -> Failure:
        """Returns a failure because of other robots, with who they are and what they do as data."""
        others = list(dict.fromkeys(robots))
        why = self._no_way(_OBSTRUCTED[cause](robots=listed(others)))
        return replace(why, code=OBSTRUCTED, values={"blocked_by": others, "cause": cause})

    def _no_way(self, why: str) -> Failure:
        return Failure(Message("no way to {location}: {reason}", location=self.params.location, reason=why))

    def _aside(self, area: BaseGeometry, outline: Outline) -> Execution[Path | None]:
        """Finds a path to where the robot does not stand on an area; None if there is none."""
        robots = self._standing()
        around = (*self._things(), *robots)
        area = shapely.buffer(area, reach(outline))
        for pose in floor_obstacles.asides(self.context, outline, self.pose, around, area):
            path = yield from self._path(pose, robots, self._shape)
            if not isinstance(path, NoMotion):
                return path
        return None

    def _give_way(self, base: Mobile, path: Path, outline: Outline, deadline: float) -> Execution[Failure | None]:
        """Drives to a place where the robot blocks no other one; returns why it does not get there."""
        self.progress(1, Message("makes room for {robots}", robots=self._waits_for))
        with self.context.floor.ask(self.params.robot, outline, self.pose, path) as way:
            found = yield from self._wait_until_free(way, outline, deadline)
            if not way.free:
                return found if isinstance(found, Failure) else None
            self.leave(Message("makes room for another robot"))
            stuck = yield from self.drive(base, path, way)
        return (
            None if stuck is None else Failure(Message("stuck while it made room for {robots}", robots=self._waits_for))
        )

    def _tell(self, robots: Iterable[str]) -> None:
        waits_for = listed(dict.fromkeys(robots))
        if waits_for != self._waits_for:
            self._waits_for = waits_for
            self.progress(1, Message("waits for {robots} to clear the way", robots=waits_for))

    def _spec(self) -> MobileSpec[Any, Any]:
        return Mobile(self.context.board, self.params.base).spec

    def _arrived(self, *, sees: bool) -> Outcome:
        pose, goal = self.pose, self._goal()
        if isinstance(goal, Failure):
            return goal
        distance = math.dist(pose.position[:2], goal.position[:2])
        turned = abs(wrap_angle(pose.yaw - goal.yaw))
        self._is_off = sees and not self._is_off and distance > _CLOSE
        location = self.params.location
        if distance > _ARRIVED or turned > _FACING:
            return Failure(
                Message(
                    "stopped {distance:.3f} m and {turned:.1f} deg off {location}",
                    distance=distance,
                    turned=math.degrees(turned),
                    location=location,
                )
            )
        placement = self.world.placement(self.params.robot)
        if placement is None or placement.place != location:
            with self.world.transaction(
                author=self.name, reason=Message("localised {distance:.0f} mm off", distance=distance * 1000.0)
            ) as tx:
                tx.place(self.params.robot, v.AT, location)
        return Success(Message("at {location}", location=location))
