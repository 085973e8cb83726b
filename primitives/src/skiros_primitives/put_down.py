"""Puts what the gripper holds into a compartment, or back onto a storage place, and lets go.

The way down ends on contact. How high that is tells the floor from what stands around it: what has landed on a wall is
not let go.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import ClassVar

import numpy as np

from skiros_primitives.arm_moves import LIFTS, HandlingPrimitive, refused
from skiros_primitives.contact import GENTLE, HandForce
from skiros_primitives.gripper import firm_force, move_fingers
from skiros_primitives.insertion import REACH, Insertion
from skiros_primitives.looking import LookingPrimitive
from skiros_primitives.part_models import level
from skiros_primitives.playback import moved_to
from skiros_primitives.surfaces import inner_region, kit_of, support_region
from skiros_py.errors import DeviceError
from skiros_py.geometry import Pose, wrap_angle
from skiros_py.messages import Message
from skiros_py.ports.kinematics import Kinematics
from skiros_py.ports.motion import LineMove, MotionPlan, NoMotion, Obstacle, PoseMove, Route, Trajectory, Vector
from skiros_py.ports.perception import Region
from skiros_py.skills.outcome import Failure, Outcome, Success, tick
from skiros_py.skills.parameters import Kind, param
from skiros_py.skills.primitive import Execution
from skiros_py.skills.surroundings import held_by, map_pose, obstacles, solid_of
from skiros_py.world import vocabulary as v
from skiros_py.world.element import Placement
from skiros_py.world.poses import write_pose

_DROP = 0.004
"""Height above the floor at which the part is released [m]."""
_LANDING = 0.012
"""How far above this a part that has met something stands on the floor already, unless the walls are lower [m]."""
_FLOOR = 0.004
"""How far above where it is believed to be the floor may be felt, unless the walls are lower [m]."""
_OVER = 0.010
"""How far above the walls the way down becomes slow [m]."""
_FAST, _SLOW, _UP = 0.25, 0.10, 0.35
"""Greatest speeds on the way down to the walls, below that, and up again [m/s]."""
_OPEN, _LEAST_OPEN = 0.016, 0.004
"""How far the fingers open past the part's width: where there is room, and in any case [m]."""
_FREE = 0.003
"""How far the fingers must have opened to hold nothing any more [m]."""
_BEHIND = 0.020
"""Length of a finger above the tip that is looked at for things beside it [m]."""
_STEP, _ACROSS = 0.0015, 0.005
"""Distance between the points of fingers that are looked at, along and across the direction in which they open [m]."""


@dataclass(frozen=True, slots=True)
class PuttingParams:
    """Parameters of every primitive that puts something down."""

    arm: str = param(v.ARM, "The arm.", kind=Kind.HARDWARE)
    gripper: str = param(v.GRIPPER, "The gripper on it.", kind=Kind.HARDWARE)
    part: str = param(v.MANIPULATABLE, "The part it holds.")


@dataclass(frozen=True, slots=True)
class Spot:
    """Where a part is put.

    Attributes:
        place: The place.
        poses: Returns the poses at which it may be released, in the map, as believed now.
        touching: Ids of what may be touched there.
        believed: Where it is believed to be once it was released; no look has shown it yet.
        walls: Height of what stands around it there [m].
        floor: How far above its floor what is felt there is the floor [m].
    """

    place: str
    poses: Callable[[], Sequence[Pose]]
    touching: frozenset[str]
    believed: Placement
    walls: float = 2.0 * _LANDING
    floor: float = _LANDING

    @property
    def landing(self) -> float:
        """How far above its end a contact ends the way down well [m]."""
        return min(_LANDING, self.walls / 2.0)


class PuttingPrimitive(HandlingPrimitive):
    """Base of the primitives that put something down; their parameters are :class:`PuttingParams` and more."""

    lifts: ClassVar[tuple[float, ...]] = (0.12,)
    """From how high above the release the part comes down, best first [m]."""
    force: HandForce | None = None
    """What pushes the hand, where that is measured, since it began the last centimetres down."""

    def put(self, spot: Spot) -> Execution[Outcome]:
        """Approaches, comes down, opens, retreats."""
        if (empty := self.not_held()) is not None:
            return empty
        turns = [pose.yaw for pose in spot.poses()]
        chosen, lift, planned = yield from self._plan(spot)
        if isinstance(planned, NoMotion):
            return self.unreachable(spot, planned)
        self.progress(1, Message("approaching"))
        refusal = yield from self.follow(planned.legs[0])
        outcome = refused(refusal) if refusal else (yield from self.lower(spot, chosen, lift, planned))
        if isinstance(outcome, Failure):
            yield from self.recover()
            turn = math.degrees(turns[chosen])
            self.context.tried.note("place", chosen, Message("put down turned by {turn:.0f} deg", turn=turn))
        return outcome

    def not_held(self) -> Failure | None:
        """Returns the failure where the gripper does not hold the part, or not any more; None where it does."""
        holding = held_by(self.context, self.params.gripper)
        if holding is not None and holding[0] == self.params.part:
            return None
        return Failure(Message("{gripper} does not hold {part}", gripper=self.params.gripper, part=self.params.part))

    def _plan(self, spot: Spot) -> Execution[tuple[int, float, MotionPlan | NoMotion]]:
        """Plans for the pose at which the fingers have most room to open; from lower above where it has to be."""
        tools = self.tools(spot)
        rooms = [self.room(tool) for tool in tools]
        for lift, room in product(self.lifts, sorted(set(rooms), reverse=True)):
            numbers = [number for number, one in enumerate(rooms) if one == room]
            fresh = self.context.tried.fresh("place", numbers)
            for some in filter(None, (fresh, [number for number in numbers if number not in fresh])):
                planned = yield from self.plan([self.way(tools[number], spot, lift) for number in some])
                if isinstance(planned, MotionPlan):
                    return some[planned.route], lift, planned
        return 0, 0.0, planned

    @staticmethod
    def unreachable(spot: Spot, why: NoMotion) -> Failure:
        """Returns the failure where no way to a place was found."""
        reason = Message("{place} cannot be reached: {reason}", place=spot.place, reason=why.reason)
        return Failure(reason, values=why.values)

    def tools(self, spot: Spot) -> list[Pose]:
        """Returns the poses of the tool in the map at which the part may be released, as it is believed to sit now."""
        holding = held_by(self.context, self.params.gripper)
        assert holding is not None, "the part is held"
        return [level(pose) @ holding[1].pose.inverse() for pose in spot.poses()]

    def way(self, tool: Pose, spot: Spot, lift: float) -> Route:
        """Returns the way from anywhere above a pose of the tool, fast to the walls, slowly down, and up again."""
        high, near = Pose((0.0, 0.0, lift)) @ tool, Pose((0.0, 0.0, spot.walls + _OVER)) @ tool
        line = [(near, _FAST), (tool, _SLOW), (high, _UP)]
        return (PoseMove(high), *(LineMove(pose, speed, spot.touching) for pose, speed in line))

    def room(self, tool: Pose) -> float:
        """Returns how far the fingers can open past what they hold, with the tool at a pose in the map [m]."""
        things = obstacles(self.context, parts=True)
        return finger_room(things, tool, self.gripper.state.gap, self.gripper_spec.finger)

    def lower(self, spot: Spot, chosen: int, lift: float, planned: MotionPlan) -> Execution[Outcome]:  # noqa: ARG002
        """Comes down and lets go."""
        refusal = yield from self.descend(planned.legs[1:], spot)
        return refused(refusal) if refusal is not None else (yield from self.release(spot))

    def descend(self, legs: Sequence[Trajectory], spot: Spot) -> Execution[NoMotion | None]:
        """Follows the last legs of a way but that up again; returns why it did not come down to the floor."""
        *fast, low, self.retreat = legs
        self.progress(2, Message("coming down"))
        for leg in fast:
            refusal = yield from self.follow(leg, landing=0.0)
            if refusal is not None:
                return refusal
        self.force = yield from self.feel_hand()
        refusal = yield from self.follow(low, landing=spot.landing, tolerance=GENTLE, force=self.force)
        if refusal is None and not (yield from self.insert([Insertion.lower], low, spot)) and self.force is not None:
            return NoMotion(Message("{part} does not stand on the floor yet", part=self.params.part), met=True)
        return refusal

    def insert(
        self, ways: Iterable[Callable[[Insertion], Execution[bool]]], low: Trajectory, spot: Spot
    ) -> Execution[bool]:
        """Lets the part down by feel; returns whether it is on the floor, False too where nothing feels.

        Args:
            ways: What to try, one after the other.
            low: The last leg of the way down.
            spot: Where it is put.
        """
        if self.force is None:
            return False
        kinematics, spec = self.context.port(Kinematics, self.params.arm), self.arm.spec
        end = kinematics.pose(spec.tip, dict(zip(spec.joints, low.positions[-1].tolist(), strict=True)))
        insertion = Insertion(self.context, self.arm, self.force, end.position[2] - _DROP, spot.floor)
        try:
            for way in ways:
                if (yield from way(insertion)):
                    return True
        except DeviceError as error:
            self.unfelt(error)
            self.force = None
        finally:
            if self.retreat is not None:
                self.retreat = moved_to(self.retreat, self.arm.state.positions, self.context.board.period)
        return False

    def release(self, spot: Spot) -> Execution[Outcome]:
        """Opens the fingers as far as there is room, and retreats."""
        gripper = self.gripper
        self.progress(3, Message("releasing"))
        before, room = gripper.state.gap, max(_LEAST_OPEN, self.room(self.tool_pose()))
        gap = min(self.gripper_spec.max_gap, before + room)
        needed = before + min(_FREE, 0.5 * (gap - before))
        opening, opened = move_fingers(self.context, gripper, gap, firm_force(self.gripper_spec)), False
        while True:
            state = tick(opening)
            if not opened and gripper.state.gap >= needed:
                self._believe_released(spot)  # at once: it may be stopped before the fingers stand
                opened = True
            if state is not None:
                break
            yield
        self.progress(4, Message("retreating"))
        yield from self.recover()
        if not opened:
            return Failure(Message("the fingers did not open: gap {gap:.0f} mm", gap=state.gap * 1000.0))
        return Success(Message("released over {place}", place=spot.place))

    def _believe_released(self, spot: Spot) -> None:
        reason = Message("released over {place}, not seen yet", place=spot.place)
        with self.world.transaction(author=self.name, reason=reason) as tx:
            tx.place(self.params.part, spot.believed.relation, spot.believed.place)
            write_pose(tx, self.params.part, None)  # a look has to determine it

    def recover(self) -> Execution[None]:
        """Retracts along the checked line, with anything it still holds."""
        if self.retreat is None:
            return
        for _ in range(_TRIES):
            yield from self._settle(self.arm.state.positions)  # moving back from a contact it may not stand yet
            if (yield from self.follow_from_here(self.retreat, expected=self.weight(self.params.part))) is None:
                break
        self.retreat = None


def finger_room(things: Iterable[Obstacle], tool: Pose, gap: float, finger: Vector) -> float:
    """Returns how far fingers can open beside walls and neighbours; what they open at most where nothing is near [m].

    Args:
        things: What stands around.
        tool: Pose of the tool in the map; the fingers open along its y axis.
        gap: Between the fingers now [m].
        finger: Width of the fingers on one side, their thickness, and how far they reach beyond the tip [m].
    """
    width, thick, ahead = finger
    y = np.arange(gap / 2.0, gap / 2.0 + thick + _OPEN / 2.0 + 2.0 * _STEP, _STEP)
    grid = np.meshgrid(
        np.linspace(-width / 2.0, width / 2.0, max(5, round(width / _ACROSS) + 1)),
        y,
        np.linspace(-_BEHIND, ahead, 6),
        indexing="ij",
    )
    points = np.stack(grid, axis=-1).reshape(-1, 3)
    points = np.vstack([points, points * (1.0, -1.0, 1.0)])
    hit = np.zeros(len(points), dtype=bool)
    for thing in things:
        for block in thing.solid.primitives:
            at = np.abs((thing.pose @ block.pose).inverse().apply(tool.apply(points)))
            if block.kind == "box":
                hit |= np.all(at <= np.asarray(block.size) / 2.0, axis=1)
            else:
                hit |= (np.hypot(at[:, 0], at[:, 1]) <= block.size[0]) & (at[:, 2] <= block.size[1] / 2.0)
    nearest = float(np.abs(points[hit, 1]).min(initial=math.inf)) - gap / 2.0 - thick
    return min(_OPEN, max(0.0, 2.0 * (nearest - _STEP)))


_EXACT = 0.001
"""What is seen nearer than this to where it was aimed needs no other way [m]."""
_TURN = 0.1
"""An angle counts as this length times it [m/rad]."""
_TRIES = 2
"""So often it is looked where to come down; then the places beside are tried."""
_SIDES = ((1, 0), (-1, 0), (0, 1), (0, -1), (1, 1), (-1, -1), (1, -1), (-1, 1))
_BESIDE = 0.0025
"""How far beside [m]."""


class PutDown(PuttingPrimitive, LookingPrimitive):
    """Comes from straight above, looking into the compartment from there; all ways are checked before anything moves.

    A part that lands on something higher than the floor is lifted again. Another look tells where the compartment is;
    then the places a few millimetres beside it are tried.
    """

    name: ClassVar[str] = "put_down"
    is_seen = False
    """True once a look has shown where the place is that the part is put into."""
    lifts: ClassVar[tuple[float, ...]] = (0.18, 0.14, LIFTS[-1])

    @dataclass(frozen=True, slots=True)
    class Params(PuttingParams):
        """Parameters."""

        camera: str = param(v.CAMERA, "The camera on the hand, to look before coming down.", kind=Kind.HARDWARE)
        compartment: str = param(v.CONTAINER, "Where to put it.")

    def execute(self) -> Execution[Outcome]:
        """Puts it into the compartment."""
        compartment = self.params.compartment
        region, solid = inner_region(self.context, compartment), solid_of(self.world, compartment)
        if isinstance(region, str):
            return Failure(region)
        places = self._places(region)

        def poses() -> list[Pose]:
            now = map_pose(self.context, compartment) or region.pose
            return [now @ pose for pose in places]

        kit = kit_of(self.world, compartment)
        if kit is not None and self.world.stamp(kit).time > self.world.stamp(self.robot.id).time:
            self.fitted |= {kit}  # since the base arrived
        touching = frozenset({self.params.part, compartment})
        walls = float(solid.bounds()[1][2]) if solid is not None else 0.0
        floor = min(_FLOOR, walls / 3.0) if walls else _FLOOR
        believed = Placement(v.MAY_BE_IN, compartment)
        return (yield from self.put(Spot(compartment, poses, touching, believed, walls, floor)))

    def _places(self, region: Region) -> list[Pose]:
        """Release poses in the compartment: as taught, else in its centre, at the quarter turns at which it fits."""
        placing = self.world.value(self.params.compartment, v.PLACING_POSE)
        if isinstance(placing, Pose):
            x, y, z = placing.position
            return [Pose((x, y, max(z, _DROP)), placing.orientation)]
        solid = solid_of(self.world, self.params.part)
        low, high = solid.bounds() if solid is not None else (np.zeros(3), np.zeros(3))
        quarters = fitting_quarters(((high - low)[:2] / 2.0).tolist(), region.half_extents)
        return [Pose.of(0.0, 0.0, _DROP, yaw=quarter * math.pi / 2.0) for quarter in quarters]

    def lower(self, spot: Spot, chosen: int, lift: float, planned: MotionPlan) -> Execution[Outcome]:
        """Looks, corrects where to come down, and comes down; where it meets a wall, it tries again."""
        tool, legs = self.tools(spot)[chosen], planned.legs[1:]
        for attempt in range(_TRIES + len(_SIDES)):
            if attempt == _TRIES and self.force is not None:  # what is beside was felt already
                break
            if attempt < _TRIES:
                seen = yield from self._look(aside=attempt > 0)
                if isinstance(seen, str):
                    return Failure(seen)
                if (lost := self.not_held()) is not None:  # it slipped out where it met a wall
                    return lost
                aimed, tool = tool, self.tools(spot)[chosen]
                way = self.way(tool, spot, lift) if not seen or _apart(tool, aimed) > _EXACT else None
            else:
                x, y = _SIDES[attempt - _TRIES]
                beside = replace(spot, touching=spot.touching | {kit_of(self.world, spot.place) or spot.place})
                way = self.way(Pose((_BESIDE * x, _BESIDE * y, 0.0)) @ tool, beside, lift)[1:]
            if way is not None:
                again = yield from self.plan([way])
                if isinstance(again, NoMotion) and attempt < _TRIES:  # there it may have to be turned
                    chosen, lift, again = yield from self._plan(spot)
                    tool = self.tools(spot)[chosen]
                if isinstance(again, NoMotion):
                    return self.unreachable(spot, again)
                legs = again.legs
            refusal = yield from self.descend(legs, spot)
            refusal = yield from self._feel_the_way(refusal, legs[-2], spot)
            if refusal is None:
                return (yield from self.release(spot))
            if not refusal.met:
                return refused(refusal)
            if attempt < _TRIES:
                yield from self.recover()
        return self._too_high(spot)

    def _feel_the_way(self, refusal: NoMotion | None, low: Trajectory, spot: Spot) -> Execution[NoMotion | None]:
        """Searches where the part goes in, where it has met something and a look has shown the place."""
        if refusal is None or not (refusal.met and self.is_seen) or self.force is None:
            return refusal
        self.progress(2, Message("feeling the way into {place}", place=spot.place))
        return None if (yield from self.insert((Insertion.search, Insertion.shake), low, spot)) else refusal

    def _too_high(self, spot: Spot) -> Failure:
        known = {"part": self.params.part, "place": spot.place}
        if self.force is None:
            return Failure(Message("{part} lands on something higher than the floor of {place}, beside too", **known))
        return Failure(
            Message(
                "{part} lands on something higher than the floor of {place}: it was lifted and looked for again, moved "
                "sideways by up to {reach:.0f} mm, and shaken",
                **known,
                reach=1e3 * REACH,
            )
        )

    def _look(self, *, aside: bool) -> Execution[bool | str]:
        """Looks where kit and compartment are, from where the arm is.

        Args:
            aside: True to look from aside where what is held hides them; else the last look and the landing have to do.

        Returns:
            Whether the arm is still where it was; a text: why nothing can be put there.
        """
        camera, compartment = self.params.camera, self.params.compartment
        kit = kit_of(self.world, compartment)
        believed = map_pose(self.context, kit) if kit is not None else None
        if kit is None or believed is None:
            return True
        picture = yield from self.capture()
        result = yield from self.fit(kit, believed, picture)
        self.is_seen = result.pose is not None or aside
        if result.pose is None and not aside:
            return True
        if result.pose is None:
            known = {"arm": self.params.arm, "camera": camera, "kit": kit, "compartment": compartment}
            outcome = yield from self.call("register_kit", **known)
            return outcome.reason if isinstance(outcome, Failure) else False
        return (yield from self.content(compartment, picture)) or True


def fitting_quarters(half: Sequence[float], room: Sequence[float]) -> Sequence[int]:
    """Returns the quarter turns at which an outline fits into a rectangle; all where it fits at none.

    Args:
        half: Half lengths of the outline [m].
        room: Half lengths of the rectangle [m].
    """
    straight, across = (all(h <= r for h, r in zip(one, room, strict=True)) for one in (half, half[::-1]))
    return range(4) if straight == across else (0, 2) if straight else (1, 3)


def _apart(one: Pose, other: Pose) -> float:
    """Returns how far two poses are from each other, angles included [m]."""
    return one.distance(other) + _TURN * abs(wrap_angle(one.yaw - other.yaw))


_APART = 0.12
"""Least distance between the middles of a part that is put back and of those that are there [m]."""
_BORDER = 0.04
_NEAREST = 4
"""So many free spots are planned for."""


class PutBack(PuttingPrimitive):
    """Puts what the gripper holds back onto a storage place: where it is free, as near to the hand as possible."""

    name: ClassVar[str] = "put_back"

    @dataclass(frozen=True, slots=True)
    class Params(PuttingParams):
        """Parameters."""

        place: str = param(v.LOCATION, "Where to put it.")

    def execute(self) -> Execution[Outcome]:
        """Puts it back; that it lies there is believed until a look shows something else."""
        region = support_region(self.context, self.params.place)
        if isinstance(region, str):
            return Failure(region)
        spots = self._free(region)
        if not spots:
            return Failure(Message("there is no free spot on {place}", place=self.params.place))
        place = self.params.place
        touching = frozenset({self.params.part, place})
        return (yield from self.put(Spot(place, lambda: spots, touching, Placement(v.IN, place))))

    def _free(self, region: Region) -> list[Pose]:
        """Returns free spots, the nearest first, each with the part turned as it is now and crosswise."""
        parts = [part for part in self.world.instances(v.MANIPULATABLE) if part != self.params.part]
        holding = held_by(self.context, self.params.gripper)
        here = region.pose.inverse() @ self.tool_pose() @ (holding[1].pose if holding else Pose())
        taken = [region.pose.inverse() @ pose for part in parts if (pose := map_pose(self.context, part)) is not None]
        reach_x, reach_y = (half - _BORDER for half in region.half_extents)
        below = (max(-reach_x, min(reach_x, here.position[0])), max(-reach_y, min(reach_y, here.position[1])))
        shares = (-1.0, -0.5, 0.0, 0.5, 1.0)
        spots = [below, *((a * reach_x, b * reach_y) for a, b in product(shares, shares))]
        free = [spot for spot in spots if all(math.dist(spot, other.position[:2]) >= _APART for other in taken)]
        free.sort(key=lambda spot: math.dist(spot, below))
        turns = (here.yaw, here.yaw + math.pi / 2.0)
        return [region.pose @ Pose.of(x, y, _DROP, yaw=yaw) for (x, y), yaw in product(free[:_NEAREST], turns)]
