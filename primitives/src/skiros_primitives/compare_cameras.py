"""Compares the cameras that see a kit: the one on the arm with itself from two sides, and each with the others."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from skiros_primitives.arm_moves import refused
from skiros_primitives.camera_check import blame, compare, note_sighting
from skiros_primitives.cameras import seen_within, still_cameras
from skiros_primitives.looking import LookingPrimitive, kit_region
from skiros_py.geometry import Pose
from skiros_py.messages import Message, joined, listed
from skiros_py.ports.motion import NoMotion
from skiros_py.skills.outcome import Failure, Outcome, Success
from skiros_py.skills.parameters import Kind, param
from skiros_py.skills.pictures import Sighting
from skiros_py.skills.primitive import Execution
from skiros_py.skills.surroundings import map_pose
from skiros_py.world import vocabulary as v


class CompareCameras(LookingPrimitive):
    """Looks with the arm's camera from two sides, stows the arm, and looks with the others; says which is off."""

    name: ClassVar[str] = "compare_cameras"

    @dataclass(frozen=True, slots=True)
    class Params:
        """Parameters."""

        arm: str = param(v.ARM, "The arm, which reaches over the kit.", kind=Kind.HARDWARE)
        kit: str = param(v.CONTAINER, "The kit.")

    @property
    def camera(self) -> str:
        """Id of the camera that looks now; at first the one on the arm."""
        own = self.hand_camera
        return self._chosen or ("" if own is None else own.id)

    def execute(self) -> Execution[Outcome]:
        """Looks with each camera, and tells which of them see the kit elsewhere than others."""
        kit, believed = self.params.kit, map_pose(self.context, self.params.kit)
        if believed is None:
            return Failure(Message("the position of {kit} is unknown", kit=kit))
        told, seen = list[Message | None](), dict[str, Sighting]()
        if self.hand_camera is not None:
            first = yield from self._look(kit, believed, from_above=True)
            self._first = first if isinstance(first, Sighting) else None
            second = yield from self._look(kit, believed, from_above=True)
            if not isinstance(first, Sighting) or not isinstance(second, Sighting):
                return next(one for one in (first, second) if not isinstance(one, Sighting))
            told.append(compare(self.context, self.camera, first, second, self.name))
            seen[self.camera] = second
            yield from self.call("move_arm", arm=self.params.arm)  # it hides the kit from others
        for other, _ in still_cameras(self.context, self.arm.spec):
            if seen_within(self.context, other, kit_region(self.context, kit, believed)) is not None:
                self._chosen = other.id
                sighting = yield from self._look(kit, believed)
                seen |= {other.id: sighting} if isinstance(sighting, Sighting) else {}
        differ = {camera: note_sighting(self.context, camera, kit, one, self.name) for camera, one in seen.items()}
        told += (blame(self.context, camera, others, self.name) for camera, others in differ.items())
        if wrong := [one for one in told if one is not None]:
            return Failure(joined("; ", wrong))
        return Success(Message("{cameras} see {kit} in the same place", cameras=listed(seen), kit=kit))

    def _look(self, kit: str, believed: Pose, *, from_above: bool = False) -> Execution[Sighting | Failure]:
        """Returns where a camera sees the kit, from where it is or moved above it."""
        picture = yield from self.look_down(believed.position) if from_above else self.capture()
        if isinstance(picture, NoMotion):
            return refused(picture)
        found = yield from self.find(kit, believed, picture)
        if found.pose is None:
            why = {"kit": kit, "camera": self.camera, "why": found.reason}
            return Failure(Message("{camera} does not recognise {kit} where it should be: {why}", **why))
        return self.sighting(found.pose)
