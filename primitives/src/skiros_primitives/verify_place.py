"""Looks into a compartment after something was put there, and writes the result."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from skiros_primitives.looking import LookingPrimitive
from skiros_primitives.regions import inner_region
from skiros_py.ports.motion import NoMotion
from skiros_py.ports.perception import Detection, LookResult
from skiros_py.skills.outcome import Failure, Outcome, Success
from skiros_py.skills.parameters import Kind, param
from skiros_py.skills.primitive import Execution
from skiros_py.skills.surroundings import set_pose
from skiros_py.world.vocabulary import ARM, CAMERA, CONTAINER, IN, MANIPULATABLE, MISSING, ON, UNKNOWN_LOCATION

_LOOKS = 2


class VerifyPlace(LookingPrimitive):
    """Only parts seen in the compartment are believed to be in it."""

    name: ClassVar[str] = "verify_place"

    @dataclass(frozen=True, slots=True)
    class Params:
        """Parameters."""

        arm: str = param(ARM, "The arm that carries the camera.", kind=Kind.HARDWARE)
        camera: str = param(CAMERA, "The camera to look with.", kind=Kind.HARDWARE)
        part: str = param(MANIPULATABLE, "The part that was put down.")
        compartment: str = param(CONTAINER, "Where it should be.")

    def execute(self) -> Execution[Outcome]:
        """Looks, at most twice."""
        region = inner_region(self.context, self.params.compartment)
        if isinstance(region, str):
            return Failure(region)
        strange = False
        for attempt in range(_LOOKS):
            x, y, _ = region.pose.position
            look = yield from self.look_for_parts(region, x + 0.03 * attempt, y)
            if isinstance(look, NoMotion):
                return Failure(look.reason)
            seen = self._find(look)
            if seen is not None:
                return self._confirm(seen)
            strange = any(d.type is None for d in look.detections)
        return self._deny(strange=strange)

    def _find(self, look: LookResult) -> Detection | None:
        wanted = self.world.element(self.params.part).type
        return next((d for d in look.detections if d.type == wanted), None)

    def _confirm(self, seen: Detection) -> Outcome:
        part, compartment = self.params.part, self.params.compartment
        with self.world.transaction(author=self.name, reason=f"seen in {compartment}") as tx:
            tx.place(part, IN, compartment)
            tx.set(part, MISSING, None)
            set_pose(tx, self.world, part, seen.pose)
        return Success(f"{part} is in {compartment}")

    def _deny(self, *, strange: bool) -> Outcome:
        part, compartment = self.params.part, self.params.compartment
        what = "something of unknown shape" if strange else "nothing of its kind"
        with self.world.transaction(author=self.name, reason=f"{what} seen in {compartment}") as tx:
            set_pose(tx, self.world, part, None)
            tx.set(part, MISSING, True)
            tx.place(part, ON, self.world.instances(UNKNOWN_LOCATION)[0])
        return Failure(f"{part} was released over {compartment}, but {what} is seen there")
