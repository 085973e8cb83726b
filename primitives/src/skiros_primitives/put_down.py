"""Puts what the gripper holds into a compartment, or back onto a storage place, and lets go."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import product
from typing import ClassVar

from skiros_primitives.arm_moves import HandlingPrimitive
from skiros_primitives.gripper import firm_force, move_fingers
from skiros_primitives.looking import inner_region, support_region
from skiros_primitives.part_models import level
from skiros_py.geometry import Pose
from skiros_py.messages import Message
from skiros_py.ports.motion import MotionPlan, NoMotion
from skiros_py.ports.perception import Region
from skiros_py.skills.outcome import Failure, Outcome, Success
from skiros_py.skills.parameters import Kind, param
from skiros_py.skills.primitive import Execution
from skiros_py.skills.surroundings import held_by, map_pose, owner
from skiros_py.world import vocabulary as v
from skiros_py.world.element import Placement
from skiros_py.world.poses import write_pose

_DROP = 0.004
"""Height above the floor at which the part is released [m]."""
_LANDING = 0.012
"""How far above this a part that has met something stands on the floor already [m]."""
_OPEN = 0.016
"""How far the fingers open past the part's width [m]; more could touch the walls."""


@dataclass(frozen=True, slots=True)
class PuttingParams:
    """Parameters of every primitive that puts something down."""

    arm: str = param(v.ARM, "The arm.", kind=Kind.HARDWARE)
    gripper: str = param(v.GRIPPER, "The gripper on it.", kind=Kind.HARDWARE)
    part: str = param(v.MANIPULATABLE, "The part it holds.")


class PuttingPrimitive(HandlingPrimitive):
    """Base of the primitives that put something down; their parameters are :class:`PuttingParams` and more."""

    def put(
        self, poses: Sequence[Pose], place: str, touching: Iterable[str], believed: Placement
    ) -> Execution[Outcome]:
        """Approaches, opens, retreats.

        Args:
            poses: Where the part may be released, in the map.
            place: Where that is.
            touching: Ids of what may be touched there.
            believed: Where the part is believed to be once it was released; no look has shown it yet.
        """
        holding = held_by(self.context, self.params.gripper)
        if holding is None or holding[0] != self.params.part:
            return Failure(
                Message("{gripper} does not hold {part}", gripper=self.params.gripper, part=self.params.part)
            )
        sits = holding[1].pose.inverse()
        chosen, planned = yield from self.plan_fresh("place", [level(pose) @ sits for pose in poses], touching)
        if isinstance(planned, NoMotion):
            reason = Message("{place} cannot be reached: {reason}", place=place, reason=planned.reason)
            return Failure(reason, values=planned.values)
        outcome = yield from self._release(planned, place, believed)
        if isinstance(outcome, Failure):
            turn = math.degrees(poses[chosen].yaw)
            self.context.tried.note("place", chosen, Message("put down turned by {turn:.0f} deg", turn=turn))
        return outcome

    def _release(self, planned: MotionPlan, place: str, believed: Placement) -> Execution[Outcome]:
        gripper, width = self.gripper, self.world.value(self.params.part, v.GRASP_WIDTH)
        refusal = yield from self.come_down(planned, landing=_LANDING)
        if refusal is not None:
            return Failure(refusal.reason, values=refusal.values)
        self.progress(2, Message("releasing"))
        before = gripper.state.gap
        gap = min(self.gripper_spec.max_gap, (width if isinstance(width, float) else before) + _OPEN)
        state = yield from move_fingers(self.context, gripper, gap, firm_force(self.gripper_spec))
        opened = state.gap >= before + 0.5 * _OPEN
        if opened:
            reason = Message("released over {place}, not seen yet", place=place)
            with self.world.transaction(author=self.name, reason=reason) as tx:
                tx.place(self.params.part, believed.relation, believed.place)
                write_pose(tx, self.params.part, None)  # a look has to determine it
        self.progress(3, Message("retreating"))
        yield from self.recover()
        if not opened:
            return Failure(Message("the fingers did not open: gap {gap:.0f} mm", gap=state.gap * 1000.0))
        return Success(Message("released over {place}", place=place))

    def recover(self) -> Execution[None]:
        """Retracts along the checked line, with anything it still holds."""
        if self.retreat is not None:
            yield from self.follow_from_here(self.retreat, expected=self.weight(self.params.part))
            self.retreat = None


class PutDown(PuttingPrimitive):
    """Comes from straight above; approach and retreat are both checked before anything moves."""

    name: ClassVar[str] = "put_down"

    @dataclass(frozen=True, slots=True)
    class Params(PuttingParams):
        """Parameters."""

        compartment: str = param(v.CONTAINER, "Where to put it.")

    def execute(self) -> Execution[Outcome]:
        """Puts it into the compartment."""
        region, compartment = inner_region(self.context, self.params.compartment), self.params.compartment
        if isinstance(region, str):
            return Failure(region)
        kit = owner(self.world, compartment, v.CONTAINER) or ""
        inside = {self.params.part, compartment, kit, *self.world.subjects(v.HAS_A, kit)}
        poses = [region.pose @ pose for pose in self._places()]
        return (yield from self.put(poses, compartment, inside, Placement(v.MAY_BE_IN, compartment)))

    def _places(self) -> list[Pose]:
        """Release poses in the compartment: as taught, else in its centre, with sides aligned."""
        placing = self.world.value(self.params.compartment, v.PLACING_POSE)
        if isinstance(placing, Pose):
            x, y, z = placing.position
            return [Pose((x, y, max(z, _DROP)), placing.orientation)]
        return [Pose.of(0.0, 0.0, _DROP, yaw=quarter * math.pi / 2.0) for quarter in range(4)]


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

        place: str = param(v.CONTAINER, "Where to put it.")

    def execute(self) -> Execution[Outcome]:
        """Puts it back; that it lies there is believed until a look shows something else."""
        region = support_region(self.context, self.params.place)
        if isinstance(region, str):
            return Failure(region)
        spots = self._free(region)
        if not spots:
            return Failure(Message("there is no free spot on {place}", place=self.params.place))
        back = Placement(v.IN, self.params.place)
        return (yield from self.put(spots, self.params.place, {self.params.part, self.params.place}, back))

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
