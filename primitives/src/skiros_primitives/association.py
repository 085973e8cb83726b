"""Associates detected parts with parts in the world model.

Type and place must match; the nearest believed pose comes first, then an individual that was never seen, then one seen
elsewhere in the place, then one of the place's stock, which stays without an individual, then a missing one, otherwise
a new one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from skiros_py.geometry import Pose
from skiros_py.ports.perception import Detection
from skiros_py.skills.context import RunContext
from skiros_py.skills.surroundings import map_pose
from skiros_py.world.stock import stocks
from skiros_py.world.vocabulary import IN, MISSING

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
        known = [e for e in context.world.subjects(IN, place) if context.world.element(e).type == type_]
        stocked = sum(s.count for s in stocks(context.world) if (s.class_, s.placement.place) == (type_, place))
        here = len(known)
        missing = [e for e in _missing(context, type_) if e not in known]
        known += missing[: max(0, len(poses) - here - stocked)] if stocked else missing
        pairs = _pair(known, here, poses, {e: map_pose(context, e) for e in known})
        unknown = [index for index in range(len(poses)) if index not in pairs]
        in_stock = frozenset(unknown[:stocked])
        seen += [(pairs.get(index), type_, pose) for index, pose in enumerate(poses) if index not in in_stock]
        unseen += [e for e in known if e not in pairs.values() and context.world.related(e, IN, place)]
    return Association(tuple(seen), tuple(unseen))


def _missing(context: RunContext, type_: str) -> list[str]:
    """Returns the parts of a type whose place is unknown: a newly detected part may be one of them."""
    view = context.world
    return [e for e in view.instances(type_) if view.element(e).type == type_ and view.value(e, MISSING) is True]


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
