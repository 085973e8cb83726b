"""Which believed part is which seen one.

Same type and place; nearest believed pose first, else an individual nobody has seen yet, else a new one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from skiros_py.geometry import Pose
from skiros_py.robot.perception import Detection
from skiros_py.skills.context import RunContext
from skiros_py.skills.surroundings import map_pose
from skiros_py.world.vocabulary import IN

__all__ = ["Association", "associate"]

_SAME = 0.10
"""A part is the believed one when it lies at most this far from where it is believed to be [m]."""


@dataclass(frozen=True, slots=True)
class Association:
    """What a look means for the beliefs about one place.

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
        place: Where was looked.
        types: Part types that can be told apart; only parts of these are reported as unseen.
        detections: What was seen there.
    """
    seen: list[tuple[str | None, str, Pose]] = []
    unseen: list[str] = []
    for type_ in types:
        poses = [d.pose for d in detections if d.type == type_]
        known = [e for e in context.world.subjects(IN, place) if context.world.element(e).type == type_]
        pairs = _pair(known, poses, {e: map_pose(context, e) for e in known})
        seen += [(pairs.get(index), type_, pose) for index, pose in enumerate(poses)]
        unseen += [e for e in known if e not in pairs.values()]
    return Association(tuple(seen), tuple(unseen))


def _pair(known: Sequence[str], poses: Sequence[Pose], believed: dict[str, Pose | None]) -> dict[int, str]:
    """Returns element by index of the pose."""
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
    # Whoever has no pose yet, or was believed elsewhere in the place, may be any of the rest.
    unobserved = [e for e in known if e not in pairs.values()]
    unobserved.sort(key=lambda e: (believed[e] is not None, e))
    for index in range(len(poses)):
        if index not in pairs and unobserved:
            pairs[index] = unobserved.pop(0)
    return pairs
