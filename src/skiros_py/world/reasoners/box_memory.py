"""Boxes of a whole world, remembered while nothing changes: a query asks for them again and again."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from skiros_py.world.index import Index
from skiros_py.world.reasoners.boxes import MAP, Boxes, read_boxes
from skiros_py.world.vocabulary import POSE_FRAME, SPATIAL_THING

if TYPE_CHECKING:
    from skiros_py.world.view import WorldView

__all__ = ["BoxMemory"]

_MANY = 200
"""For fewer elements it is quicker to read them than everything."""


@dataclass(frozen=True, slots=True)
class _Remembered:
    """The boxes of all spatial things of one state."""

    state: Index
    numbers: dict[str, int]
    boxes: Boxes


class BoxMemory:
    """Reads boxes; those of the state that was asked about last, it knows already."""

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
    """The boxes of a later state, if the same things hang on the same frames and what changed hangs on the map."""
    ids = view.instances(SPATIAL_THING)
    if not view.has_relations_of(last.state) or ids != tuple(last.numbers):
        return None
    changed = _with_what_hangs_on(view, (n for n in ids if view.element(n) is not last.state.element(n)))
    rows = np.array([last.numbers[name] for name in changed], dtype=np.int64)
    new = read_boxes(view, changed)
    if (new.roots != MAP).any():
        return None
    return _Remembered(view.copy(), last.numbers, last.boxes.replaced(rows, new))


def _with_what_hangs_on(view: Index, elements: Iterable[str]) -> tuple[str, ...]:
    found: dict[str, None] = {}
    waiting = list(elements)
    while waiting:
        current = waiting.pop()
        if current not in found:
            found[current] = None
            waiting += view.subjects(POSE_FRAME, current)
    return tuple(found)
