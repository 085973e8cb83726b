"""Common base of the arm primitives: planning a motion and following it."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Sequence
from dataclasses import replace
from itertools import product
from typing import ClassVar

import numpy as np

from skiros_primitives.contact import PRESS, TOLERANCE, ContactWatch, HandForce, Touch, believe_obstacle
from skiros_primitives.floor_obstacles import bodies, driving, rides
from skiros_primitives.gripper import firm_force, move_fingers
from skiros_primitives.obstacle_review import views_of
from skiros_primitives.playback import Playback, even, reversed_way
from skiros_primitives.views import SeeingPrimitive
from skiros_py.devices.arm import ArmSpec, ArmState, ArmTarget
from skiros_py.devices.gripper import Gripper, GripperSpec, GripperState
from skiros_py.devices.localiser import LocaliserSpec
from skiros_py.errors import DeviceError
from skiros_py.geometry import Pose
from skiros_py.messages import Message, listed
from skiros_py.ports.kinematics import Kinematics
from skiros_py.ports.motion import (
    SHARES,
    ArmPlanner,
    Held,
    JointMove,
    LineMove,
    MotionCheck,
    MotionPlan,
    MotionRequest,
    NoMotion,
    Obstacle,
    PoseMove,
    Route,
    Trajectory,
)
from skiros_py.ports.paths import Outline
from skiros_py.skills.context import RunContext
from skiros_py.skills.outcome import Failure, tick
from skiros_py.skills.primitive import Execution
from skiros_py.skills.surroundings import held_by, obstacles
from skiros_py.world.vocabulary import GRIPPER, HAS_A, MANIPULATABLE, MASS, OBSTACLE


def _met(thing: str) -> str:
    """Returns under which name it is remembered that something that is known was met."""
    return f"met {thing}"


def _felt(thing: str) -> str:
    """Returns under which name it is remembered that something was felt that is not known."""
    return f"felt {thing}"


def _looked_at(thing: str) -> str:
    """Returns under which name it is remembered that an obstacle was looked at again."""
    return f"looked at {thing}"


_ARRIVED = 0.02
"""Greatest joint error at the end of a motion [rad]."""
_COURTESY = 120.0
"""Longest wait for passing robots [s]."""


_GRAVITY = 9.81
_HEAVY = 3.0
"""Greatest mass of parts that are lifted without knowing their mass [kg]."""
_BLOCK = 0.10
"""Side length of the block that is assumed where a link has met something [m]."""
_AHEAD = 0.10
"""How far the middle of that block is ahead of the link's frame [m]."""
_BRAKING = 0.3
"""Time in which an arm brakes where something is in its way [s]."""
_BACK = 0.15
"""Time of its motion by which an arm moves back from a contact near to things [s]."""
_RELIEF = 0.01
"""Time of its motion by which it is behind the contact at once [s]."""
_BACKWARDS = 0.4
"""Speed at which it moves back, as a share of that at which it came."""
_SIGMAS = 3.0
"""So many standard deviations of the localiser's error are kept away from things."""
_LENGTH = 0.9
"""How far from the middle of its base an arm meets things about [m]."""


def refused(why: NoMotion) -> Failure:
    """Returns the failure of what needed a motion that is not possible."""
    return Failure(why.reason, values=why.values)


def further(one: NoMotion | None, other: NoMotion) -> NoMotion:
    """Returns of two ways that are not possible the later one, unless only the earlier one is within reach."""
    return one if one is not None and refused(other).is_out_of_reach and not refused(one).is_out_of_reach else other


_HOME = 0.05
"""Maximum joint error of an arm in such a posture [rad]."""


def carrying_postures(arm: ArmSpec) -> list[tuple[float, ...]]:
    """Returns the postures in which the base of an arm may drive, best first.

    They are home, home with the hand turned, and home turned aside, where nothing reaches over what is ahead.
    """
    first, *others, last = arm.home
    turned = [(first, *others, last + quarters * math.pi / 2.0) for quarters in (0, 1, -1, 2, -2)]
    return [*turned, *((first + side * math.pi / 2.0, *others, last) for side in (1, -1))]


def is_stowed(context: RunContext, arm: ArmSpec) -> bool:
    """Returns True when an arm is in a posture in which its base may drive."""
    now = context.board.snapshot.state(arm.id, ArmState).positions
    return any(np.abs(np.subtract(now, posture)).max() <= _HOME for posture in carrying_postures(arm))


class ArmPrimitive(SeeingPrimitive):
    """Base of the primitives that move an arm; their parameters have a field ``arm``."""

    looks_again: ClassVar[bool] = False
    """Whether it looks again at believed obstacles that are in the way."""
    _is_looking_again = False
    touched = False
    """True once the arm has met something."""
    opening: float | None = None
    """Gap to which the fingers open at most [m]; None for as far as they go."""
    fitted: frozenset[str] = frozenset()
    """Ids of what was fitted to a picture from where the base stands."""

    @property
    def base_pose(self) -> Pose:
        """Where the robot's base is in the map, as localised."""
        return self.robot.pose(self.context.board.snapshot, self.context.board.guard)

    @property
    def gripper_id(self) -> str:
        """The gripper on the arm."""
        owned = self.world.objects(self.params.arm, HAS_A)
        return next(g for g in owned if self.world.ontology.is_a(self.world.element(g).type, GRIPPER))

    @property
    def gripper_spec(self) -> GripperSpec:
        """The description of the gripper on the arm."""
        return next(g for g in self.robot.of(GripperSpec) if g.arm == self.params.arm)

    def weight(self, part: str) -> float:
        """Returns the weight of a part with a margin [N]."""
        mass = self.world.value(part, MASS)
        return _GRAVITY * (1.5 * mass if isinstance(mass, float) and mass > 0.0 else _HEAVY)

    @property
    def is_planned(self) -> bool:
        """False in a cell without an arm planner: it has no bodies, hence no obstacles."""
        return self.context.ports.find(ArmPlanner, self.params.arm) is not None

    def held(self) -> Held | None:
        """What the arm's gripper is believed to hold."""
        found = held_by(self.context, self.gripper_id)
        return found[1] if found else None

    def open_wide(self, gripper: Gripper) -> Execution[GripperState]:
        """Opens the fingers as far as they go, or as wide as its motions were planned for."""
        spec = self.gripper_spec
        return (yield from move_fingers(self.context, gripper, self._widest, firm_force(spec)))

    def plan(
        self,
        routes: Sequence[Route],
        *,
        speed: float = 1.0,
        base: Pose | None = None,
        shares: tuple[float, ...] = SHARES,
        unseen: Sequence[Obstacle] = (),
    ) -> Execution[MotionPlan | NoMotion]:
        """Plans the best of several routes from the arm's current position and reserves the floor below it.

        While other robots drive there, it waits; since they stand elsewhere afterwards, it plans again.

        Args:
            routes: The routes.
            speed: Share of the joint speed limits to use, 0 to 1.
            base: Where the base will be in the map; left out: where it is.
            shares: Shares of the errors of where things are to keep away by, the best first.
            unseen: Spaces to keep out of, because something may be there.
        """
        deadline = self.context.now + _COURTESY
        felt = [one.id for one in self._around() if self.context.tried.options[_felt(one.id), 0]]
        if base is None and felt:
            yield from self._look_again(felt)
        while True:
            before = driving(self.context, self.robot.id)
            planned = yield from self._planned(routes, speed, base=base, shares=shares, unseen=unseen)
            if isinstance(planned, NoMotion):
                met = {thing for one in planned.refusals for _, thing in one.touches}
                if base is None and (yield from self._look_again(met)):
                    continue
                return planned
            refusal = yield from self._reach_out(planned.covers, deadline)
            if refusal is not None:
                return refusal
            if {*before} <= {*driving(self.context, self.robot.id)}:  # no robot has stopped at a new place meanwhile
                return planned

    def _look_again(self, met: Collection[str]) -> Execution[bool]:
        """Looks from the side at obstacles that are only believed, each once for this purpose.

        Args:
            met: Ids of what was felt, or is in the way.

        Returns:
            Whether one of them is not there, or smaller.
        """
        camera = self.hand_camera
        things = [one for one in self._around() if one.id in met and self.world.element(one.id).type == OBSTACLE]
        things = [one for one in things if not self.context.tried.options[_looked_at(one.id), 0]]
        if not self.looks_again or self._is_looking_again or camera is None or not things:
            return False
        self._is_looking_again = True
        for one in things:
            self.context.tried.note(_looked_at(one.id), 0, Message("looked again at {thing}", thing=one.id))
            back = self.camera_in_tip(camera).inverse()
            stuck = yield from self.go([(PoseMove(pose @ back),) for pose in views_of(one, self.base_pose)])
            if stuck is None:
                yield from self.take_picture(camera.id)
                self.show_pictures(self._around())
        self._is_looking_again = False
        now = {one.id: one for one in self._around()}
        return any(now.get(one.id) != one for one in things)

    def _reach_out(self, outline: Outline, deadline: float) -> Execution[NoMotion | None]:
        """Waits until no robot drives where the arm will move, and reserves the floor there."""
        told: tuple[str, ...] = ()
        while there := self.context.floor.stretch(self.params.arm, outline):
            if self.context.now >= deadline:
                return NoMotion(
                    Message("waited {seconds:g} s for {robots} to drive past", seconds=_COURTESY, robots=listed(there))
                )
            if there != told:
                told = there
                self.progress(1, Message("waits for {robots} to drive past", robots=listed(there)))
            yield
        return None

    def _planned(
        self,
        routes: Sequence[Route],
        speed: float,
        *,
        base: Pose | None = None,
        start: tuple[float, ...] | None = None,
        shares: tuple[float, ...] = SHARES,
        unseen: Sequence[Obstacle] = (),
    ) -> Execution[MotionPlan | NoMotion]:
        held, around, version = self.held(), self._around(), self.world.version
        seen = self.show_pictures(around)
        if self.world.version != version:  # an obstacle is not there
            around = self._around()
        others = tuple(replace(one, error=self._error(one)) for one in bodies(self.context, self.robot.id))
        request = MotionRequest(
            device=self.params.arm,
            start=self.arm.state.positions if start is None else start,
            base=base or self.base_pose,
            routes=tuple(routes),
            obstacles=(*around, *others, *self.context.pictures.unknown_to(self.robot.id), *unseen),
            held=held,
            gap=self._gap(held),
            speed=speed,
            seed=self.seed(),
            shares=shares,
        )
        planned = yield from self.wait(self.context.port(ArmPlanner, self.params.arm).plan(request))
        self.note_unknown(seen)
        return planned

    def _around(self) -> tuple[Obstacle, ...]:
        """Returns what is believed to stand around, with the errors of where it is."""
        return tuple(replace(one, error=self._error(one)) for one in obstacles(self.context, parts=True))

    def _gap(self, held: Held | None) -> float:
        gripper = self.context.board.snapshot.of(GripperState).get(self.gripper_id)
        return gripper.gap if gripper and held else self._widest  # empty ones may open meanwhile

    @property
    def _widest(self) -> float:
        return self.gripper_spec.max_gap if self.opening is None else self.opening

    def _error(self, thing: Obstacle) -> float:
        """Returns how far beside its believed place something may be for the arm: the localiser's error [m].

        What was seen, fitted or felt from here has that error, too, and so none for the arm. What the arm has met
        shows that the error is larger than usual.
        """
        type_ = self.world.element(thing.id).type if self.world.has(thing.id) else ""
        seen = any(self.world.ontology.is_a(type_, class_) for class_ in (MANIPULATABLE, OBSTACLE))
        if seen or rides(self.context, thing.id, self.robot):
            return 0.0
        noise = (math.hypot(one.position_noise, _LENGTH * one.heading_noise) for one in self.robot.of(LocaliserSpec))
        met = self.context.tried.options[_met(thing.id), 0]
        return _SIGMAS * max(noise, default=0.0) * (met + (thing.id not in self.fitted))

    def follow(
        self,
        trajectory: Trajectory,
        *,
        expected: float = 0.0,
        landing: float | None = None,
        tolerance: float = TOLERANCE,
        force: HandForce | None = None,
    ) -> Execution[NoMotion | None]:
        """Sends a trajectory, one sample per cycle, until the arm is at rest; returns why it did not arrive.

        It follows the clock of the run: when that slows down because the run is paused, the arm brakes along its path.
        Where it meets something, it yields at once and moves back a little.

        Args:
            trajectory: The motion.
            expected: Force at the tip that is no contact, such as the weight of what is lifted [N].
            landing: How far before its end a contact ends it as well, for motions that come near to things on purpose
                [m]; None for free motions, where what is met becomes an obstacle.
            tolerance: What counts as a contact, see :class:`ContactWatch` [N m].
            force: What pushes the hand, where that is measured: where it presses onto something the motion ends, and
                the hand stays there. Without it the joints have to feel that, with this tolerance.
        """
        feels = TOLERANCE if force is not None else tolerance
        watch = ContactWatch.of(self.context, self.arm, expected=expected, tolerance=feels)
        playback = Playback(trajectory, self.context.board.period, self.context.now)
        looking = self._look_ahead(trajectory, playback) if landing is None else None
        blocked: NoMotion | None = None
        rate, behind = 1.0, 0.0
        while not playback.ended and rate > 0.0:
            if looking is not None and blocked is None:
                blocked = tick(looking)
            if blocked is not None:  # it brakes along its path
                rate = max(0.0, rate - self.context.board.period / _BRAKING)
                behind += (1.0 - rate) * self.context.board.period
            self.arm.command(playback.target(self.context.now - behind))
            yield
            pressed = force is not None and self._presses(force)
            if pressed:
                return (yield from self._stay(trajectory, landing))
            if pressed is None:
                force = None
                if watch is not None:
                    watch.tolerance = tolerance
            if watch is not None and (touch := watch.felt()) is not None:
                if landing is not None and self._left(trajectory) <= landing:
                    yield from self._settle(self.arm.state.positions)
                    return None
                is_free = landing is None and not watch.touches_at_start
                return (yield from self._yield_to(touch, trajectory, is_free=is_free))
        if blocked is not None and not playback.ended:
            yield from self._settle(self.arm.state.positions)
            self.emit("way_blocked", {"device": self.params.arm})
            return blocked
        last = tuple(trajectory.positions[-1].tolist())
        yield from self._settle(last)
        off = max(abs(is_ - wanted) for is_, wanted in zip(self.arm.state.positions, last, strict=True))
        if off > _ARRIVED:
            return NoMotion(
                Message(
                    "{arm} stopped {off:.1f} deg short: something is in its way",
                    arm=self.params.arm,
                    off=math.degrees(off),
                ),
                met=True,
            )
        return None

    def _presses(self, force: HandForce) -> bool | None:
        """Returns whether the hand presses onto something; None where the sensor does not answer any more."""
        try:
            return bool(force.push()[2] >= PRESS)
        except DeviceError as error:
            self.unfelt(error)
            return None

    def _stay(self, trajectory: Trajectory, landing: float | None) -> Execution[NoMotion | None]:
        """Stays where the hand presses onto something; returns why that is not where the motion was to end."""
        yield from self._settle(self.arm.state.positions)
        if landing is not None and self._left(trajectory) <= landing:
            return None
        return NoMotion(Message("{link} of {arm} met something", link=self.arm.spec.tip, arm=self.params.arm), met=True)

    def feel_hand(self) -> Execution[HandForce | None]:
        """Returns what pushes the hand besides what it holds now; None where nothing measures it."""
        try:
            force = HandForce.of(self.context, self.arm)
            if force is not None:
                yield from force.weigh()
        except DeviceError as error:
            self.unfelt(error)
            return None
        return force

    def unfelt(self, why: DeviceError) -> None:
        """Says that the joints feel contact from here on, because a sensor at the hand does not answer."""
        self.progress(2, Message("{reason}: the joints of {arm} feel contact", reason=str(why), arm=self.params.arm))

    def _look_ahead(self, trajectory: Trajectory, playback: Playback) -> Execution[NoMotion] | None:
        """Takes pictures while the arm follows a trajectory, see :meth:`look_ahead`."""
        held = self.held()

        def rest() -> MotionCheck:
            left = trajectory.positions[playback.sample :]
            return MotionCheck(self.params.arm, self.base_pose, left, held, self._gap(held))

        return self.look_ahead(self._around, rest)

    def _left(self, trajectory: Trajectory) -> float:
        """Returns how far the tip is from the end of a trajectory [m]."""
        kinematics, spec = self.context.port(Kinematics, self.params.arm), self.arm.spec
        here, there = (
            kinematics.pose(spec.tip, dict(zip(spec.joints, positions, strict=True)))
            for positions in (self.arm.state.positions, trajectory.positions[-1].tolist())
        )
        return here.distance(there)

    def _settle(self, positions: tuple[float, ...]) -> Execution[None]:
        """Waits until the arm is at rest."""
        deadline = self.context.now + 0.5
        while not self.arm.state.still and self.context.now < deadline:
            self.arm.command(ArmTarget(positions, (0.0,) * len(positions)))
            yield

    def _yield_to(self, touch: Touch, trajectory: Trajectory, *, is_free: bool) -> Execution[NoMotion]:
        """Moves back the way it came: from a free motion all the way, where it touched nothing before.

        What explains the contact is where it was believed to be; else there is something that was not known.
        """
        self.touched = True
        here = self.arm.state.positions
        yield from self._move_back(trajectory, here, math.inf if is_free else _BACK)
        reason = Message("{link} of {arm} met something", link=touch.link, arm=self.params.arm)
        known = (yield from self._near(touch, here)) if is_free else None
        if known is not None:
            reason = Message("{link} of {arm} met {thing}", link=touch.link, arm=self.params.arm, thing=known)
            self.context.tried.note(_met(known), 0, reason)
        elif is_free:
            ends = self.base_pose.apply(np.add((touch.point, touch.end), np.multiply(_AHEAD, touch.direction)))
            low, high = ends.min(axis=0) - _BLOCK / 2.0, ends.max(axis=0) + _BLOCK / 2.0
            x, y, _ = ((low + high) / 2.0).tolist()
            length, width, height = (high - low).tolist()
            where = Pose((x, y, float(low[2])))
            felt = believe_obstacle(self.world, self.name, where, (length, width, height), reason)
            self.context.tried.note(_felt(felt), 0, reason)
        self.emit("contact", {"device": self.params.arm, "link": touch.link, "effort": round(touch.effort, 1)})
        return NoMotion(reason, met=True)

    def _move_back(self, trajectory: Trajectory, here: Sequence[float], most: float) -> Execution[None]:
        """Moves back along a trajectory, at once a little behind where the arm is, so that it presses no longer.

        Args:
            trajectory: The motion.
            here: Where the arm has met something [rad].
            most: How far back, as time of the motion [s].
        """
        period = self.context.board.period
        at = float(np.abs(trajectory.positions - np.asarray(here)).max(axis=1).argmin())
        end = max(0.0, at - most / period)
        places = np.append(np.arange(max(end, at - _RELIEF / period), end, -_BACKWARDS), end)
        samples = np.arange(len(trajectory.positions))
        positions, speeds = (
            np.column_stack([np.interp(places, samples, column) for column in rows.T])
            for rows in (trajectory.positions, -_BACKWARDS * trajectory.velocities)
        )
        for position, speed in zip(positions[:-1].tolist(), speeds.tolist(), strict=False):
            self.arm.command(ArmTarget(tuple(position), tuple(speed)))
            yield
        yield from self._settle(tuple(positions[-1].tolist()))

    def _near(self, touch: Touch, here: tuple[float, ...]) -> Execution[str | None]:
        """Returns the id of what explains a contact because it may be there; None if nothing known does."""
        planned = yield from self._planned([(JointMove(here),)], 1.0, start=here, shares=SHARES[:1])
        met = [other for one in planned.refusals for link, other in one.touches if touch.may_be(link)]
        known = [one for one in met if self.world.has(one) and self.world.element(one).type != OBSTACLE]
        return known[0] if known else None

    def go_straight(self, goal: Sequence[float]) -> Execution[NoMotion | None]:
        """Moves to joint angles from rest to rest, for arms without a planner.

        Args:
            goal: Where to [rad].
        """
        return (yield from self.follow(even(self.arm.state.positions, goal, self.context.board.period)))

    def follow_plan(self, planned: MotionPlan) -> Execution[NoMotion | None]:
        """Follows all moves of a plan; where it arrives, only the floor below the arm's end position stays reserved."""
        for trajectory in planned.legs:
            refusal = yield from self.follow(trajectory)
            if refusal is not None:
                return refusal
        self.context.floor.stretch(self.params.arm, planned.ends)
        return None

    def follow_from_here(self, trajectory: Trajectory, *, expected: float = 0.0) -> Execution[NoMotion | None]:
        """Follows the rest of a trajectory, from the sample nearest to the arm's current position."""
        here = np.asarray(self.arm.state.positions)
        nearest = int(np.abs(trajectory.positions - here).max(axis=1).argmin())
        positions, velocities = trajectory.positions[nearest:], trajectory.velocities[nearest:]
        if np.abs(positions[0] - here).max() > _ARRIVED:
            to = even(self.arm.state.positions, positions[0].tolist(), self.context.board.period)
            positions, velocities = np.vstack([to.positions, positions]), np.vstack([to.velocities, velocities])
        return (yield from self.follow(Trajectory(positions, velocities), expected=expected, landing=0.0))

    def go(self, routes: Sequence[Route], *, speed: float = 1.0) -> Execution[NoMotion | None]:
        """Plans and follows all moves of the best route; returns the reason if there is none."""
        planned = yield from self.plan(routes, speed=speed)
        return planned if isinstance(planned, NoMotion) else (yield from self.follow_plan(planned))

    def tool_pose(self) -> Pose:
        """Returns the pose of the arm's tip in the map now."""
        return self.context.frames.at(self.context.board.snapshot).located(self.params.arm)


LIFTS = (0.10, 0.06)
"""How far above a grasp or a release the approach starts and the retreat ends, best first [m]; the lower one is for
high places, where the arm reaches no higher."""
_DOWN, _UP = 0.20, 0.35
"""Speed down, where things are met, and up again the same way [m/s]."""


def above_routes(tools: Iterable[Pose], touching: Iterable[str], lift: float) -> list[Route]:
    """Returns for each pose of the tool in the map the way down to it and up again.

    Args:
        tools: The poses.
        touching: Ids of what may be touched below.
        lift: How far above it the way down starts and the way up ends [m].
    """
    found: list[Route] = []
    for tool in tools:
        high = Pose((0.0, 0.0, lift)) @ tool
        down, up = (LineMove(pose, speed, frozenset(touching)) for pose, speed in ((tool, _DOWN), (high, _UP)))
        found.append((PoseMove(high), down, up))
    return found


class HandlingPrimitive(ArmPrimitive):
    """Base of the primitives that come from straight above and retreat; their parameters have a field ``gripper``."""

    looks_again = True
    retreat: Trajectory | None = None
    """The checked line upwards, while the tool is below its end."""

    @property
    def gripper(self) -> Gripper:
        """The gripper on the arm."""
        return Gripper(self.context.board, self.params.gripper)

    def plan_fresh(
        self, choice: str, tools: Sequence[Pose], touching: Iterable[str], among: Sequence[int]
    ) -> Execution[tuple[int, MotionPlan | NoMotion]]:
        """Plans for one of several poses of the tool, rather one that was not tried in vain yet.

        Args:
            choice: What these are a choice of.
            tools: The poses in the map.
            touching: Ids of what may be touched there.
            among: The numbers of those that are possible now.

        Returns:
            Which of the poses was chosen, and the plan; or why there is none.
        """
        fresh = self.context.tried.fresh(choice, among)
        others = [number for number in among if number not in fresh]
        refusal: NoMotion | None = None
        for numbers, lift in product(filter(None, (fresh, others)), LIFTS):
            planned = yield from self.plan(above_routes((tools[number] for number in numbers), touching, lift))
            if isinstance(planned, MotionPlan):
                return numbers[planned.route], planned
            refusal = further(refusal, planned)
        assert refusal is not None, "each pose is tried"
        return 0, refusal

    def come_down(self, planned: MotionPlan, *, landing: float = 0.0) -> Execution[NoMotion | None]:
        """Follows the way down; where it does not arrive, it retreats and returns why.

        Args:
            planned: The way there, down and up.
            landing: How far above its end a contact ends the way down as well [m].
        """
        approach, down, up = planned.legs
        self.progress(1, Message("approaching"))
        refusal = yield from self.follow(approach)
        if refusal is None:
            self.retreat = reversed_way(down)
            refusal = yield from self.follow(down, landing=landing)
            if refusal is None:
                self.retreat = up
        if refusal is not None:
            yield from self.recover()
        return refusal
