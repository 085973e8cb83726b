"""Puts what the gripper holds into a compartment and lets go."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

from skiros_primitives.arm_moves import ArmPrimitive
from skiros_primitives.gripper import firm_force, move_fingers
from skiros_primitives.looking import inner_region
from skiros_primitives.part_models import level
from skiros_py.devices.gripper import Gripper
from skiros_py.geometry import Pose
from skiros_py.ports.motion import Held, LineMove, MotionPlan, NoMotion, PoseMove, Route, Trajectory
from skiros_py.skills.outcome import Failure, Outcome, Success
from skiros_py.skills.parameters import Kind, param
from skiros_py.skills.primitive import Execution
from skiros_py.skills.surroundings import held_by, owner
from skiros_py.world.poses import write_pose
from skiros_py.world.vocabulary import (
    ARM,
    CONTAINER,
    GRASP_WIDTH,
    GRIPPER,
    HAS_A,
    MANIPULATABLE,
    ON,
    PLACING_POSE,
    UNKNOWN_LOCATION,
)

_LIFT = 0.12
"""How far above the release the approach starts and the retreat ends [m]."""
_DROP = 0.004
"""Height above the floor at which the part is released [m]."""
_OPEN = 0.016
"""How far the fingers open past the part's width [m]; more could touch the walls."""


class PutDown(ArmPrimitive):
    """Comes from straight above; approach and retreat are both checked before anything moves."""

    name: ClassVar[str] = "put_down"

    @dataclass(frozen=True, slots=True)
    class Params:
        """Parameters."""

        arm: str = param(ARM, "The arm.", kind=Kind.HARDWARE)
        gripper: str = param(GRIPPER, "The gripper on it.", kind=Kind.HARDWARE)
        part: str = param(MANIPULATABLE, "The part it holds.")
        compartment: str = param(CONTAINER, "Where to put it.")

    _retreat: Trajectory | None = None

    def execute(self) -> Execution[Outcome]:
        """Approaches, opens, retreats."""
        holding = held_by(self.context, self.params.gripper)
        if holding is None or holding[0] != self.params.part:
            return Failure(f"{self.params.gripper} does not hold {self.params.part}")
        region = inner_region(self.context, self.params.compartment)
        if isinstance(region, str):
            return Failure(region)
        planned = yield from self.plan(self._routes(region.pose, holding[1]))
        if isinstance(planned, NoMotion):
            return Failure(f"{self.params.compartment} cannot be reached: {planned.reason}")
        return (yield from self._release(planned))

    def _routes(self, floor: Pose, held: Held) -> list[Route]:
        kit = owner(self.world, self.params.compartment, CONTAINER)
        inside = {self.params.part, self.params.compartment, kit or ""} | set(self.world.subjects(HAS_A, kit or ""))
        above = Pose((0.0, 0.0, _LIFT))
        routes: list[Route] = []
        for pose in self._places():
            tool = level(floor @ pose) @ held.pose.inverse()
            high = above @ tool
            down = LineMove(tool, speed=0.20, touching=frozenset(inside))
            routes.append((PoseMove(high), down, LineMove(high, speed=0.20, touching=frozenset(inside))))
        return routes

    def _places(self) -> list[Pose]:
        """Release poses in the compartment: as taught, else in its centre, with sides aligned."""
        placing = self.world.value(self.params.compartment, PLACING_POSE)
        if isinstance(placing, Pose):
            x, y, z = placing.position
            return [Pose((x, y, max(z, _DROP)), placing.orientation)]
        return [Pose.of(0.0, 0.0, _DROP, yaw=quarter * math.pi / 2.0) for quarter in range(4)]

    def _release(self, planned: MotionPlan) -> Execution[Outcome]:
        gripper = Gripper(self.context.board, self.params.gripper)
        width = self.world.value(self.params.part, GRASP_WIDTH)
        approach, down, up = planned.legs
        self.progress(1, "approaching")
        refusal = yield from self.follow(approach)
        if refusal is None:
            self._retreat = up
            refusal = yield from self.follow(down)
        if refusal is not None:
            yield from self.recover()
            return Failure(refusal.reason)
        self.progress(2, "releasing")
        before = gripper.state.gap
        gap = min(self.gripper_spec.max_gap, (width if isinstance(width, float) else before) + _OPEN)
        state = yield from move_fingers(self.context, gripper, gap, firm_force(self.gripper_spec))
        opened = state.gap >= before + 0.5 * _OPEN
        if opened:
            self._write_released()
        self.progress(3, "retreating")
        yield from self.recover()
        if not opened:
            return Failure(f"the fingers did not open: gap {state.gap * 1e3:.0f} mm")
        return Success(f"released over {self.params.compartment}")

    def _write_released(self) -> None:
        """Writes that the part is no longer held; its pose has to be determined by a look."""
        part, compartment = self.params.part, self.params.compartment
        with self.world.transaction(author=self.name, reason=f"released over {compartment}, not seen yet") as tx:
            tx.place(part, ON, self.world.instances(UNKNOWN_LOCATION)[0])
            write_pose(tx, part, None)

    def recover(self) -> Execution[None]:
        """Retracts along the checked line, with anything it still holds."""
        if self._retreat is not None:
            yield from self.follow_from_here(self._retreat)
            self._retreat = None
