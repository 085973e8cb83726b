"""Looks from straight above: at a part or a kit for its exact pose, into a compartment for its content."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from itertools import product
from typing import ClassVar

from skiros_primitives.arm_moves import ArmPrimitive
from skiros_primitives.part_models import downward, part_models
from skiros_py.devices.camera import CameraSpec
from skiros_py.errors import DeviceError
from skiros_py.geometry import Pose, Solid
from skiros_py.messages import Message
from skiros_py.ports.motion import SHARES, MotionPlan, NoMotion, PoseMove
from skiros_py.ports.perception import (
    Detection,
    DetectionRequest,
    DetectionResult,
    PartDetector,
    Region,
    Registrar,
    RegistrationRequest,
    RegistrationResult,
)
from skiros_py.ports.values import DepthImage
from skiros_py.skills.context import RunContext
from skiros_py.skills.outcome import Failure, Outcome, Success
from skiros_py.skills.parameters import Kind, param
from skiros_py.skills.primitive import Execution
from skiros_py.skills.surroundings import held_by, map_pose, solid_of
from skiros_py.world import vocabulary as v
from skiros_py.world.element import Placement
from skiros_py.world.poses import write_pose


def support_region(context: RunContext, place: str) -> Region | str:
    """Returns the support area of a storage place in the map, or why there is none."""
    pose = map_pose(context, place)
    half, offset = context.world.value(place, v.SUPPORT_HALF_EXTENTS), context.world.value(place, v.SUPPORT_OFFSET)
    if pose is None or not isinstance(half, tuple) or not isinstance(offset, tuple):
        return Message("{place} has no pose or no support area: nothing can be looked for there", place=place)
    return Region(pose @ Pose((offset[0], offset[1], offset[2])), (half[0], half[1]))


def inner_region(context: RunContext, compartment: str) -> Region | str:
    """Returns the floor of a compartment in the map, or why it is unknown."""
    pose = map_pose(context, compartment)
    solid = context.world.value(compartment, v.SOLID)
    if pose is None or solid is None:
        return Message("{compartment} has no pose or no inner volume", compartment=compartment)
    low, high = Solid.from_json(str(solid)).bounds()
    return Region(pose, (float(high[0] - low[0]) / 2.0, float(high[1] - low[1]) / 2.0), exact=True)


_LOOK_HEIGHTS = (0.46, 0.40, 0.34, 0.28, 0.22)
"""Heights of the camera above the viewed surface, best first [m]; low ones for when the arm cannot reach higher."""
_VIEWS = 4
"""The camera is turned to so many sides."""


@dataclass(frozen=True, slots=True)
class LookingParams:
    """Parameters of every primitive that looks."""

    arm: str = param(v.ARM, "The arm that carries the camera.", kind=Kind.HARDWARE)
    camera: str = param(v.CAMERA, "The camera to look with.", kind=Kind.HARDWARE)


class LookingPrimitive(ArmPrimitive):
    """Base of the primitives that look; their parameters are :class:`LookingParams` and more."""

    _view: int | None = None
    """From which side the last picture was taken."""

    def in_vain(self, reason: str) -> Failure:
        """Returns a failure; the next look for the same purpose is one from another side."""
        if self._view is not None:
            angle = 360.0 * self._view / _VIEWS
            self.context.tried.note("view", self._view, Message("looked from {angle:.0f} deg", angle=angle))
        return Failure(reason)

    def look_for_parts(self, region: Region, x: float, y: float) -> Execution[DetectionResult | NoMotion]:
        """Searches a region for parts, in a picture from straight above a point of the map [m]."""
        detector = self.context.port(PartDetector, self.params.camera)
        picture = yield from self.look_down(x, y, region.pose.position[2])
        if isinstance(picture, NoMotion):
            return picture
        request = DetectionRequest(*picture, region, part_models(self.world), self.seed(), self.params.camera)
        return (yield from self.wait(detector.detect(request)))

    def look_down(
        self, x: float, y: float, surface: float, *, aside: float = 0.0
    ) -> Execution[tuple[DepthImage, Pose] | NoMotion]:
        """Takes a picture from straight above a point of the map; returns it with the camera's pose in the map.

        Args:
            x: Where to look, in the map [m].
            y: Where to look, in the map [m].
            surface: Height of the viewed surface, in the map [m].
            aside: How far to retract the tool [m]: a part in the gripper hides that side of the image, so the point
                should lie on the other side.
        """
        camera = self.context.cell.device(self.params.camera, CameraSpec)
        back = self.camera_in_tip(camera).inverse() @ Pose((-aside, 0.0, 0.0))
        fresh = self.context.tried.fresh("view", range(_VIEWS))
        others = [view for view in range(_VIEWS) if view not in fresh]
        refusal: NoMotion | None = None
        choices = product(SHARES, _LOOK_HEIGHTS, filter(None, (fresh, others)))  # rather lower than nearer to things
        for share, height, views in choices:
            yaws = [self.base_pose.yaw + view * math.tau / _VIEWS for view in views]
            routes = [(PoseMove(downward(x, y, surface + height, yaw) @ back),) for yaw in yaws]
            planned = yield from self.plan(routes, shares=(share,))
            refusal = planned if isinstance(planned, NoMotion) else (yield from self.follow_plan(planned))
            if isinstance(planned, MotionPlan) and refusal is None:
                self._view = views[planned.route]
                image = yield from self.take_picture(camera.id)
                return image, self.context.frames.at(image.snapshot).located(camera.id)
        assert refusal is not None, "each view is taken or refused"
        reason = Message("cannot look at ({x:.2f}, {y:.2f}) from above: {reason}", x=x, y=y, reason=refusal.reason)
        return replace(refusal, reason=reason)


_CLEAR = 0.9
"""Minimum fraction of a compartment that must be seen to call it empty."""
_SLID = 0.003
"""What is held is believed to sit elsewhere when it is seen at least this far off [m]."""
_ASIDE = (0.0, 0.06, 0.09)
"""How far the tool is retracted for each look [m]: a held part may hide the kit."""


class RegisterKit(LookingPrimitive):
    """Fits the kit's walls to the camera image; a bad fit gives a failure, not a pose."""

    name: ClassVar[str] = "register_kit"
    _picture: tuple[DepthImage, Pose] | None = None

    @dataclass(frozen=True, slots=True)
    class Params(LookingParams):
        """Parameters."""

        kit: str = param(v.CONTAINER, "The kit.")
        compartment: str | None = param(
            v.CONTAINER, "A compartment that must be empty; left out: none.", kind=Kind.OPTIONAL
        )

    def execute(self) -> Execution[Outcome]:
        """Looks, and corrects the believed pose."""
        believed = map_pose(self.context, self.params.kit)
        if believed is None:
            return Failure(Message("the position of {kit} is unknown", kit=self.params.kit))
        why = ""
        for attempt, aside in enumerate(_ASIDE, start=1):
            self.progress(attempt, Message("look {attempt} at {kit}", attempt=attempt, kit=self.params.kit))
            result = yield from self._look(believed, aside)
            if isinstance(result, RegistrationResult) and result.pose is not None:
                self._write(result.pose, result.cost)
                moved = result.pose.distance(believed) * 1e3
                if self.params.compartment is not None and aside != _ASIDE[-1]:
                    content = yield from self._content(self.params.compartment)
                    if content is None:
                        continue  # what is held hides it
                    if content:
                        return Failure(content)
                yield from self._look_at_held()
                return Success(
                    Message("{kit} is {moved:.0f} mm from where it was believed", kit=self.params.kit, moved=moved)
                )
            why = why or result.reason
        return self.in_vain(Message("{kit} is not recognised where it should be: {why}", kit=self.params.kit, why=why))

    def _look_at_held(self) -> Execution[None]:
        """Looks in the same picture how what is held sits now, which may have slid on the way."""
        holding = held_by(self.context, self.gripper_id)
        if holding is None or self._picture is None:
            return
        part, held = holding
        found = yield from self.how_it_sits(self._picture[0], self.params.camera, part, held.pose)
        if found is not None and found.pose is not None and found.pose.distance(held.pose) > _SLID:
            slid = found.pose.distance(held.pose) * 1e3
            with self.world.transaction(author=self.name, reason=Message("slid by {slid:.0f} mm", slid=slid)) as tx:
                write_pose(tx, part, found.pose, self.gripper_id)

    def _look(self, believed: Pose, aside: float) -> Execution[RegistrationResult | NoMotion]:
        camera, solid = self.params.camera, solid_of(self.world, self.params.kit)
        registrar = self.context.port(Registrar, camera)
        if solid is None:
            raise DeviceError(f"register_kit needs a shape of {self.params.kit}")
        picture = yield from self.look_down(*believed.position, aside=aside)
        if isinstance(picture, NoMotion):
            return picture
        self._picture = picture
        request = RegistrationRequest(*picture, solid, believed, self.seed(), camera, self.params.kit)
        return (yield from self.wait(registrar.register(request)))

    def _content(self, compartment: str) -> Execution[str | None]:
        """Looks at the same picture for something in a compartment.

        Returns:
            Why it is not empty, which is written; an empty text if it is; None where it cannot be seen.
        """
        region = inner_region(self.context, compartment)
        assert self._picture is not None
        if isinstance(region, str):
            return ""
        detector = self.context.port(PartDetector, self.params.camera)
        models = part_models(self.world)
        request = DetectionRequest(*self._picture, region, models, self.seed(), self.params.camera)
        look = yield from self.wait(detector.detect(request))
        if not look.detections:
            return "" if look.visible >= _CLEAR else None
        seen = look.detections[0]
        what = seen.type.partition(":")[2] if seen.type else _UNKNOWN_SHAPE
        reason = Message("{compartment} is taken: {what} is seen there", compartment=compartment, what=what)
        with self.world.transaction(author=self.name, reason=reason) as tx:
            found = tx.add(seen.type or v.OBSTACLE, placement=Placement(v.IN, compartment))
            write_pose(tx, found, seen.pose)
        return reason

    def _write(self, pose: Pose, cost: float) -> None:
        kit = self.params.kit
        frame = next(iter(self.world.objects(kit, v.POSE_FRAME)), None)
        in_map = map_pose(self.context, frame) if frame else None
        own = in_map.inverse() @ pose if in_map is not None else pose
        with self.world.transaction(
            author=self.name, reason=Message("fitted within {cost:.1f} mm", cost=cost * 1000.0)
        ) as tx:
            write_pose(tx, kit, own, frame)


_NEAR = 0.05
"""The part seen may lie at most this far from where the first look saw it [m]."""
_HALF = 0.10
"""Half the side length of the searched square [m]."""


class RegisterPart(LookingPrimitive):
    """The second look, with the camera exactly above the part: nothing hides its far side."""

    name: ClassVar[str] = "register_part"

    @dataclass(frozen=True, slots=True)
    class Params(LookingParams):
        """Parameters."""

        part: str = param(v.MANIPULATABLE, "The part; a first look has seen it.")

    def execute(self) -> Execution[Outcome]:
        """Looks, and corrects the believed pose."""
        believed = map_pose(self.context, self.params.part)
        if believed is None:
            return Failure(Message("{part} has not been seen yet", part=self.params.part))
        x, y, _ = believed.position
        look = yield from self.look_for_parts(Region(Pose(believed.position), (_HALF, _HALF)), x, y)
        if isinstance(look, NoMotion):
            return Failure(look.reason, values=look.values)
        nearest = min(look.detections, key=lambda d: d.pose.distance(believed), default=None)
        return self._judge(nearest, believed)

    def _judge(self, nearest: Detection | None, believed: Pose) -> Outcome:
        part = self.params.part
        wanted = self.world.element(part).type
        if nearest is None or nearest.pose.distance(believed) > _NEAR:
            return self._forget(Message("{part} is not where the first look saw it", part=part))
        if nearest.type != wanted:
            what = nearest.type.partition(":")[2] if nearest.type else _UNKNOWN_SHAPE
            return self._forget(Message("what lies where {part} was seen is {what}", part=part, what=what))
        with self.world.transaction(
            author=self.name, reason=Message("cost {cost:.1f} mm", cost=nearest.cost * 1000.0)
        ) as tx:
            write_pose(tx, part, nearest.pose)
        return Success(
            Message("{part} at ({x:.3f}, {y:.3f})", part=part, x=nearest.pose.position[0], y=nearest.pose.position[1])
        )

    def _forget(self, reason: str) -> Failure:
        with self.world.transaction(author=self.name, reason=reason) as tx:
            write_pose(tx, self.params.part, None)
        return self.in_vain(reason)


_LOOKS = 2
_UNKNOWN_SHAPE = Message("something of unknown shape")


class VerifyPlace(LookingPrimitive):
    """Only parts seen in the compartment are believed to be in it."""

    name: ClassVar[str] = "verify_place"

    @dataclass(frozen=True, slots=True)
    class Params(LookingParams):
        """Parameters."""

        part: str = param(v.MANIPULATABLE, "The part that was put down.")
        compartment: str = param(v.CONTAINER, "Where it should be.")

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
                return Failure(look.reason, values=look.values)
            wanted = self.world.element(self.params.part).type
            seen = next((d for d in look.detections if d.type == wanted), None)
            if seen is not None:
                return self._confirm(seen)
            strange = any(d.type is None for d in look.detections)
        return self._deny(strange=strange)

    def _confirm(self, seen: Detection) -> Outcome:
        part, compartment = self.params.part, self.params.compartment
        with self.world.transaction(
            author=self.name, reason=Message("seen in {compartment}", compartment=compartment)
        ) as tx:
            tx.place(part, v.IN, compartment)
            tx.set(part, v.MISSING, None)
            write_pose(tx, part, seen.pose)
        return Success(Message("{part} is in {compartment}", part=part, compartment=compartment))

    def _deny(self, *, strange: bool) -> Outcome:
        part, compartment = self.params.part, self.params.compartment
        what = _UNKNOWN_SHAPE if strange else Message("nothing of its kind")
        with self.world.transaction(
            author=self.name, reason=Message("{what} seen in {compartment}", what=what, compartment=compartment)
        ) as tx:
            write_pose(tx, part, None)
            tx.set(part, v.MISSING, True)
            tx.place(part, v.ON, self.world.instances(v.UNKNOWN_LOCATION)[0])
        return Failure(
            Message(
                "{part} was released over {compartment}, but {what} is seen there",
                part=part,
                compartment=compartment,
                what=what,
            )
        )
