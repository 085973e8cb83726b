"""Looks again from straight above one part, to get its exact pose and confirm its type."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from skiros_primitives.looking import LookingPrimitive
from skiros_py.geometry import Pose
from skiros_py.ports.motion import NoMotion
from skiros_py.ports.perception import Detection, Region
from skiros_py.skills.outcome import Failure, Outcome, Success
from skiros_py.skills.parameters import Kind, param
from skiros_py.skills.primitive import Execution
from skiros_py.skills.surroundings import map_pose, set_pose
from skiros_py.world.vocabulary import ARM, CAMERA, MANIPULATABLE

_NEAR = 0.05
"""The part seen may lie at most this far from where the first look saw it [m]."""
_HALF = 0.10
"""Half the side length of the searched square [m]."""


class RegisterPart(LookingPrimitive):
    """The second look, with the camera exactly above the part: nothing hides its far side."""

    name: ClassVar[str] = "register_part"

    @dataclass(frozen=True, slots=True)
    class Params:
        """Parameters."""

        arm: str = param(ARM, "The arm that carries the camera.", kind=Kind.HARDWARE)
        camera: str = param(CAMERA, "The camera to look with.", kind=Kind.HARDWARE)
        part: str = param(MANIPULATABLE, "The part; a first look has seen it.")

    def execute(self) -> Execution[Outcome]:
        """Looks, and corrects the believed pose."""
        believed = map_pose(self.context, self.params.part)
        if believed is None:
            return Failure(f"{self.params.part} has not been seen yet")
        x, y, _ = believed.position
        look = yield from self.look_for_parts(Region(Pose(believed.position), (_HALF, _HALF)), x, y)
        if isinstance(look, NoMotion):
            return Failure(look.reason)
        nearest = min(look.detections, key=lambda d: d.pose.distance(believed), default=None)
        return self._judge(nearest, believed)

    def _judge(self, nearest: Detection | None, believed: Pose) -> Outcome:
        part = self.params.part
        wanted = self.world.element(part).type
        if nearest is None or nearest.pose.distance(believed) > _NEAR:
            return self._forget(f"{part} is not where the first look saw it")
        if nearest.type != wanted:
            what = nearest.type.partition(":")[2] if nearest.type else "something of unknown shape"
            return self._forget(f"what lies where {part} was seen is {what}")
        with self.world.transaction(author=self.name, reason=f"cost {nearest.cost * 1e3:.1f} mm") as tx:
            set_pose(tx, self.world, part, nearest.pose)
        return Success(f"{part} at ({nearest.pose.position[0]:.3f}, {nearest.pose.position[1]:.3f})")

    def _forget(self, reason: str) -> Failure:
        with self.world.transaction(author=self.name, reason=reason) as tx:
            set_pose(tx, self.world, self.params.part, None)
        return Failure(reason)
