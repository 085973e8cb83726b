"""Common base of the primitives that drive: following a path, and standing where something is met or in the way."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from skiros_primitives.contact import WholeMotion
from skiros_primitives.lookout import Lookout, believe_seen, forget
from skiros_primitives.sighting import PlaceInSight
from skiros_primitives.travelling import TravellingArms
from skiros_py.devices.arm import ArmSpec
from skiros_py.errors import DeviceError
from skiros_py.geometry import Array, Pose
from skiros_py.messages import Message
from skiros_py.ports.board import Mobile
from skiros_py.ports.kinematics import Dynamics, Kinematics
from skiros_py.ports.paths import Path
from skiros_py.skills.context import RunContext, Way
from skiros_py.skills.primitive import Execution, Primitive
from skiros_py.world import vocabulary as v

_PATIENCE = 60.0
"""Longest time without progress on the path [s]."""


_PUSH = 40.0
"""What the drives exert beyond what speeding up needs, from which the base has met something [N, N m]."""
_PUSHES = 2
"""Number of cycles in a row in which it is felt."""


class Bumper:
    """Feels in what its drives exert whether a base pushes something; to be asked once per cycle.

    Args:
        context: The run.
        base: The base; if its state has no ``force`` and ``torque``, or the mass of its robot is unknown, nothing is
            felt.
    """

    def __init__(self, context: RunContext, base: Mobile) -> None:
        self._dynamics = context.ports.find(Dynamics, base.id)
        self._motion = WholeMotion(context, context.cell.group_of(base.id))
        self._base = base
        self._glides = base.spec.drives_sideways
        self._measures = self._dynamics is not None and None not in self._exerted()
        self._pushes = 0

    def felt(self) -> bool:
        """Returns True when the base has pushed something for some cycles."""
        exerted, motion = self._exerted(), self._motion.since_before()
        if self._dynamics is None or not self._measures:
            return False
        if None in exerted or not all(map(math.isfinite, exerted)):
            raise DeviceError(
                "{base} does not measure what its drives exert: it would feel no contact", base=self._base.id
            )
        needed = self._dynamics.efforts(motion).tolist()
        force, torque = exerted[0] - needed[0], exerted[1] - needed[2]  # ahead and around
        aside = exerted[2] - needed[1] if self._glides else 0.0
        self._pushes = self._pushes + 1 if max(abs(force), abs(torque), abs(aside)) > _PUSH else 0
        return self._pushes >= _PUSHES

    def _exerted(self) -> list[Any]:
        """Returns force ahead, moment, and for a base that glides force to the left; None where not measured."""
        names = ("force", "torque", "side_force") if self._glides else ("force", "torque")
        return [getattr(self._base.state, name, None) for name in names]


_SETTLED = 0.05
"""Time after which a localiser says where a base stands that has come to rest [s]."""
_TURNING = 0.02
"""Speed up to which a base only turns [m/s]."""


class DrivingPrimitive(Primitive[Any]):
    """Base of the primitives that drive; their parameters have fields ``base`` and ``robot``."""

    @classmethod
    def load(cls, context: RunContext) -> None:
        """Loads the kinematics of the arms, which tell what sticks out: a control cycle is too short for that."""
        for arm in (arm for robot in context.cell.robots for arm in robot.of(ArmSpec)):
            context.ports.find(Kinematics, arm.id)

    @property
    def pose(self) -> Pose:
        """Pose of the robot in the map, as localised."""
        return self.context.cell.group_of(self.params.base).pose(self.context.board.snapshot, self.context.board.guard)

    bumped: tuple[float, float] | None = None
    """In which direction from its heading the base met something, for which the last drive was broken off: (1, 0)
    ahead, (0, 1) to the left; None for nowhere, or where it only turned."""
    seen: Sequence[str] = ()
    """Ids of unknown things that were seen in the way, for which the last drive was broken off."""
    displaced = False
    """Whether the place was seen far from where it is believed to be, for which the last drive was broken off."""

    def leave(self, reason: str) -> None:
        """Places the robot on the floor: it is at no location while it drives."""
        floors = self.world.instances(v.FLOOR)
        placement = self.world.placement(self.params.robot)
        if floors and (placement is None or placement.place != floors[0]):
            with self.world.transaction(author=self.name, reason=reason) as tx:
                tx.place(self.params.robot, v.AT, floors[0])

    def drive(
        self,
        base: Mobile,
        path: Path,
        way: Way,
        *,
        max_linear: float = math.inf,
        max_angular: float = math.inf,
        lookout: Lookout | None = None,
        place: PlaceInSight | None = None,
        arms: TravellingArms | None = None,
    ) -> Execution[float | None]:
        """Follows a path, and waits until the base stands.

        Args:
            base: The base.
            path: The path.
            way: The floor that was granted for it.
            max_linear: Greatest speed [m/s], besides the limit of the base.
            max_angular: Greatest turning speed [rad/s], besides the limit of the base.
            lookout: Tells whether something unknown is in the way; then it stops.
            place: Tells where the robot is relative to the place that it drives to; where that is far from what is
                believed, it stops.
            arms: Arms that move meanwhile; it waits for them where they say so, and stops when one meets something.

        Returns:
            None, or how many legs were driven where the base got stuck.
        """
        follower = base.follow(
            path,
            lambda: self.pose if place is None else place.robot_pose,
            max_linear=max_linear,
            max_angular=max_angular,
        )
        driven, deadline, bumper = -1.0, 0.0, Bumper(self.context, base)
        self.bumped, self.seen, self.displaced = None, [], False
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
                    self.progress(leg, Message("leg {leg} of {legs}", leg=leg, legs=legs))
                driven, deadline = reached, self.context.now + _PATIENCE
            elif self.context.now >= deadline:
                return driven
            way.passed(reached)
            if arms is None or not arms.must_wait():
                base.command(target)
            yield
            pushes, strange = bumper.felt(), self._in_the_way(lookout)
            has_to_stop = self._has_to_stop(place, arms)
            if pushes and not (arms is not None and arms.touched):
                ahead, aside = getattr(target, "linear", 1.0), getattr(target, "sideways", 0.0)
                speed = math.hypot(ahead, aside)
                self.bumped = (ahead / speed, aside / speed) if speed > _TURNING else None
                return driven
            if strange is not None or has_to_stop:
                yield from self.stand(base)
                self.seen = [] if strange is None else believe_seen(self.world, self.name, strange)
                return driven
        yield from self.stand(base)
        return None

    def _in_the_way(self, lookout: Lookout | None) -> Array | None:
        """Returns the points of something unknown in the way, or None; forgets what is not there any more."""
        if lookout is None:
            return None
        is_blocked = lookout.is_blocked()
        if gone := lookout.gone():
            forget(self.world, self.name, gone)
        return lookout.strange if is_blocked else None

    def _has_to_stop(self, place: PlaceInSight | None, arms: TravellingArms | None) -> bool:
        """Returns whether an arm has met something, or the place is seen elsewhere."""
        if place is not None:
            place.look()
            self.displaced = place.is_far_off
        return self.displaced or (arms is not None and arms.touched)

    def stand(self, base: Mobile) -> Execution[None]:
        """Brakes, and waits for localisation to settle."""
        deadline = self.context.now + 5.0
        yield
        while not base.still and self.context.now < deadline:
            yield
        settled = self.context.now + _SETTLED
        while self.context.now < settled:
            yield
