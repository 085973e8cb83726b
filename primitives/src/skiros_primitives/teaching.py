"""Teaching: learns driving poses, grasps and placing poses from an example, and stores them for a class."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from skiros_primitives.arm_moves import ArmPrimitive
from skiros_primitives.part_models import level
from skiros_py.devices.gripper import Gripper
from skiros_py.geometry import Pose
from skiros_py.ports.board import Mobile
from skiros_py.skills.outcome import Failure, Outcome, Success
from skiros_py.skills.parameters import Kind, param
from skiros_py.skills.primitive import Execution, Primitive
from skiros_py.skills.surroundings import held_by, map_pose
from skiros_py.world.element import Value
from skiros_py.world.names import ClassName, local_name
from skiros_py.world.vocabulary import (
    APPLIES_TO,
    ARM,
    BASE,
    CONTAINER,
    DRIVING_POSE,
    GRASP_POSE,
    GRASP_WIDTH,
    GRIPPER,
    LOCATION,
    MANIPULATABLE,
    PLACING_POSE,
    TAUGHT_DRIVING_POSE,
    TAUGHT_GRASP,
    TAUGHT_PLACING_POSE,
)
from skiros_py.world.world import World


def other_class(world: World, element: str, type_: str | None) -> Failure | None:
    """Returns why an element cannot serve as an example for a class: it must be of that class."""
    line = world.ontology.ancestors(world.element(element).type)
    if type_ is None or type_ in line:
        return None
    return Failure(f"type: {element} is no {type_}; teach it for one of {', '.join(line)}")


def keep(
    world: World, lesson: ClassName, element: str, type_: str | None, values: Mapping[str, Value], *, author: str
) -> Outcome:
    """Stores data shown on one element for all things of its class.

    Args:
        world: The world.
        lesson: Class of the learned data.
        element: The example element.
        type_: The class it applies to; by default, that of the element.
        values: The shown values, by property.
        author: Who was taught.
    """
    class_ = type_ or world.element(element).type
    label = f"{world.ontology.classes[lesson].label.removeprefix('taught ')} for {local_name(class_)}"
    with world.transaction(author=author, reason=f"shown on {element}") as tx:
        learned = tx.add(lesson, label, properties={APPLIES_TO: class_, **values}, learned=True)
    return Success(f"learned as {learned}: {label}")


class TeachDrivingPose(Primitive["TeachDrivingPose.Params"]):
    """Learns where to stand at places of a class: the current base pose relative to one of them."""

    name: ClassVar[str] = "teach_driving_pose"

    @dataclass(frozen=True, slots=True)
    class Params:
        """Parameters."""

        base: str = param(BASE, "The base; it stands as it should.", kind=Kind.HARDWARE)
        location: str = param(LOCATION, "The place at which it stands.")
        type: str | None = param(
            "class",
            "For which class of places it counts; left out: that of the place.",
            kind=Kind.OPTIONAL,
            default=None,
        )

    def start(self) -> Failure | None:
        """Checks that the place is of that class."""
        return other_class(self.world, self.params.location, self.params.type)

    def execute(self) -> Execution[Outcome]:
        """Stores the base pose."""
        yield from ()
        place, base = map_pose(self.context, self.params.location), Mobile(self.context.board, self.params.base)
        if place is None:
            return Failure(f"the position of {self.params.location} is unknown")
        if not base.still:
            return Failure(f"{self.params.base} still moves: let it stand where it should")
        pose = self.context.cell.group_of(base.id).pose(self.context.board.snapshot, self.context.board.guard)
        lesson = TAUGHT_DRIVING_POSE, self.params.location, self.params.type
        return keep(self.world, *lesson, {DRIVING_POSE: place.inverse() @ pose}, author=self.name)


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
            return Failure(f"the exact position of {self.params.part} is unknown: register it first")
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
            return Failure(f"the exact position of {unknown} is unknown")
        lesson = TAUGHT_PLACING_POSE, self.params.container, self.params.type
        return keep(self.world, *lesson, {PLACING_POSE: container.inverse() @ part}, author=self.name)
