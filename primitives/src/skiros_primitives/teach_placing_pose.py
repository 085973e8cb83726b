"""Learns how things are put into a kind of container, from an example."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from skiros_primitives.arm_moves import ArmPrimitive
from skiros_primitives.teaching import keep, other_class
from skiros_py.skills.outcome import Failure, Outcome
from skiros_py.skills.parameters import Kind, param
from skiros_py.skills.primitive import Execution
from skiros_py.skills.surroundings import map_pose
from skiros_py.world.vocabulary import ARM, CONTAINER, GRIPPER, MANIPULATABLE, PLACING_POSE, TAUGHT_PLACING_POSE


class TeachPlacingPose(ArmPrimitive):
    """Learns how to put things into containers of a class from the part's current pose, held or seen."""

    name: ClassVar[str] = "teach_placing_pose"

    @dataclass(frozen=True, slots=True)
    class Params:
        """Parameters."""

        arm: str = param(ARM, "The arm.", kind=Kind.HARDWARE)
        gripper: str = param(GRIPPER, "The gripper on it; it may hold the part.", kind=Kind.HARDWARE)
        part: str = param(MANIPULATABLE, "The part; it is as it should be in the container.")
        container: str = param(CONTAINER, "The container or compartment.")
        type: str | None = param(
            "class", "For which class of containers it counts; left out: its own.", kind=Kind.OPTIONAL, default=None
        )

    def start(self) -> Failure | None:
        """Checks that the container is of that class."""
        return other_class(self.world, self.params.container, self.params.type)

    def execute(self) -> Execution[Outcome]:
        """Stores the part's pose in the container."""
        yield from ()  # it takes no time
        container, part = (map_pose(self.context, one) for one in (self.params.container, self.params.part))
        if container is None or part is None:
            unknown = self.params.container if container is None else self.params.part
            return Failure(f"nobody knows exactly where {unknown} is")
        lesson = TAUGHT_PLACING_POSE, self.params.container, self.params.type
        return keep(self.world, *lesson, {PLACING_POSE: container.inverse() @ part}, author=self.name)
