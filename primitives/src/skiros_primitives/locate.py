"""Looks over a storage place, recognizes parts by their shape, and writes where they are.

Type and place must match; the nearest believed pose comes first, then an individual that was never seen, then one seen
elsewhere in the place, then one of the place's stock, which stays without an individual, then a missing one, otherwise
a new one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

from skiros_primitives.arm_moves import refused
from skiros_primitives.camera_check import note_sighting
from skiros_primitives.looking import LookingParams, LookingPrimitive
from skiros_primitives.part_models import part_models
from skiros_primitives.surfaces import support_region
from skiros_py.geometry import Pose
from skiros_py.messages import Message
from skiros_py.ports.motion import NoMotion
from skiros_py.ports.perception import Detection, DetectionResult
from skiros_py.skills.context import RunContext
from skiros_py.skills.outcome import Failure, Outcome, Success
from skiros_py.skills.parameters import param
from skiros_py.skills.primitive import Execution
from skiros_py.skills.surroundings import map_pose, write_seen
from skiros_py.world import vocabulary as v
from skiros_py.world.element import Placement
from skiros_py.world.poses import write_pose
from skiros_py.world.stock import stocks
from skiros_py.world.transaction import Transaction

_SAME = 0.10
"""A part is the believed one when it lies at most this far from where it is believed to be [m]."""


@dataclass(frozen=True, slots=True)
class Association:
    """The result of associating one look with the world model of a place.

    Attributes:
        seen: (element id, or None for a new element; type; map pose).
        unseen: Ids of parts believed there that the look does not show.
    """

    seen: tuple[tuple[str | None, str, Pose], ...]
    unseen: tuple[str, ...]


def associate(context: RunContext, place: str, types: Sequence[str], detections: Sequence[Detection]) -> Association:
    """Pairs detections with believed parts of a place.

    Args:
        context: The run.
        place: The place in view.
        types: Distinguishable part types; only parts of these are reported as unseen.
        detections: What was seen there.
    """
    seen: list[tuple[str | None, str, Pose]] = []
    unseen: list[str] = []
    for type_ in types:
        poses = [d.pose for d in detections if d.type == type_]
        known = [e for e in context.world.subjects(v.IN, place) if context.world.element(e).type == type_]
        stocked = sum(s.count for s in stocks(context.world) if (s.class_, s.placement.place) == (type_, place))
        here = len(known)
        missing = [e for e in _missing(context, type_) if e not in known]
        known += missing[: max(0, len(poses) - here - stocked)] if stocked else missing
        pairs = _pair(known, here, poses, {e: map_pose(context, e) for e in known})
        unknown = [index for index in range(len(poses)) if index not in pairs]
        in_stock = frozenset(unknown[:stocked])
        seen += [(pairs.get(index), type_, pose) for index, pose in enumerate(poses) if index not in in_stock]
        unseen += [e for e in known if e not in pairs.values() and context.world.related(e, v.IN, place)]
    return Association(tuple(seen), tuple(unseen))


def _missing(context: RunContext, type_: str) -> list[str]:
    """Returns the parts of a type whose place is unknown: a newly detected part may be one of them."""
    view = context.world
    return [e for e in view.instances(type_) if view.element(e).type == type_ and view.value(e, v.MISSING) is True]


def _pair(known: Sequence[str], here: int, poses: Sequence[Pose], believed: dict[str, Pose | None]) -> dict[int, str]:
    """Returns element by index of the pose; the first ``here`` of the known are believed in this place."""
    pairs: dict[int, str] = {}
    near = sorted(
        (pose.distance(at), index, element)
        for element in known
        if (at := believed[element]) is not None
        for index, pose in enumerate(poses)
        if pose.distance(at) <= _SAME
    )
    for _, index, element in near:
        if index not in pairs and element not in pairs.values():
            pairs[index] = element
    # The remaining detections go to parts without a pose, then to parts believed elsewhere in the place, then to
    # missing parts, which come last in ``known``.
    unobserved = [e for e in known if e not in pairs.values()]
    unobserved.sort(key=lambda e: (known.index(e) >= here, believed[e] is not None, e))
    for index in range(len(poses)):
        if index not in pairs and unobserved:
            pairs[index] = unobserved.pop(0)
    return pairs


_FIRST_LOOK = 0.015
"""Greatest error of a camera for a first look, as a standard deviation [m]: the second one is exact."""
_CLEAR = 0.9
"""Minimum fraction of the place that the camera must see for a clear look."""
_MISSES = 2
"""A part absent from this many clear looks is missing."""


class Locate(LookingPrimitive):
    """Looks from above; looks again if something expected is not seen."""

    name: ClassVar[str] = "locate"

    @dataclass(frozen=True, slots=True)
    class Params(LookingParams):
        """Parameters."""

        place: str = param(v.LOCATION, "Where to look.")
        part: str = param(v.MANIPULATABLE, "The part that is wanted.")

    def execute(self) -> Execution[Outcome]:
        """Looks until the wanted part is seen, or two clear looks do not show it."""
        region, part = support_region(self.context, self.params.place), self.params.part
        if self.world.related(part, v.ON, self.params.place) and map_pose(self.context, part) is not None:
            return Success(Message("{part} was seen on {place}", part=part, place=self.params.place))
        if isinstance(region, str):
            return Failure(region)
        clear_looks, why, vain = 0, "", set[str]()
        x, y, _ = (map_pose(self.context, part) or region.pose).position  # where it is believed to be, if that is known
        for attempt in range(1, _MISSES + 2):
            self.progress(attempt, Message("look {attempt} at {place}", attempt=attempt, place=self.params.place))
            self.choose_camera(region, _FIRST_LOOK, vain)
            vain.add(self.camera)
            look = yield from self.look_for_parts(region, x + 0.04 * (attempt - 1), y)
            if isinstance(look, NoMotion):
                return refused(look)
            seen = self._write(look)
            if self.params.part in seen:
                return Success(Message("{part} is there; {seen} parts seen", part=self.params.part, seen=len(seen)))
            clear_looks += look.visible >= _CLEAR
            why = self._not_seen(look)
            if clear_looks >= _MISSES:
                break
        return self.in_vain(why)

    def _write(self, look: DetectionResult) -> set[str]:
        """Writes what was seen, and counts the clear looks that did not show what was expected."""
        types = [model.type for model in part_models(self.world)]
        found = associate(self.context, self.params.place, types, look.detections)
        clear = look.visible >= _CLEAR and look.surface is not None
        seen: dict[str, Pose] = {}
        with self.world.transaction(author=self.name, reason=Message("look at {place}", place=self.params.place)) as tx:
            for element, type_, pose in found.seen:
                part = element or tx.add(type_, placement=Placement(v.IN, self.params.place))
                write_seen(self.context, tx, part, pose, self.params.place)
                if element:
                    tx.place(part, v.IN, self.params.place)  # a missing part is found
                    tx.set(part, v.MISSED_LOOKS, None)
                    tx.set(part, v.MISSING, None)
                seen[part] = pose
            if clear:
                self._count_misses(tx, found, unknown=sum(d.type is None for d in look.detections))
        for part, pose in seen.items():
            note_sighting(self.context, self.camera, part, self.sighting(pose), self.name)
        return {*seen}

    def _count_misses(self, tx: Transaction, found: Association, *, unknown: int) -> None:
        """Counts misses of expected parts; each unknown detection may be one of them, so as many are excused."""
        for part in found.unseen[: max(0, len(found.unseen) - unknown)]:
            before = self.world.value(part, v.MISSED_LOOKS)
            misses = (before if isinstance(before, int) else 0) + 1
            write_pose(tx, part, None)
            tx.set(part, v.MISSED_LOOKS, misses)
            if misses >= _MISSES:
                tx.set(part, v.MISSING, True)
                tx.place(part, v.ON, self.world.instances(v.UNKNOWN_LOCATION)[0])
                # All that was seen are other known parts, so the stock of this type is empty.
                for stock in stocks(self.world):
                    if (stock.class_, stock.placement.place) == (self.world.element(part).type, self.params.place):
                        tx.set(stock.id, v.STOCK_COUNT, 0)

    def _not_seen(self, look: DetectionResult) -> str:
        part, place = self.params.part, self.params.place
        if look.surface is None:
            return Message("{part} not found: no surface seen where {place} should be", part=part, place=place)
        if look.visible < _CLEAR:
            return Message(
                "{part} not found in {place}: something hides {percent:.0f} % of it",
                part=part,
                place=place,
                percent=100 * (1 - look.visible),
            )
        if any(d.type is None for d in look.detections):
            return Message(
                "{part} not found in {place}: something lies there whose shape is not known", part=part, place=place
            )
        return Message(
            "{part} not found in {place}: expected, but not seen in {misses} clear looks",
            part=part,
            place=place,
            misses=_MISSES,
        )
