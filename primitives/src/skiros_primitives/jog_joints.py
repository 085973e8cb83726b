"""Jogs the joints of an arm by a small step, for robot setup."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from skiros_primitives.arm_moves import ArmPrimitive
from skiros_primitives.jogging import even, slip
from skiros_py.ports.motion import JointMove, NoMotion
from skiros_py.skills.outcome import Failure, Outcome, Success
from skiros_py.skills.parameters import Kind, param
from skiros_py.skills.primitive import Execution
from skiros_py.world.vocabulary import ARM

_FARTHEST = 0.2
"""Farthest turn of one joint in one step [rad]."""
_SHOWN = 0.0005
"""Smaller joint motions are not reported [rad]."""
_SPEED = 0.3
"""Fraction of the maximum joint speeds that is used."""
_DETOUR = 0.02
"""How much farther than commanded a joint may turn [rad]: more means a detour around something."""


class JogJoints(ArmPrimitive):
    """Turns the joints of an arm by at most 0.2 rad each, straight and only if nothing is touched."""

    name: ClassVar[str] = "jog_joints"

    @dataclass(frozen=True, slots=True)
    class Params:
        """Parameters."""

        arm: str = param(ARM, "The arm that moves.", kind=Kind.HARDWARE)
        deltas: tuple[float, ...] = param(
            "number", "By how much each joint turns, at most 0.2 rad, in the arm's order.", length=0, unit="rad"
        )

    def start(self) -> Failure | None:
        """Checks that it is a small step of this arm."""
        joints, deltas = self.arm_spec.joints, self.params.deltas
        if len(deltas) != len(joints):
            return Failure(
                f"deltas: {self.params.arm} has {len(joints)} joints ({', '.join(joints)}), not {len(deltas)}"
            )
        worst = max(deltas, key=abs)
        if abs(worst) > _FARTHEST:
            return Failure(f"deltas: one step turns a joint by at most {_FARTHEST:g} rad, not by {worst:g} rad")
        return None

    def execute(self) -> Execution[Outcome]:
        """Moves if the straight path is free."""
        before = self.arm.state.positions
        goal = tuple(position + delta for position, delta in zip(before, self.params.deltas, strict=True))
        if not self.is_planned:
            refusal = yield from self.follow(even(before, goal, self.context.board.period))
        else:
            refusal = yield from self._go(goal)
        if refusal is not None:
            return Failure(f"{self.params.arm} cannot turn so: {refusal.reason}")
        return Success(self._turned())

    def _turned(self) -> str:
        """Describes which joints were turned, and by how much."""
        ways = zip(self.arm_spec.joints, self.params.deltas, strict=True)
        turned = [f"{joint} by {delta:.3f} rad" for joint, delta in ways if abs(delta) >= _SHOWN]
        return f"turned {', '.join(turned)}" if turned else "nothing to turn"

    def _go(self, goal: tuple[float, ...]) -> Execution[NoMotion | None]:
        planned = yield from self.plan([(JointMove(goal),)], speed=_SPEED)
        if isinstance(planned, NoMotion):
            return planned
        ways = [np.abs(np.diff(leg.positions, axis=0)).sum(axis=0) for leg in planned.legs]
        more = np.sum(ways, axis=0) - np.abs(self.params.deltas)
        if more.max() > _DETOUR:
            return NoMotion("something is in the straight way")
        return (yield from slip(self, planned))
