"""Boxes: the smallest ones around things along the axes of their own frames, many at a time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from functools import lru_cache
from typing import TYPE_CHECKING, Self

import numpy as np
from numpy.typing import NDArray

from skiros_py.geometry import Array, Pose, Solid
from skiros_py.world.element import Value
from skiros_py.world.index import Index
from skiros_py.world.vocabulary import HOLLOW, POSE, POSE_FRAME, SIZE, SOLID, SPATIAL_THING

if TYPE_CHECKING:
    from skiros_py.world.view import WorldView
from skiros_py.world.terms import reached

Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]

MAP = -1
"""The root of frames below the map."""

_Extents = tuple[float, float, float, float, float, float]
_POINT: _Extents = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
_READ = (POSE, SOLID, SIZE, HOLLOW)


@dataclass(frozen=True, slots=True)
class Boxes:
    """Some boxes, as arrays over their number n.

    Attributes:
        centres: (n, 3), middles in the frame of the root [m].
        halves: (n, 3), half lengths along the box's own x, y, z [m].
        axes: (n, 3, 3), the box's own x, y, z in the frame of the root, as columns.
        roots: (n,), which frame that is: :data:`MAP`, or some number of an element whose own pose is unknown (a
            gripper that moves), for it and the frames below it. Only boxes of one root can be compared.
        sized: (n,), False for a point: a thing of unknown size.
        hollow: (n,), True if the box is room, not matter.
    """

    centres: Array
    halves: Array
    axes: Array
    roots: Ints
    sized: Bools
    hollow: Bools

    def __len__(self) -> int:
        return len(self.roots)

    def take(self, numbers: Ints) -> Self:
        """Returns the boxes of these numbers, in this order."""
        return type(self)(*(getattr(self, field.name)[numbers] for field in fields(self)))

    def replaced(self, numbers: Ints, others: Boxes) -> Self:
        """Returns these boxes with others at some numbers."""
        arrays = [getattr(self, field.name).copy() for field in fields(self)]
        for array, field in zip(arrays, fields(self), strict=True):
            array[numbers] = getattr(others, field.name)
        return type(self)(*arrays)

    def reach(self) -> Array:
        """Returns how far each box goes from its middle along the root's x, y, z (n, 3) [m]."""
        return np.asarray(np.einsum("nij,nj->ni", np.abs(self.axes), self.halves))


@lru_cache(maxsize=4096)
def extents(solid: str) -> tuple[float, float, float, float, float, float]:
    """Returns middle (x, y, z) and half lengths of the box around a shape given as ``sk:solid``, in its frame [m].

    Raises:
        ValueError: It cannot be read.
    """
    low, high = Solid.from_json(solid).bounds()
    x, y, z = (low + high) / 2.0
    a, b, c = (high - low) / 2.0
    return float(x), float(y), float(z), float(a), float(b), float(c)


def read_boxes(view: WorldView, ids: Sequence[str]) -> Boxes:
    """Returns the boxes of elements, in the order of their ids.

    Raises:
        UnknownName: There is no such element.
    """
    reader = _Reader(view)
    return reader.boxes([reader.read(element) for element in ids])


class _Reader:
    """Collects elements and their frames, then evaluates all together."""

    def __init__(self, view: WorldView) -> None:
        self._view = view
        self._numbers: dict[str, int] = {}
        self._poses: list[Pose | None] = []
        self._parents: list[int] = []
        self._extents: list[_Extents | None] = []
        self._hollow: list[bool] = []
        self._of_class: dict[str, tuple[Value | None, ...]] = {}

    def read(self, element: str) -> int:
        """Returns the number of an element; on first use, it is read with its frames."""
        number = len(self._poses)
        known = self._numbers.setdefault(element, number)
        if known != number:
            return known
        current: str | None = element
        while current is not None:
            current = self._take(current)
        return number

    def _take(self, name: str) -> str | None:
        """Reads one element that has a number, and returns its frame if that was not read yet."""
        element = self._view.element(name)
        own = element.properties
        pose, solid, size, hollow = map(own.get, _READ, self._class_values(element.type))
        self._poses.append(pose if isinstance(pose, Pose) else None)
        self._extents.append(_extents(solid, size))
        self._hollow.append(hollow is True)
        frames = self._view.objects(name, POSE_FRAME)
        if not frames:
            self._parents.append(MAP)
            return None
        parent = self._numbers.setdefault(frames[0], len(self._poses))
        self._parents.append(parent)
        return frames[0] if parent == len(self._poses) else None

    def _class_values(self, class_: str) -> tuple[Value | None, ...]:
        values = self._of_class.get(class_)
        if values is None:
            values = self._of_class[class_] = tuple(self._view.ontology.class_value(class_, name) for name in _READ)
        return values

    def boxes(self, numbers: Sequence[int]) -> Boxes:
        """Returns the boxes of these numbers, in this order."""
        positions, axes, roots = self._frames()
        shapes = np.array([extent or _POINT for extent in self._extents]).reshape(-1, 6)
        every = Boxes(
            centres=positions + np.einsum("nij,nj->ni", axes, shapes[:, :3]),
            halves=shapes[:, 3:],
            axes=axes,
            roots=roots,
            sized=np.array([extent is not None for extent in self._extents], dtype=bool),
            hollow=np.array(self._hollow, dtype=bool),
        )
        return every.take(np.array(numbers, dtype=np.int64))

    def _frames(self) -> tuple[Array, Array, Ints]:
        """Returns the poses of all frames in their roots, level by level down the trees."""
        from scipy.spatial.transform import Rotation  # half a second of imports that most processes never need

        count = len(self._poses)
        poses = [pose or _HERE for pose in self._poses]
        positions = np.array([pose.position for pose in poses]).reshape(count, 3)
        axes = Rotation.from_quat(np.array([pose.orientation for pose in poses]).reshape(count, 4)).as_matrix()
        parents = np.array(self._parents, dtype=np.int64)
        lost = np.array([pose is None for pose in self._poses], dtype=bool)
        roots = np.where(lost, np.arange(count), MAP)
        done = lost | (parents == MAP)
        while True:
            level = np.flatnonzero(~done & done[parents])
            if not len(level):
                break
            above = parents[level]
            positions[level] = positions[above] + np.einsum("nij,nj->ni", axes[above], positions[level])
            axes[level] = axes[above] @ axes[level]
            roots[level] = roots[above]
            done[level] = True
        # The rest are frames in a cycle: a world refuses them, an overlay may contain them.
        roots[~done] = np.flatnonzero(~done)
        return positions, axes, roots


_HERE = Pose()


def _extents(solid: Value | None, size: Value | None) -> _Extents | None:
    """The box around a shape; else one of the stated size, around the frame; else none."""
    if isinstance(solid, str):
        try:
            return extents(solid)
        except ValueError:
            return None  # a class may give an unreadable shape
    if isinstance(size, tuple) and 2 <= len(size) <= 3:
        x, y, z = (*(abs(length) / 2.0 for length in size), 0.0)[:3]
        return 0.0, 0.0, 0.0, x, y, z
    return None


# ---------------------------------------------------------------- boxes of a whole world


_MANY = 200
"""For fewer elements, reading them alone is faster."""


@dataclass(frozen=True, slots=True)
class _Remembered:
    """The boxes of all spatial things of one state."""

    state: Index
    numbers: dict[str, int]
    boxes: Boxes


class BoxMemory:
    """Reads boxes; those of the last used state are cached."""

    def __init__(self) -> None:
        self._last: _Remembered | None = None

    def boxes(self, view: WorldView, ids: Sequence[str]) -> Boxes:
        """Returns the boxes of elements, in the order of their ids.

        Raises:
            UnknownName: There is no such element.
        """
        if len(ids) < _MANY or not isinstance(view, Index):
            return read_boxes(view, ids)
        known = self._of(view)
        numbers = [known.numbers.get(name, -1) for name in ids]
        if -1 in numbers:  # something abstract, or not spatial
            return read_boxes(view, ids)
        return known.boxes.take(np.array(numbers, dtype=np.int64))

    def _of(self, view: Index) -> _Remembered:
        last = self._last
        if last is None or not view.has_relations_of(last.state) or not view.has_elements_of(last.state):
            last = self._last = (last and _brought_up(last, view)) or _read(view)
        return last


def _read(view: Index) -> _Remembered:
    ids = view.instances(SPATIAL_THING)
    return _Remembered(view.copy(), {name: at for at, name in enumerate(ids)}, read_boxes(view, ids))


def _brought_up(last: _Remembered, view: Index) -> _Remembered | None:
    """The boxes of a later state, if its frames are the same and those that changed are below the map."""
    ids = view.instances(SPATIAL_THING)
    if not view.has_relations_of(last.state) or ids != tuple(last.numbers):
        return None
    changed = reached(
        [name for name in ids if view.element(name) is not last.state.element(name)],
        lambda name: view.subjects(POSE_FRAME, name),
    )
    rows = np.array([last.numbers[name] for name in changed], dtype=np.int64)
    new = read_boxes(view, changed)
    if (new.roots != MAP).any():
        return None
    return _Remembered(view.copy(), last.numbers, last.boxes.replaced(rows, new))
