"""Learns where a base stands to work at a kind of place: where it stands now."""

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
    """Learns where to stand at places of a class: where the base stands now, seen from one of them."""

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
        """Looks whether the place is one of those."""
        return other_class(self.world, self.params.location, self.params.type)

    def execute(self) -> Execution[Outcome]:
        """Writes down where the base stands."""
        yield from ()
        place, base = map_pose(self.context, self.params.location), Base(self.context.board, self.params.base)
        if place is None:
            return Failure(f"nobody knows where {self.params.location} is")
        if not base.state.still:
            return Failure(f"{self.params.base} still moves: let it stand where it should")
        lesson = TAUGHT_DRIVING_POSE, self.params.location, self.params.type
        return keep(self.world, *lesson, {DRIVING_POSE: place.inverse() @ base.state.pose}, author=self.name)
