"""Learns the driving pose for a kind of place from the current base pose."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from skiros_primitives.teaching import keep, other_class
from skiros_py.devices.base import Base
from skiros_py.skills.outcome import Failure, Outcome
from skiros_py.skills.parameters import Kind, param
from skiros_py.skills.primitive import Execution, Primitive
from skiros_py.skills.surroundings import map_pose
from skiros_py.world.vocabulary import BASE, DRIVING_POSE, LOCATION, TAUGHT_DRIVING_POSE


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
        place, base = map_pose(self.context, self.params.location), Base(self.context.board, self.params.base)
        if place is None:
            return Failure(f"nobody knows where {self.params.location} is")
        if not base.state.still:
            return Failure(f"{self.params.base} still moves: let it stand where it should")
        lesson = TAUGHT_DRIVING_POSE, self.params.location, self.params.type
        return keep(self.world, *lesson, {DRIVING_POSE: place.inverse() @ base.state.pose}, author=self.name)
