"""Looks at a kit and corrects its believed pose before something is put into it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from skiros_primitives.looking import LookingPrimitive
from skiros_py.errors import DeviceError
from skiros_py.geometry import Pose
from skiros_py.ports.motion import NoMotion
from skiros_py.ports.perception import Registrar, RegistrationRequest, RegistrationResult
from skiros_py.skills.outcome import Failure, Outcome, Success
from skiros_py.skills.parameters import Kind, param
from skiros_py.skills.primitive import Execution
from skiros_py.skills.surroundings import map_pose, set_pose, solid_of
from skiros_py.world.vocabulary import ARM, CAMERA, CONTAINER, POSE_FRAME

_ASIDE = (0.0, 0.06, 0.09)
"""How far the tool is retracted for each look [m]: a held part may hide the kit."""


class RegisterKit(LookingPrimitive):
    """Fits the kit's walls to the camera image; a bad fit gives a failure, not a pose."""

    name: ClassVar[str] = "register_kit"

    @dataclass(frozen=True, slots=True)
    class Params:
        """Parameters."""

        arm: str = param(ARM, "The arm that carries the camera.", kind=Kind.HARDWARE)
        camera: str = param(CAMERA, "The camera to look with.", kind=Kind.HARDWARE)
        kit: str = param(CONTAINER, "The kit.")

    def execute(self) -> Execution[Outcome]:
        """Looks, and corrects the believed pose."""
        believed = map_pose(self.context, self.params.kit)
        if believed is None:
            return Failure(f"nobody said where {self.params.kit} is")
        why = ""
        for attempt, aside in enumerate(_ASIDE, start=1):
            self.progress(attempt, f"look {attempt} at {self.params.kit}")
            result = yield from self._look(believed, aside)
            if isinstance(result, RegistrationResult) and result.pose is not None:
                self._write(result.pose, result.cost)
                moved = result.pose.distance(believed) * 1e3
                return Success(f"{self.params.kit} is {moved:.0f} mm from where it was believed")
            why = why or result.reason
        return Failure(f"{self.params.kit} is not recognised where it should be: {why}")

    def _look(self, believed: Pose, aside: float) -> Execution[RegistrationResult | NoMotion]:
        camera, solid = self.camera_spec(self.params.camera), solid_of(self.world, self.params.kit)
        registrar = self.context.port(Registrar, camera.id)
        if solid is None:
            raise DeviceError(f"register_kit needs a shape of {self.params.kit}")
        image = yield from self.look_down(camera, *believed.position, aside=aside)
        if isinstance(image, NoMotion):
            return image
        pose = self.camera_pose(camera, image)
        request = RegistrationRequest(image, pose, solid, believed, self.seed(), camera.id, self.params.kit)
        return (yield from self.wait(registrar.register(request)))

    def _write(self, pose: Pose, cost: float) -> None:
        kit = self.params.kit
        frame = next(iter(self.world.objects(kit, POSE_FRAME)), None)
        in_map = map_pose(self.context, frame) if frame else None
        own = in_map.inverse() @ pose if in_map is not None else pose
        with self.world.transaction(author=self.name, reason=f"fitted within {cost * 1e3:.1f} mm") as tx:
            set_pose(tx, self.world, kit, own, frame)
