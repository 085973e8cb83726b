"""The spatial reasoner: poses in any frame, and how things lie to each other (paper §5.4).

Every function takes two :class:`~skiros_py.world.reasoners.boxes.Boxes` of n boxes, pair by pair of one root, and
returns arrays of length n [m].
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any

import numpy as np

from skiros_py.errors import UsageError
from skiros_py.geometry import Array, Pose
from skiros_py.messages import Message, listed
from skiros_py.world.element import Value
from skiros_py.world.poses import attach, pose_in, write_pose
from skiros_py.world.reasoners.box_geometry import (
    candidate_pairs,
    depth,
    distance,
    gap_seen_from_above,
    is_closer,
    offset_along,
    reach_along,
)
from skiros_py.world.reasoners.boxes import MAP, Bools, Boxes, read_boxes
from skiros_py.world.reasoners.registry import Answer, Reasoner
from skiros_py.world.transaction import Transaction
from skiros_py.world.view import WorldView
from skiros_py.world.vocabulary import (
    ABOVE,
    BEHIND,
    BELOW,
    IN_FRONT_OF,
    INSIDE,
    LEFT_OF,
    NEAR,
    OVERLAPS,
    POSE_FRAME,
    RESTS_ON,
    RIGHT_OF,
)

ACCURACY = 0.003
"""Poses are not sensed more exactly: what differs less is taken for the same [m]."""
NEARBY = 0.5
"""Things are near where there is at most this much between them: about as far as an arm reaches from a spot [m]."""
RESTING = 0.005
"""A thing rests where its lowest point is this close to the surface [m]."""

_ANYWHERE = float("inf")


@dataclass(frozen=True, slots=True)
class SpatialRelation:
    """One relation between boxes, pair by pair of one root.

    Attributes:
        holds: Between which pairs it holds.
        value: What that was decided by [m].
        says: A sentence about two elements, given whether it holds and the value.
        within: How far apart along the root's x, y, z the boxes may be for it to hold at all [m].
        needs_map: True where up and down matter, so that the pose in the map must be known.
        needs_size: True if a point has no answer.
    """

    holds: Callable[[Boxes, Boxes], Bools]
    value: Callable[[Boxes, Boxes], Array]
    says: Callable[[str, str, bool, float], str]
    within: tuple[float, float, float]
    needs_map: bool = False
    needs_size: bool = False


# ---------------------------------------------------------------- left, right, in front, behind


def _says_between(a: str, words: str, b: str, gap: float) -> str:
    return Message(
        "{subject} is {relation} {object}, with {gap:.3f} m between them",
        subject=a,
        relation=words,
        object=b,
        gap=max(gap, 0.0),
    )


def _beside(axis: int, side: float, words: str, further: str) -> SpatialRelation:
    """Wholly beyond one of the object's sides."""

    def value(a: Boxes, b: Boxes) -> Array:
        return side * offset_along(a, b, axis) - reach_along(a, b, axis) - b.halves[:, axis]

    def holds(a: Boxes, b: Boxes) -> Bools:
        return (value(a, b) >= -ACCURACY) & (side * offset_along(a, b, axis) > ACCURACY)

    def says(a: str, b: str, yes: bool, gap: float) -> str:
        if yes:
            return _says_between(a, words, b, gap)
        lacks = {"gap": max(-gap, ACCURACY), "further": Message("further {way}", way=further)}
        return Message(
            "{subject} is not {relation} {object}: it would have to be {gap:.3f} m {further}",
            subject=a,
            relation=words,
            object=b,
            **lacks,
        )

    return SpatialRelation(holds, value, says, (_ANYWHERE, _ANYWHERE, _ANYWHERE))


# ---------------------------------------------------------------- above, below, rests on


def _height_over(a: Boxes, b: Boxes) -> Array:
    return np.asarray(_lowest(a) - _highest(b))


def _is_above(a: Boxes, b: Boxes) -> Bools:
    higher = (_height_over(a, b) >= -ACCURACY) & (a.centres[:, 2] - b.centres[:, 2] > ACCURACY)
    apart = np.linalg.norm(a.centres[:, :2] - b.centres[:, :2], axis=1)
    return np.asarray(higher & ((gap_seen_from_above(a, b) < -ACCURACY) | (apart <= ACCURACY)))


def _says_over(word: str, further: str) -> Callable[[str, str, bool, float], str]:
    def says(a: str, b: str, yes: bool, gap: float) -> str:
        if yes:
            return _says_between(a, word, b, gap)
        said = {"subject": a, "relation": word, "object": b}
        if gap >= -ACCURACY:
            return Message("{subject} is not {relation} {object}: it is beside it", **said)
        return Message(
            "{subject} is not {relation} {object}: it would have to be {gap:.3f} m {further}",
            gap=-gap,
            further=further,
            **said,
        )

    return says


def _height_on(a: Boxes, b: Boxes) -> Array:
    return np.asarray(_lowest(a) - np.where(b.hollow, _lowest(b), _highest(b)))


def _rests(a: Boxes, b: Boxes) -> Bools:
    middle = replace(a, halves=np.zeros_like(a.halves))
    return np.asarray((np.abs(_height_on(a, b)) <= RESTING) & (gap_seen_from_above(middle, b) <= 0.0))


def _says_rests(a: str, b: str, yes: bool, height: float) -> str:
    if yes:
        return Message("{a} rests on {b}", a=a, b=b)
    if abs(height) <= RESTING:
        return Message("{a} does not rest on {b}: its middle is not over it", a=a, b=b)
    if height > 0.0:
        return Message("{a} does not rest on {b}: it is {height:.3f} m above its surface", a=a, b=b, height=height)
    return Message("{a} does not rest on {b}: it is {height:.3f} m below its surface", a=a, b=b, height=-height)


def _lowest(boxes: Boxes) -> Array:
    return np.asarray(boxes.centres[:, 2] - boxes.reach()[:, 2])


def _highest(boxes: Boxes) -> Array:
    return np.asarray(boxes.centres[:, 2] + boxes.reach()[:, 2])


# ---------------------------------------------------------------- near, overlaps, inside


def _says_near(a: str, b: str, yes: bool, apart: float) -> str:
    said = {"a": a, "b": b, "apart": apart}
    if yes:
        return Message("{a} is near {b}: there are {apart:.3f} m between them", **said)
    return Message("{a} is not near {b}: there are {apart:.3f} m between them, more than {most} m", most=NEARBY, **said)


def _overlaps(a: Boxes, b: Boxes) -> Bools:
    thinnest = np.minimum(a.halves.min(axis=1), b.halves.min(axis=1))
    return np.asarray(depth(a, b) > np.clip(thinnest, 1e-6, ACCURACY))


def _says_overlaps(a: str, b: str, yes: bool, deep: float) -> str:
    if yes:
        return Message("{a} and {b} overlap by {depth:.3f} m", a=a, b=b, depth=deep)
    if deep > 0.0:
        return Message("{a} and {b} do not overlap, but touch", a=a, b=b)
    return Message("{a} and {b} do not overlap", a=a, b=b)


def _clearance(a: Boxes, b: Boxes) -> Array:
    """The least room left at the sides and below; negative by how far it sticks out there."""
    x, y = (b.halves[:, k] - np.abs(offset_along(a, b, k)) - reach_along(a, b, k) for k in (0, 1))
    below = b.halves[:, 2] + offset_along(a, b, 2) - reach_along(a, b, 2)
    return np.asarray(np.minimum.reduce([x, y, below]))


def _is_inside(a: Boxes, b: Boxes) -> Bools:
    return np.asarray((_clearance(a, b) >= -ACCURACY) & _overlaps(a, b))


def _says_inside(a: str, b: str, yes: bool, clear: float) -> str:
    if yes:
        return Message("{a} is inside {b}, with {clear:.3f} m to its sides", a=a, b=b, clear=max(clear, 0.0))
    if clear >= -ACCURACY:
        return Message("{a} is not inside {b}: it is over it", a=a, b=b)
    return Message("{a} is not inside {b}: it sticks out by {clear:.3f} m", a=a, b=b, clear=-clear)


SPATIAL_RELATIONS: Mapping[str, SpatialRelation] = MappingProxyType(
    {
        IN_FRONT_OF: _beside(0, 1.0, Message("in front of"), Message("ahead")),
        BEHIND: _beside(0, -1.0, Message("behind"), Message("back")),
        LEFT_OF: _beside(1, 1.0, Message("left of"), Message("to the left")),
        RIGHT_OF: _beside(1, -1.0, Message("right of"), Message("to the right")),
        ABOVE: SpatialRelation(
            _is_above,
            _height_over,
            _says_over(Message("above"), Message("higher")),
            (0.01, 0.01, _ANYWHERE),
            needs_map=True,
        ),
        BELOW: SpatialRelation(
            lambda a, b: _is_above(b, a),
            lambda a, b: _height_over(b, a),
            _says_over(Message("below"), Message("lower")),
            (0.01, 0.01, _ANYWHERE),
            needs_map=True,
        ),
        RESTS_ON: SpatialRelation(
            _rests, _height_on, _says_rests, (0.01, 0.01, 2.0 * RESTING), needs_map=True, needs_size=True
        ),
        NEAR: SpatialRelation(lambda a, b: is_closer(a, b, NEARBY), distance, _says_near, (NEARBY, NEARBY, NEARBY)),
        OVERLAPS: SpatialRelation(
            _overlaps, lambda a, b: np.maximum(depth(a, b), 0.0), _says_overlaps, (0.0, 0.0, 0.0), needs_size=True
        ),
        INSIDE: SpatialRelation(_is_inside, _clearance, _says_inside, (0.0, 0.0, 0.0), needs_size=True),
    }
)
"""Every spatial relation by its CURIE."""


def box_distance(view: WorldView, a: str, b: str) -> float | None:
    """Returns the distance between the boxes around two elements [m], or None if it is not known.

    Raises:
        UnknownName: There is no such element.
    """
    boxes = read_boxes(view, (a, b))
    if boxes.roots[0] != boxes.roots[1]:
        return None
    return float(distance(boxes.take(np.array([0])), boxes.take(np.array([1])))[0])


class SpatialReasoner(Reasoner):
    """Poses and positions of elements, in the map or in the frame of any element, and their spatial relations.

    Skills use the functions of :mod:`skiros_py.world.poses`. :meth:`data` and :meth:`store` do the same by key:
    "pose", "position" (x, y, z) [m] and "orientation" (quaternion x, y, z, w) are those in the map, "pose in kit_1" is
    that in the frame of kit_1, "frame" is the id of the element in whose frame the pose is given and with which it
    moves ("" for none); "distance to kit_1" [m] can only be read.
    """

    name = "spatial"
    relations = frozenset(SPATIAL_RELATIONS)
    functions = MappingProxyType({"sk:distance": box_distance})
    keys = frozenset({"pose", "position", "orientation", "frame", "distance"})

    # ------------------------------------------------------------ relations

    def answer(self, view: WorldView, subject: str, relation: str, object_: str) -> Answer:
        """Returns whether one of its relations holds between two elements, and why; the value is in metres."""
        meant = SPATIAL_RELATIONS[relation]
        boxes = read_boxes(view, (subject, object_))
        unknown = _unknown(meant, boxes, (subject, object_))
        if unknown:
            return Answer(False, unknown)
        if subject == object_:
            return Answer(False, Message("{thing} is one thing, and this is about two", thing=subject))
        one, other = boxes.take(np.array([0])), boxes.take(np.array([1]))
        holds, value = bool(meant.holds(one, other)[0]), float(meant.value(one, other)[0])
        return Answer(holds, meant.says(subject, object_, holds, value), value)

    def pairs(
        self, view: WorldView, relation: str, subjects: Iterable[str], objects: Sequence[str]
    ) -> Iterator[tuple[str, str]]:
        """Yields the pairs between which a relation holds, in the order given."""
        meant, first = SPATIAL_RELATIONS[relation], tuple(subjects)
        ids = tuple(dict.fromkeys((*first, *objects)))
        number = {name: at for at, name in enumerate(ids)}
        boxes = read_boxes(view, ids)
        good = _comparable(meant, boxes)
        one = [name for name in first if good[number[name]]]
        other = [name for name in objects if good[number[name]]]
        a, b = (boxes.take(np.array([number[name] for name in names], dtype=np.int64)) for names in (one, other))
        for i, j in candidate_pairs(a, b, meant.within):
            held = meant.holds(a.take(i), b.take(j))
            yield from ((one[p], other[q]) for p, q in zip(i[held], j[held], strict=True) if one[p] != other[q])

    # ------------------------------------------------------------ data by key

    def data(self, view: WorldView, element: str, key: str) -> Value | None:
        """Reads a pose, a part of one, its frame or a distance, in the form that the key names.

        Raises:
            UsageError: It has no such key.
            UnknownName: There is no such element or frame.
        """
        what, frame = _parsed(key)
        if what == "distance" and frame is not None:
            return box_distance(view, element, frame)
        if what == "frame" and frame is None:
            return next(iter(view.objects(element, POSE_FRAME)), "")
        if what not in ("pose", "position", "orientation"):
            raise UsageError(f"spatial reads no '{key}': {_READS}")
        pose = pose_in(view, element, frame)
        return pose if pose is None or what == "pose" else pose.position if what == "position" else pose.orientation

    def store(self, tx: Transaction, element: str, key: str, value: Value) -> None:
        """Writes a pose, a part of one or its frame, in the form that the key names.

        A position alone leaves the orientation as it is, and the other way round; one that is not known becomes that of
        the frame.

        Raises:
            UsageError: It has no such key, or the value is nothing for it.
            WorldError: It should move with an element, but its pose in that element's frame is unknown.
        """
        what, frame = _parsed(key)
        if what == "frame" and frame is None and isinstance(value, str):
            attach(tx, element, value or None)
        elif what == "pose" and isinstance(value, Pose):
            write_pose(tx, element, value, frame)
        elif isinstance(value, tuple) and len(value) == _LENGTHS.get(what):
            changed: dict[str, Any] = {what: value}
            here = pose_in(tx.view, element, frame) or Pose()
            write_pose(tx, element, replace(here, **changed), frame)
        else:
            raise UsageError(f"spatial stores no '{key}' from {value!r}: {_STORES}")


_LENGTHS = {"position": 3, "orientation": 4}
_READS = "it reads pose, position, orientation, each also '… in ELEMENT', frame and 'distance to ELEMENT'"
_STORES = (
    "it stores pose (a Pose), position (x, y, z), orientation (x, y, z, w), each also '… in ELEMENT',"
    " and frame (an id, or '' for the map)"
)


def _parsed(key: str) -> tuple[str, str | None]:
    """The requested data of a key, and the other element."""
    what, _, other = key.partition(" to " if key.startswith("distance") else " in ")
    return what, other or None


def _comparable(meant: SpatialRelation, boxes: Boxes) -> Bools:
    """Selects the boxes that have the data for a relation."""
    return np.asarray((boxes.sized | (not meant.needs_size)) & ((boxes.roots == MAP) | (not meant.needs_map)))


def _unknown(meant: SpatialRelation, boxes: Boxes, names: tuple[str, str]) -> str | None:
    """Returns which data of two elements a relation lacks, or None."""
    adrift = [name for name, root in zip(names, boxes.roots, strict=True) if root != MAP]
    if adrift and (meant.needs_map or boxes.roots[0] != boxes.roots[1]):
        return Message("the pose of {things} in the map is not known", things=listed(adrift))
    sizeless = [name for name, sized in zip(names, boxes.sized, strict=True) if not sized]
    if sizeless and meant.needs_size:
        return Message("the size of {things} is not known", things=listed(sizeless))
    return None
