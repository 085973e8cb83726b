"""Which pairs of boxes may be related at all, before anything is worked out exactly."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import shapely

from skiros_py.geometry import Array
from skiros_py.world.reasoners.boxes import Boxes, Ints

__all__ = ["candidate_pairs"]

_FEW = 200_000
"""So many pairs are compared one with each; a search tree pays beyond."""
_BLOCK = 50_000
"""So many pairs are handed out together: more would only need more memory."""


def candidate_pairs(a: Boxes, b: Boxes, within: tuple[float, float, float]) -> Iterator[tuple[Ints, Ints]]:
    """Yields blocks of pairs (numbers in a, numbers in b) of one root that are close enough, each pair once.

    Args:
        a: Boxes.
        b: Other boxes.
        within: How far apart along the root's x, y, z they may be at most [m].
    """
    for block in _blocks(a, b, np.array(within)):
        one, other = block
        good = a.roots[one] == b.roots[other]
        if good.any():
            yield one[good], other[good]


def _blocks(a: Boxes, b: Boxes, within: Array) -> Iterator[tuple[Ints, Ints]]:
    if np.isinf(within[:2]).all() or len(a) * len(b) <= _FEW:
        rows = max(1, _BLOCK // max(1, len(b)))
        for start in range(0, len(a), rows):
            yield _compared(a, b, np.arange(start, min(start + rows, len(a))), within)
        return
    one, other = _searched(a, b, within)
    for start in range(0, len(one), _BLOCK):
        yield one[start : start + _BLOCK], other[start : start + _BLOCK]


def _compared(a: Boxes, b: Boxes, rows: Ints, within: Array) -> tuple[Ints, Ints]:
    """The pairs of some rows of a, compared one with each."""
    if np.isinf(within).all():
        return np.repeat(rows, len(b)), np.tile(np.arange(len(b)), len(rows))
    some = a.take(rows)
    close = np.ones((len(rows), len(b)), dtype=bool)
    for k, (own, far) in enumerate(zip(some.reach().T, b.reach().T, strict=True)):
        apart = np.abs(some.centres[:, None, k] - b.centres[None, :, k])
        close &= apart <= own[:, None] + far[None, :] + within[k]
    one, other = np.nonzero(close)
    return rows[one], other


def _searched(a: Boxes, b: Boxes, within: Array) -> tuple[Ints, Ints]:
    """All pairs, found in a search tree over the ground."""
    far_a, far_b = a.reach() + within, b.reach()
    tree = shapely.STRtree(_outlines(b.centres, far_b))
    one, other = tree.query(_outlines(a.centres, far_a))
    close = np.abs(a.centres[one, 2] - b.centres[other, 2]) <= far_a[one, 2] + far_b[other, 2]
    order = np.lexsort((other[close], one[close]))
    return one[close][order], other[close][order]


def _outlines(centres: Array, reach: Array) -> np.ndarray:
    low, high = centres - reach, centres + reach
    return np.asarray(shapely.box(low[:, 0], low[:, 1], high[:, 0], high[:, 1]))
