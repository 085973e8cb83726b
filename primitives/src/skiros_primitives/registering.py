"""Looks at a kit or a part for its exact pose, and into a compartment for its content."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

from skiros_primitives.arm_moves import refused
from skiros_primitives.camera_check import blame, compare, is_due, note_sighting
from skiros_primitives.looking import ALIGNED, UNKNOWN_SHAPE, LookingParams, LookingPrimitive, kit_region
from skiros_primitives.surfaces import Surface, inner_region, kit_of, lost_part, surfaces
from skiros_py.geometry import Pose
from skiros_py.messages import Message
from skiros_py.ports.motion import NoMotion
from skiros_py.ports.perception import (
    Detection,
    DetectionResult,
    Region,
)
from skiros_py.ports.values import DepthImage
from skiros_py.skills.outcome import Failure, Outcome, Success
from skiros_py.skills.parameters import Kind, param
from skiros_py.skills.primitive import Execution
from skiros_py.skills.surroundings import map_pose, write_seen
from skiros_py.world import vocabulary as v
from skiros_py.world.names import local_name
from skiros_py.world.poses import write_pose

_ASIDE = (0.0, 0.06, 0.09)
"""How far the tool is retracted for each look [m]: a held part may hide the kit."""


class RegisterKit(LookingPrimitive):
    """Fits the kit's walls to the camera image; a bad fit gives a failure, not a pose."""

    name: ClassVar[str] = "register_kit"

    @dataclass(frozen=True, slots=True)
    class Params(LookingParams):
        """Parameters."""

        kit: str = param(v.CONTAINER, "The kit.")
        compartment: str | None = param(
            v.CONTAINER, "A compartment that must be empty; left out: none.", kind=Kind.OPTIONAL
        )

    def execute(self) -> Execution[Outcome]:
        """Looks, and corrects the believed pose."""
        kit, believed = self.params.kit, map_pose(self.context, self.params.kit)
        if believed is None:
            return Failure(Message("the position of {kit} is unknown", kit=kit))
        place = map_pose(self.context, self.params.compartment) if self.params.compartment is not None else None
        shown, why = None if place is None else place.position, ""
        region, refusal = kit_region(self.context, kit, believed), None
        vain: set[str] = set()
        for attempt, aside in enumerate(_ASIDE, start=1):
            self.progress(attempt, Message("look {attempt} at {kit}", attempt=attempt, kit=kit))
            self.choose_camera(region, without=vain)
            vain.add(self.camera)
            picture = yield from self.look_down(believed.position, aside=aside, shown=shown)
            if isinstance(picture, NoMotion):
                refusal = refusal or picture
                continue
            result = yield from self.fit(kit, believed, picture)
            if result.pose is None:
                why = why or result.reason
                continue
            if self.params.compartment is not None and aside != _ASIDE[-1]:
                content = yield from self.content(self.params.compartment, picture)
                if content is None:
                    continue  # what is held hides it
                if content:
                    return Failure(content)
            differ = note_sighting(self.context, self.camera, kit, self.sighting(result.pose), self.name)
            self.tell(blame(self.context, self.camera, differ, self.name))
            moved = result.pose.distance(believed) * 1e3
            return Success(Message("{kit} is {moved:.0f} mm from where it was believed", kit=kit, moved=moved))
        if refusal is not None and not why:
            return refused(refusal)
        return self.in_vain(Message("{kit} is not recognised where it should be: {why}", kit=kit, why=why))


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
        part, placement = self.params.part, self.world.placement(self.params.part)
        astray = placement is not None and placement.relation == v.ON
        region = Region(Pose(believed.position), (_HALF, _HALF), exact=astray)
        self.choose_camera(region)
        if is_due(self.context, self.camera):
            self._first = self.context.pictures.sightings.get((self.camera, part))
        nearest = yield from self._nearest(region, believed)
        if isinstance(nearest, NoMotion):
            return refused(nearest)
        if astray and (nearest is None or nearest.type is None):  # it need not stand upright: the grasp will tell
            return Success(Message("{part} is not recognised, but taken to lie where it was seen", part=part))
        outcome = self._judge(nearest, believed)
        if isinstance(outcome, Success) and nearest is not None:
            yield from self._check(region, nearest)
        return outcome

    def _nearest(self, region: Region, believed: Pose) -> Execution[Detection | NoMotion | None]:
        """Looks from above; returns what is seen nearest to where the part is believed to be."""
        x, y, _ = believed.position
        look = yield from self.look_for_parts(region, x, y)
        if isinstance(look, NoMotion):
            return look
        return min(look.detections, key=lambda d: d.pose.distance(believed), default=None)

    def _check(self, region: Region, found: Detection) -> Execution[None]:
        """Compares where the part is seen with where it was seen before; looks once more where that differs."""
        camera, part, seen = self.camera, self.params.part, self.sighting(found.pose)
        if self._first is not None:
            self.tell(compare(self.context, camera, self._first, seen, self.name))
        differ = note_sighting(self.context, camera, part, seen, self.name)
        if differ and is_due(self.context, camera, _JUST) and self.carries(camera):
            self._first = seen  # which tells whether this camera is the one that is off
            again = yield from self._nearest(region, found.pose)
            if isinstance(again, Detection) and again.type == found.type:
                self.tell(compare(self.context, camera, seen, self.sighting(again.pose), self.name))
        self.tell(blame(self.context, camera, differ, self.name))

    def _judge(self, nearest: Detection | None, believed: Pose) -> Outcome:
        part, placement = self.params.part, self.world.placement(self.params.part)
        wanted = self.world.element(part).type
        if nearest is None or nearest.pose.distance(believed) > _NEAR:
            return self._forget(Message("{part} is not where the first look saw it", part=part))
        if nearest.type != wanted:
            what = nearest.type.partition(":")[2] if nearest.type else UNKNOWN_SHAPE
            return self._forget(Message("what lies where {part} was seen is {what}", part=part, what=what))
        with self.world.transaction(
            author=self.name, reason=Message("cost {cost:.1f} mm", cost=nearest.cost * 1000.0)
        ) as tx:
            write_seen(self.context, tx, part, nearest.pose, None if placement is None else placement.place)
        return Success(
            Message("{part} at ({x:.3f}, {y:.3f})", part=part, x=nearest.pose.position[0], y=nearest.pose.position[1])
        )

    def _forget(self, reason: str) -> Failure:
        with self.world.transaction(author=self.name, reason=reason) as tx:
            write_pose(tx, self.params.part, None)
        return self.in_vain(reason)


_JUST = 60.0
"""A camera that agreed with itself within this time need not look again [s]."""
_INTO = 0.005
"""Greatest error at which a part is told to lie in a compartment, as a standard deviation [m]."""
_LOOKS = 3
_IN_SIGHT = math.radians(20.0)
"""Greatest angle from the middle of a picture at which something is looked at without moving."""


def looks_into(camera: Pose, place: Pose) -> bool:
    """Returns whether a camera looks steeply down into a compartment, which is near the middle of its picture.

    Args:
        camera: The camera, which looks along its z axis.
        place: The compartment, whose z axis points upwards, in the same frame.
    """
    x, y, z = (camera.inverse() @ place).position
    steep = float((place.inverse() @ camera).matrix()[2, 2]) < -math.cos(ALIGNED)
    return steep and math.hypot(x, y) < math.tan(_IN_SIGHT) * z


class VerifyPlace(LookingPrimitive):
    """Only parts seen in the compartment are believed to be in it; others are looked for around it."""

    name: ClassVar[str] = "verify_place"

    @dataclass(frozen=True, slots=True)
    class Params(LookingParams):
        """Parameters."""

        part: str = param(v.MANIPULATABLE, "The part that was put down.")
        compartment: str = param(v.CONTAINER, "Where it should be.")

    def execute(self) -> Execution[Outcome]:
        """Looks, first from where the arm is, then from above; at last where the kit is seen to be, and around."""
        part, compartment = self.params.part, self.params.compartment
        kit, wanted = kit_of(self.world, compartment), self.world.element(part).type
        inner = inner_region(self.context, compartment)
        if isinstance(inner, Region):
            self.choose_camera(inner, _INTO)
        for attempt in range(0 if self._is_in_sight(compartment) else 1, _LOOKS):
            self._chosen = self._chosen if attempt == 0 else None
            seen_from = yield from self._look_into(compartment, kit, attempt)
            if isinstance(seen_from, Failure):
                return seen_from
            region, picture = seen_from
            look = yield from self.detect(region, picture)
            seen = next((d for d in look.detections if d.type == wanted), None)
            if seen is not None:
                return self._confirm(seen)
        looks: dict[Surface, DetectionResult] = {}
        for place in surfaces(self.context, kit, compartment) if kit is not None else ():
            looks[place] = yield from self.detect(place.region, picture)
        for let_go in (None, region.pose):  # first what is recognised, then what may lie aslant on the kit
            for place, seen_there in looks.items():
                pose = lost_part(self.context, part, seen_there, let_go if place.place == kit else None)
                if pose is not None:
                    return self._astray(place, pose)
        return self._deny(strange=any(d.type is None for d in look.detections))

    def _is_in_sight(self, compartment: str) -> bool:
        """Returns whether the camera looks steeply down into a compartment from where the arm is after the retreat.

        One that the arm does not carry has to do where it is.
        """
        place = map_pose(self.context, compartment)
        if place is None or not self.carries(self.camera):
            return place is not None
        return looks_into(self.context.frames.at(self.context.board.snapshot).located(self.camera), place)

    def _look_into(
        self, compartment: str, kit: str | None, attempt: int
    ) -> Execution[tuple[Region, tuple[DepthImage, Pose]] | Failure]:
        """Takes a picture of a compartment, the first from where the arm is; in the last one it looks for the kit."""
        region = inner_region(self.context, compartment)
        if isinstance(region, str):
            return Failure(region)
        x, y, surface = region.pose.position
        if attempt == 0:
            return region, (yield from self.capture())
        picture = yield from self.look_down((x + 0.03 * (attempt - 1), y, surface))
        if isinstance(picture, NoMotion):
            return refused(picture)
        believed = map_pose(self.context, kit) if kit is not None and attempt > 1 else None
        if kit is not None and believed is not None:
            yield from self.register(kit, believed, picture)
        now = inner_region(self.context, compartment)
        return (now if isinstance(now, Region) else region), picture

    def _astray(self, where: Surface, pose: Pose) -> Outcome:
        part, compartment = self.params.part, self.params.compartment
        known = {"part": part, "compartment": compartment, "relation": local_name(where.relation), "place": where.place}
        reason = Message("{part} was released over {compartment}, but is seen {relation} {place}", **known)
        with self.world.transaction(author=self.name, reason=reason) as tx:
            tx.place(part, where.relation, where.place)
            tx.set(part, v.MISSING, None)
            self.write_in(tx, part, pose, where.place)
        return Failure(reason)

    def _confirm(self, seen: Detection) -> Outcome:
        part, compartment = self.params.part, self.params.compartment
        with self.world.transaction(
            author=self.name, reason=Message("seen in {compartment}", compartment=compartment)
        ) as tx:
            tx.place(part, v.IN, compartment)
            tx.set(part, v.MISSING, None)
            self.write_in(tx, part, seen.pose, compartment)
        return Success(Message("{part} is in {compartment}", part=part, compartment=compartment))

    def _deny(self, *, strange: bool) -> Outcome:
        part, compartment = self.params.part, self.params.compartment
        what = UNKNOWN_SHAPE if strange else Message("nothing of its kind")
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
