"""Learns how to grasp a kind of part from the current grasp."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from skiros_primitives.arm_moves import ArmPrimitive
from skiros_primitives.poses import level
from skiros_primitives.teaching import keep, other_class
from skiros_py.devices.gripper import Gripper
from skiros_py.geometry import Pose
from skiros_py.skills.outcome import Failure, Outcome
from skiros_py.skills.parameters import Kind, param
from skiros_py.skills.primitive import Execution
from skiros_py.skills.surroundings import held_by, map_pose
from skiros_py.world.vocabulary import ARM, GRASP_POSE, GRASP_WIDTH, GRIPPER, MANIPULATABLE, TAUGHT_GRASP

_OPEN = 0.002
"""Fingers less than this from fully open hold nothing [m]."""


class TeachGrasp(ArmPrimitive):
    """Learns how to grasp parts of a class from the current grasp of one of them."""

    name: ClassVar[str] = "teach_grasp"

    @dataclass(frozen=True, slots=True)
    class Params:
        """Parameters."""

        arm: str = param(ARM, "The arm; it stands as it should.", kind=Kind.HARDWARE)
        gripper: str = param(GRIPPER, "The gripper on it; it is closed on the part.", kind=Kind.HARDWARE)
        part: str = param(MANIPULATABLE, "The part between the fingers.")
        type: str | None = param(
            "class", "For which class of parts it counts; left out: that of the part.", kind=Kind.OPTIONAL, default=None
        )

    def start(self) -> Failure | None:
        """Checks that the part is of that class."""
        return other_class(self.world, self.params.part, self.params.type)

    def execute(self) -> Execution[Outcome]:
        """Stores the tool pose on the part, and the finger gap."""
        yield from ()  # it takes no time
        tool = self._tool_on_part()
        if tool is None:
            return Failure(f"nobody knows exactly where {self.params.part} is: register it first")
        gap = Gripper(self.context.board, self.params.gripper).state.gap
        if gap > self.gripper_spec.max_gap - _OPEN:
            return Failure(f"{self.params.gripper} is wide open: close it on {self.params.part}")
        lesson = TAUGHT_GRASP, self.params.part, self.params.type
        return keep(self.world, *lesson, {GRASP_POSE: tool, GRASP_WIDTH: gap}, author=self.name)

    def _tool_on_part(self) -> Pose | None:
        holding = held_by(self.context, self.params.gripper)
        if holding is not None and holding[0] == self.params.part:
            return holding[1].pose.inverse()
        part = map_pose(self.context, self.params.part)
        if part is None:
            return None
        return level(part).inverse() @ self.tool_pose()
