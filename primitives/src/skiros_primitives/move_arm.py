"""Moves an arm to its travelling posture."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from skiros_primitives.arm_moves import ArmPrimitive
from skiros_primitives.jogging import even
from skiros_py.ports.motion import JointMove
from skiros_py.skills.outcome import Failure, Outcome, Success
from skiros_py.skills.parameters import Kind, param
from skiros_py.skills.primitive import Execution
from skiros_py.world.vocabulary import ARM


class MoveArm(ArmPrimitive):
    """Moves around obstacles, with whatever is held."""

    name: ClassVar[str] = "move_arm"

    @dataclass(frozen=True, slots=True)
    class Params:
        """Parameters."""

        arm: str = param(ARM, "The arm that moves.", kind=Kind.HARDWARE)

    def execute(self) -> Execution[Outcome]:
        """Plans and moves."""
        home = self.arm_spec.home
        if not self.is_planned:
            refusal = yield from self.follow(even(self.arm.state.positions, home, self.context.board.period))
        else:
            refusal = yield from self.go([(JointMove(home),)])
        if refusal is not None:
            return Failure(f"the arm cannot go home: {refusal.reason}")
        return Success("home")
