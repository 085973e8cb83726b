"""Boxes: the smallest ones around things along the axes of their own frames, many at a time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from functools import cache, lru_cache
from typing import Self

import numpy as np
from numpy.typing import NDArray

from skiros_py.geometry import Array, Pose, Solid
from skiros_py.world.element import Value
from skiros_py.world.terms import reached
from skiros_py.world.view import WorldView
from skiros_py.world.vocabulary import HOLLOW, POSE, POSE_FRAME, SIZE, SOLID

Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]

MAP = -1
"""The root of frames below the map."""

Extents = tuple[float, float, float, float, float, float]
"""Middle (x, y, z) and half lengths of a box [m]."""
_POINT: Extents = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
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

    def reach(self) -> Array:
        """Returns how far each box goes from its middle along the root's x, y, z (n, 3) [m]."""
        return np.asarray(np.einsum("nij,nj->ni", np.abs(self.axes), self.halves))


def read_boxes(view: WorldView, ids: Sequence[str]) -> Boxes:
    """Returns the boxes of elements, in the order of their ids.

    Raises:
        UnknownName: There is no such element.
    """
    frames: dict[str, tuple[str, ...]] = {}

    def above(name: str) -> tuple[str, ...]:
        return frames.setdefault(name, view.objects(name, POSE_FRAME)[:1])

    @cache
    def of_class(class_: str) -> tuple[Value | None, ...]:
        return tuple(view.ontology.class_value(class_, name) for name in _READ)

    numbers = {name: number for number, name in enumerate(reached(ids, above))}
    elements = [view.element(name) for name in numbers]
    read = [tuple(map(one.properties.get, _READ, of_class(one.type))) for one in elements]
    poses = [pose if isinstance(pose, Pose) else None for pose, *_ in read]
    shapes = [extents(solid, size) for _, solid, size, _ in read]
    parents = [numbers[frames[name][0]] if frames[name] else MAP for name in numbers]
    positions, axes, roots = _placed(poses, np.array(parents, dtype=np.int64))
    bounds = np.array([shape or _POINT for shape in shapes]).reshape(-1, 6)
    every = Boxes(
        centres=positions + np.einsum("nij,nj->ni", axes, bounds[:, :3]),
        halves=bounds[:, 3:],
        axes=axes,
        roots=roots,
        sized=np.array([shape is not None for shape in shapes], dtype=bool),
        hollow=np.array([hollow is True for *_, hollow in read], dtype=bool),
    )
    return every.take(np.array([numbers[name] for name in ids], dtype=np.int64))


def _placed(poses: Sequence[Pose | None], parents: Ints) -> tuple[Array, Array, Ints]:
    """Returns positions and axes of all frames in their roots, level by level down the trees; and the roots."""
    from scipy.spatial.transform import Rotation  # half a second of imports that most processes never need

    count = len(poses)
    own = [pose or _HERE for pose in poses]
    positions = np.array([pose.position for pose in own]).reshape(count, 3)
    axes = Rotation.from_quat(np.array([pose.orientation for pose in own]).reshape(count, 4)).as_matrix()
    lost = np.array([pose is None for pose in poses], dtype=bool)
    roots = np.where(lost, np.arange(count), MAP)
    done = lost | (parents == MAP)
    while len(level := np.flatnonzero(~done & done[parents])):
        above = parents[level]
        positions[level] = positions[above] + np.einsum("nij,nj->ni", axes[above], positions[level])
        axes[level] = axes[above] @ axes[level]
        roots[level] = roots[above]
        done[level] = True
    # The rest are frames in a cycle: a world refuses them, an overlay may contain them.
    roots[~done] = np.flatnonzero(~done)
    return positions, axes, roots


_HERE = Pose()


@lru_cache(maxsize=4096)
def extents(solid: Value | None, size: Value | None = None) -> Extents | None:
    """Returns middle (x, y, z) and half lengths of the box around a shape, in its frame [m].

    Args:
        solid: The shape, given as ``sk:solid``.
        size: Lengths (x, y) or (x, y, z) of a box around the frame, for a thing without a shape [m].

    Returns:
        None if neither is known; a class may give an unreadable shape.
    """
    if isinstance(solid, str):
        try:
            low, high = Solid.from_json(solid).bounds()
        except ValueError:
            return None
        x, y, z = map(float, (low + high) / 2.0)
        a, b, c = map(float, (high - low) / 2.0)
        return x, y, z, a, b, c
    if isinstance(size, tuple) and 2 <= len(size) <= 3:
        x, y, z = (*(abs(length) / 2.0 for length in size), 0.0)[:3]
        return 0.0, 0.0, 0.0, x, y, z
    return None
