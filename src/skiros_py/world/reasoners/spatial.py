"""The spatial reasoner: poses in any frame, and how things lie to each other (paper §5.4)."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np

from skiros_py.errors import UsageError
from skiros_py.geometry import Pose
from skiros_py.world.element import Value
from skiros_py.world.poses import attach, pose_in, write_pose
from skiros_py.world.reasoners.boxes import MAP, Bools, Boxes, BoxMemory, read_boxes
from skiros_py.world.reasoners.contacts import candidate_pairs, distance
from skiros_py.world.reasoners.reasoner import Answer, Reasoner
from skiros_py.world.reasoners.spatial_relations import SPATIAL_RELATIONS, SpatialRelation
from skiros_py.world.vocabulary import POSE_FRAME

if TYPE_CHECKING:
    from skiros_py.world.transaction import Transaction
    from skiros_py.world.view import WorldView


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

    def __init__(self) -> None:
        self._memory = BoxMemory()

    # ------------------------------------------------------------ relations

    def answer(self, view: WorldView, subject: str, relation: str, object_: str) -> Answer:
        """Says whether one of its relations holds between two elements, and why; the value is in metres."""
        meant = SPATIAL_RELATIONS[relation]
        boxes = read_boxes(view, (subject, object_))
        unknown = _unknown(meant, boxes, (subject, object_))
        if unknown:
            return Answer(False, unknown)
        if subject == object_:
            return Answer(False, f"{subject} is one thing, and this is about two")
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
        boxes = self._memory.boxes(view, ids)
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
        elif what == "position" and isinstance(value, tuple) and len(value) == 3:
            here = pose_in(tx.view, element, frame) or Pose()
            write_pose(tx, element, Pose((value[0], value[1], value[2]), here.orientation), frame)
        elif what == "orientation" and isinstance(value, tuple) and len(value) == 4:
            here = pose_in(tx.view, element, frame) or Pose()
            write_pose(tx, element, Pose(here.position, (value[0], value[1], value[2], value[3])), frame)
        else:
            raise UsageError(f"spatial stores no '{key}' from {value!r}: {_STORES}")


_READS = "it reads pose, position, orientation, each also '… in ELEMENT', frame and 'distance to ELEMENT'"
_STORES = (
    "it stores pose (a Pose), position (x, y, z), orientation (x, y, z, w), each also '… in ELEMENT',"
    " and frame (an id, or '' for the map)"
)


def _parsed(key: str) -> tuple[str, str | None]:
    """What a key asks for, and of which other element."""
    what, _, other = key.partition(" to " if key.startswith("distance") else " in ")
    return what, other or None


def _comparable(meant: SpatialRelation, boxes: Boxes) -> Bools:
    """Of which boxes enough is known for a relation."""
    return np.asarray((boxes.sized | (not meant.needs_size)) & ((boxes.roots == MAP) | (not meant.needs_map)))


def _unknown(meant: SpatialRelation, boxes: Boxes, names: tuple[str, str]) -> str | None:
    """Says what must be known of two elements for a relation and is not, or None."""
    adrift = [name for name, root in zip(names, boxes.roots, strict=True) if root != MAP]
    if adrift and (meant.needs_map or boxes.roots[0] != boxes.roots[1]):
        return f"the pose of {' and that of '.join(adrift)} in the map is not known"
    sizeless = [name for name, sized in zip(names, boxes.sized, strict=True) if not sized]
    if sizeless and meant.needs_size:
        return f"the size of {' and that of '.join(sizeless)} is not known"
    return None
