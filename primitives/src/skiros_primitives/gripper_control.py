"""Opens or closes a gripper."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from skiros_primitives.fingers import firm_force, move_fingers
from skiros_py.devices.gripper import Gripper
from skiros_py.skills.outcome import Outcome, Success
from skiros_py.skills.parameters import Kind, param
from skiros_py.skills.primitive import Execution, Primitive
from skiros_py.world.vocabulary import GRIPPER


class GripperControl(Primitive["GripperControl.Params"]):
    """Moves the fingers to a gap and waits until they stand."""

    name: ClassVar[str] = "gripper_control"

    @dataclass(frozen=True, slots=True)
    class Params:
        """Parameters."""

        gripper: str = param(GRIPPER, "The gripper.", kind=Kind.HARDWARE)
        gap: float | None = param(
            "number", "Wanted gap between the pads; left out: wide open.", kind=Kind.OPTIONAL, default=None, unit="m"
        )
        force: float | None = param(
            "number",
            "Greatest force per finger; left out: as parts are held.",
            kind=Kind.OPTIONAL,
            default=None,
            unit="N",
        )

    def execute(self) -> Execution[Outcome]:
        """Moves the fingers."""
        gripper = Gripper(self.context.board, self.params.gripper)
        spec = gripper.spec
        gap = spec.max_gap if self.params.gap is None else self.params.gap
        force = firm_force(spec) if self.params.force is None else self.params.force
        state = yield from move_fingers(self.context, gripper, gap, force)
        return Success(f"gap {state.gap * 1e3:.0f} mm")
