"""Teaching: learns driving poses, grasps and placing poses from an example, and stores them for a class."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from skiros_primitives.arm_moves import ArmPrimitive
from skiros_primitives.part_models import level
from skiros_py.devices.gripper import Gripper
from skiros_py.geometry import Pose
from skiros_py.messages import Message
from skiros_py.ports.board import Mobile
from skiros_py.skills.outcome import Failure, Outcome, Success
from skiros_py.skills.parameters import Kind, param
from skiros_py.skills.primitive import Execution, Primitive
from skiros_py.skills.surroundings import held_by, map_pose
from skiros_py.world import vocabulary as v
from skiros_py.world.element import Value
from skiros_py.world.names import ClassName, local_name


class TeachingPrimitive(Primitive[Any]):
    """Base of the primitives that are shown an example; their parameters have a field ``type``.

    Class attributes:
        example: The parameter that is the example: what is learned counts for its class, or for ``type`` above it.
        lesson: Class of the learned data.
    """

    example: ClassVar[str]
    lesson: ClassVar[ClassName]

    def start(self) -> Failure | None:
        """Checks that the example is of the class."""
        element, type_ = getattr(self.params, self.example), self.params.type
        line = self.world.ontology.ancestors(self.world.element(element).type)
        if type_ is None or type_ in line:
            return None
        return Failure(
            Message(
                "type: {element} is no {kind}; teach it for one of {kinds}",
                element=element,
                kind=type_,
                kinds=", ".join(line),
            )
        )

    def keep(self, values: Mapping[str, Value]) -> Outcome:
        """Stores the shown values, by property, for all things of the class."""
        element, world = getattr(self.params, self.example), self.world
        class_ = self.params.type or world.element(element).type
        label = f"{world.ontology.classes[self.lesson].label.removeprefix('taught ')} for {local_name(class_)}"
        with world.transaction(author=self.name, reason=Message("shown on {element}", element=element)) as tx:
            learned = tx.add(self.lesson, label, properties={v.APPLIES_TO: class_, **values}, learned=True)
        return Success(Message("learned as {learned}: {label}", learned=learned, label=label))


class TeachDrivingPose(TeachingPrimitive):
    """Learns where to stand at places of a class: the current base pose relative to one of them."""

    name: ClassVar[str] = "teach_driving_pose"
    example: ClassVar[str] = "location"
    lesson: ClassVar[ClassName] = v.TAUGHT_DRIVING_POSE

    @dataclass(frozen=True, slots=True)
    class Params:
        """Parameters."""

        base: str = param(v.BASE, "The base; it stands as it should.", kind=Kind.HARDWARE)
        location: str = param(v.LOCATION, "The place at which it stands.")
        type: str | None = param(
            "class", "For which class of places it counts; left out: that of the place.", kind=Kind.OPTIONAL
        )

    def execute(self) -> Execution[Outcome]:
        """Stores the base pose."""
        yield from ()
        place, base = map_pose(self.context, self.params.location), Mobile(self.context.board, self.params.base)
        if place is None:
            return Failure(Message("the position of {location} is unknown", location=self.params.location))
        if not base.still:
            return Failure(Message("{base} still moves: let it stand where it should", base=self.params.base))
        pose = self.context.cell.group_of(base.id).pose(self.context.board.snapshot, self.context.board.guard)
        return self.keep({v.DRIVING_POSE: place.inverse() @ pose})


_OPEN = 0.002
"""Fingers less than this from fully open hold nothing [m]."""


class TeachGrasp(TeachingPrimitive, ArmPrimitive):
    """Learns how to grasp parts of a class from the current grasp of one of them."""

    name: ClassVar[str] = "teach_grasp"
    example: ClassVar[str] = "part"
    lesson: ClassVar[ClassName] = v.TAUGHT_GRASP

    @dataclass(frozen=True, slots=True)
    class Params:
        """Parameters."""

        arm: str = param(v.ARM, "The arm; it stands as it should.", kind=Kind.HARDWARE)
        gripper: str = param(v.GRIPPER, "The gripper on it; it is closed on the part.", kind=Kind.HARDWARE)
        part: str = param(v.MANIPULATABLE, "The part between the fingers.")
        type: str | None = param(
            "class", "For which class of parts it counts; left out: that of the part.", kind=Kind.OPTIONAL
        )

    def execute(self) -> Execution[Outcome]:
        """Stores the tool pose on the part, and the finger gap."""
        yield from ()  # it takes no time
        tool = self._tool_on_part()
        if tool is None:
            return Failure(Message("the exact position of {part} is unknown: register it first", part=self.params.part))
        gap = Gripper(self.context.board, self.params.gripper).state.gap
        if gap > self.gripper_spec.max_gap - _OPEN:
            return Failure(
                Message(
                    "{gripper} is wide open: close it on {part}", gripper=self.params.gripper, part=self.params.part
                )
            )
        return self.keep({v.GRASP_POSE: tool, v.GRASP_WIDTH: gap})

    def _tool_on_part(self) -> Pose | None:
        holding = held_by(self.context, self.params.gripper)
        if holding is not None and holding[0] == self.params.part:
            return holding[1].pose.inverse()
        part = map_pose(self.context, self.params.part)
        if part is None:
            return None
        return level(part).inverse() @ self.tool_pose()


class TeachPlacingPose(TeachingPrimitive):
    """Learns how to put things into containers of a class from the part's current pose, held or seen."""

    name: ClassVar[str] = "teach_placing_pose"
    example: ClassVar[str] = "container"
    lesson: ClassVar[ClassName] = v.TAUGHT_PLACING_POSE

    @dataclass(frozen=True, slots=True)
    class Params:
        """Parameters."""

        arm: str = param(v.ARM, "The arm.", kind=Kind.HARDWARE)
        gripper: str = param(v.GRIPPER, "The gripper on it; it may hold the part.", kind=Kind.HARDWARE)
        part: str = param(v.MANIPULATABLE, "The part; it is as it should be in the container.")
        container: str = param(v.CONTAINER, "The container or compartment.")
        type: str | None = param(
            "class", "For which class of containers it counts; left out: its own.", kind=Kind.OPTIONAL
        )

    def execute(self) -> Execution[Outcome]:
        """Stores the part's pose in the container."""
        yield from ()  # it takes no time
        container, part = (map_pose(self.context, one) for one in (self.params.container, self.params.part))
        if container is None or part is None:
            unknown = self.params.container if container is None else self.params.part
            return Failure(Message("the exact position of {unknown} is unknown", unknown=unknown))
        return self.keep({v.PLACING_POSE: container.inverse() @ part})
