"""Distances, depths and near pairs of boxes, many at once."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product

import numpy as np
import shapely

from skiros_py.geometry import Array
from skiros_py.world.reasoners.boxes import Bools, Boxes, Ints

_BLOCK = 50_000
"""So many pairs are handed out together: more would only need more memory."""


def candidate_pairs(a: Boxes, b: Boxes, within: tuple[float, float, float]) -> Iterator[tuple[Ints, Ints]]:
    """Yields blocks of pairs (numbers in a, numbers in b) of one root that are close enough, each pair once.

    Args:
        a: Boxes.
        b: Other boxes.
        within: How far apart along the root's x, y, z they may be at most [m].
    """
    for one, other in _blocks(a, b, np.array(within)):
        good = a.roots[one] == b.roots[other]
        if good.any():
            yield one[good], other[good]


def _blocks(a: Boxes, b: Boxes, within: Array) -> Iterator[tuple[Ints, Ints]]:
    """All pairs where there is no limit on the ground; else those that a search tree over the ground finds."""
    if np.isinf(within[:2]).all():
        rows = max(1, _BLOCK // max(1, len(b)))
        for start in range(0, len(a), rows):
            some = np.arange(start, min(start + rows, len(a)))
            yield np.repeat(some, len(b)), np.tile(np.arange(len(b)), len(some))
        return
    far_a, far_b = a.reach() + within, b.reach()
    one, other = shapely.STRtree(_outlines(b.centres, far_b)).query(_outlines(a.centres, far_a))
    close = np.abs(a.centres[one, 2] - b.centres[other, 2]) <= far_a[one, 2] + far_b[other, 2]
    order = np.lexsort((other[close], one[close]))
    one, other = one[close][order], other[close][order]
    for start in range(0, len(one), _BLOCK):
        yield one[start : start + _BLOCK], other[start : start + _BLOCK]


def _outlines(centres: Array, reach: Array) -> np.ndarray:
    low, high = centres - reach, centres + reach
    return np.asarray(shapely.box(low[:, 0], low[:, 1], high[:, 0], high[:, 1]))


# ---------------------------------------------------------------- distances


_CORNERS = np.array(list(product((-1.0, 1.0), repeat=3)))
_PARALLEL = 1e-9
"""Lines whose directions' cross product is shorter than this are taken for parallel."""
_MANY = 2048
"""Pairs whose distances are worked out at once: more would only need more memory."""


def offset_along(a: Boxes, b: Boxes, axis: int) -> Array:
    """Returns how far a's middle is from b's along one of b's axes."""
    return np.asarray(np.einsum("ni,ni->n", a.centres - b.centres, b.axes[:, :, axis]))


def reach_along(a: Boxes, b: Boxes, axis: int) -> Array:
    """Returns how far a goes from its middle along one of b's axes."""
    return np.asarray(np.einsum("nk,nk->n", np.abs(np.einsum("ni,nik->nk", b.axes[:, :, axis], a.axes)), a.halves))


def gap_seen_from_above(a: Boxes, b: Boxes) -> Array:
    """Returns the least gap between both outlines on the ground along any direction; negative where they overlap.

    It is never more than their distance on the ground.
    """
    offset = a.centres[:, :2] - b.centres[:, :2]
    sides = np.concatenate([_sides(a), _sides(b)], axis=2)[:, :2, :]
    across = np.stack([-sides[:, 1, :], sides[:, 0, :]], axis=1)
    return _greatest_gap(offset, sides, np.concatenate([across, offset[:, :, None]], axis=2))


def depth(a: Boxes, b: Boxes) -> Array:
    """Returns how far one would have to be moved until they share no room; negative by a gap where they share none.

    The gap is never more than their distance.
    """
    crosses = np.cross(a.axes.transpose(0, 2, 1)[:, :, None, :], b.axes.transpose(0, 2, 1)[:, None, :, :])
    directions = np.concatenate([a.axes, b.axes, crosses.reshape(-1, 9, 3).transpose(0, 2, 1)], axis=2)
    return -_greatest_gap(a.centres - b.centres, np.concatenate([_sides(a), _sides(b)], axis=2), directions)


def distance(a: Boxes, b: Boxes) -> Array:
    """Returns the distance between both boxes; 0 where they share room."""
    found = np.zeros(len(a))
    apart = np.flatnonzero(depth(a, b) < 0.0)
    for start in range(0, len(apart), _MANY):
        some = apart[start : start + _MANY]
        one, other = a.take(some), b.take(some)
        found[some] = np.minimum.reduce(
            [_corners_to_box(one, other), _corners_to_box(other, one), _edges_to_edges(one, other)]
        )
    return found


def is_closer(a: Boxes, b: Boxes, limit: float) -> Bools:
    """Returns where the distance is at most a limit; quicker than :func:`distance`."""
    middle = _to_box(a.centres[:, None, :], b)[:, 0]
    open_ = np.flatnonzero((middle > limit) & (depth(a, b) >= -limit))
    closer = middle <= limit
    closer[open_] = distance(a.take(open_), b.take(open_)) <= limit
    return closer


def _sides(boxes: Boxes) -> Array:
    """Half sides as vectors, in columns (n, 3, 3)."""
    return boxes.axes * boxes.halves[:, None, :]


def _greatest_gap(offset: Array, sides: Array, directions: Array) -> Array:
    """The greatest gap along any of the directions (n, dimensions, m) between what the half sides span."""
    lengths = np.linalg.norm(directions, axis=1)
    unit = directions / np.where(lengths > _PARALLEL, lengths, 1.0)[:, None, :]
    gaps = np.abs(np.einsum("ni,nim->nm", offset, unit)) - np.abs(np.einsum("nis,nim->nsm", sides, unit)).sum(axis=1)
    return np.asarray(np.where(lengths > _PARALLEL, gaps, -np.inf).max(axis=1))


def _to_box(points: Array, box: Boxes) -> Array:
    """Distances of points (n, m, 3) to the box of their row."""
    local = np.einsum("nmi,nik->nmk", points - box.centres[:, None, :], box.axes)
    return np.asarray(np.linalg.norm(np.maximum(np.abs(local) - box.halves[:, None, :], 0.0), axis=2))


def _corners_to_box(a: Boxes, b: Boxes) -> Array:
    corners = a.centres[:, None, :] + np.einsum("nik,mk->nmi", _sides(a), _CORNERS)
    return np.asarray(_to_box(corners, b).min(axis=1))


def _edges_to_edges(a: Boxes, b: Boxes) -> Array:
    """The least distance between edges that pass each other between their ends; those that do not, corners tell."""
    least = np.full(len(a), np.inf)
    for i, j in product(range(3), repeat=2):
        least = np.minimum(least, _edges_along(a, i, b, j))
    return least


def _edges_along(a: Boxes, i: int, b: Boxes, j: int) -> Array:
    """As above, for the four edges of a along its axis i and the four of b along its axis j."""
    one, other = a.axes[:, None, :, i], b.axes[:, None, :, j]
    normal = np.cross(one, other)
    square = np.einsum("nmi,nmi->nm", normal, normal)
    between = _edge_middles(b, j)[:, None, :, :] - _edge_middles(a, i)[:, :, None, :]
    between = between.reshape(len(a), 16, 3)
    safe = np.where(square > _PARALLEL**2, square, 1.0)
    at_one = np.einsum("nmi,nmi->nm", np.cross(between, other), np.broadcast_to(normal, between.shape)) / safe
    at_other = np.einsum("nmi,nmi->nm", np.cross(between, one), np.broadcast_to(normal, between.shape)) / safe
    passing = (np.abs(at_one) <= a.halves[:, None, i]) & (np.abs(at_other) <= b.halves[:, None, j])
    gaps = np.abs(np.einsum("nmi,nmi->nm", between, np.broadcast_to(normal, between.shape))) / np.sqrt(safe)
    return np.asarray(np.where(passing & (square > _PARALLEL**2), gaps, np.inf).min(axis=1))


def _edge_middles(boxes: Boxes, axis: int) -> Array:
    """Middles of the four edges along an axis (n, 4, 3)."""
    signs = _CORNERS[_CORNERS[:, axis] > 0.0].copy()
    signs[:, axis] = 0.0
    return np.asarray(boxes.centres[:, None, :] + np.einsum("nik,mk->nmi", _sides(boxes), signs))
