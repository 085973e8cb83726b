"""Puts what the gripper holds into a compartment and lets go."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

from skiros_primitives.arm_moves import HandlingPrimitive
from skiros_primitives.gripper import firm_force, move_fingers
from skiros_primitives.looking import inner_region
from skiros_primitives.part_models import level
from skiros_py.geometry import Pose
from skiros_py.messages import Message
from skiros_py.ports.motion import MotionPlan, NoMotion
from skiros_py.skills.outcome import Failure, Outcome, Success
from skiros_py.skills.parameters import Kind, param
from skiros_py.skills.primitive import Execution
from skiros_py.skills.surroundings import held_by, owner
from skiros_py.world import vocabulary as v
from skiros_py.world.poses import write_pose

_DROP = 0.004
"""Height above the floor at which the part is released [m]."""
_LANDING = 0.012
"""How far above this a part that has met something stands on the floor already [m]."""
_OPEN = 0.016
"""How far the fingers open past the part's width [m]; more could touch the walls."""


class PutDown(HandlingPrimitive):
    """Comes from straight above; approach and retreat are both checked before anything moves."""

    name: ClassVar[str] = "put_down"

    @dataclass(frozen=True, slots=True)
    class Params:
        """Parameters."""

        arm: str = param(v.ARM, "The arm.", kind=Kind.HARDWARE)
        gripper: str = param(v.GRIPPER, "The gripper on it.", kind=Kind.HARDWARE)
        part: str = param(v.MANIPULATABLE, "The part it holds.")
        compartment: str = param(v.CONTAINER, "Where to put it.")

    def execute(self) -> Execution[Outcome]:
        """Approaches, opens, retreats."""
        holding = held_by(self.context, self.params.gripper)
        if holding is None or holding[0] != self.params.part:
            return Failure(
                Message("{gripper} does not hold {part}", gripper=self.params.gripper, part=self.params.part)
            )
        region = inner_region(self.context, self.params.compartment)
        if isinstance(region, str):
            return Failure(region)
        kit = owner(self.world, self.params.compartment, v.CONTAINER) or ""
        inside = {self.params.part, self.params.compartment, kit, *self.world.subjects(v.HAS_A, kit)}
        tools = (level(region.pose @ pose) @ holding[1].pose.inverse() for pose in self._places())
        planned = yield from self.plan(self.routes(tools, inside))
        if isinstance(planned, NoMotion):
            return Failure(
                Message(
                    "{compartment} cannot be reached: {reason}",
                    compartment=self.params.compartment,
                    reason=planned.reason,
                )
            )
        return (yield from self._release(planned))

    def _places(self) -> list[Pose]:
        """Release poses in the compartment: as taught, else in its centre, with sides aligned."""
        placing = self.world.value(self.params.compartment, v.PLACING_POSE)
        if isinstance(placing, Pose):
            x, y, z = placing.position
            return [Pose((x, y, max(z, _DROP)), placing.orientation)]
        return [Pose.of(0.0, 0.0, _DROP, yaw=quarter * math.pi / 2.0) for quarter in range(4)]

    def _release(self, planned: MotionPlan) -> Execution[Outcome]:
        gripper, width = self.gripper, self.world.value(self.params.part, v.GRASP_WIDTH)
        refusal = yield from self.come_down(planned, landing=_LANDING)
        if refusal is not None:
            return Failure(refusal.reason)
        self.progress(2, Message("releasing"))
        before = gripper.state.gap
        gap = min(self.gripper_spec.max_gap, (width if isinstance(width, float) else before) + _OPEN)
        state = yield from move_fingers(self.context, gripper, gap, firm_force(self.gripper_spec))
        opened = state.gap >= before + 0.5 * _OPEN
        if opened:
            part, compartment = self.params.part, self.params.compartment
            reason = Message("released over {compartment}, not seen yet", compartment=compartment)
            with self.world.transaction(author=self.name, reason=reason) as tx:
                tx.place(part, v.MAY_BE_IN, compartment)
                write_pose(tx, part, None)  # a look has to determine it
        self.progress(3, Message("retreating"))
        yield from self.recover()
        if not opened:
            return Failure(Message("the fingers did not open: gap {gap:.0f} mm", gap=state.gap * 1000.0))
        return Success(Message("released over {compartment}", compartment=self.params.compartment))

    def recover(self) -> Execution[None]:
        """Retracts along the checked line, with anything it still holds."""
        if self.retreat is not None:
            yield from self.follow_from_here(self.retreat, expected=self.weight(self.params.part))
            self.retreat = None
