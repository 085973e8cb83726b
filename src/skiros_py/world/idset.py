"""Persistent sorted sets of ids: adding to one gives another, and both stay as they are."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from itertools import chain, islice

__all__ = ["EMPTY", "IdSet"]

_FEW = 32
"""Up to so many ids are kept as one sorted tuple."""
_BLOCK = 256
"""Up to so many ids stand in one block of a larger set."""

_Ids = tuple[str, ...]


class IdSet:
    """A set of ids that never changes; :meth:`ids` gives them sorted, :meth:`some` the first ones only.

    Few ids are a sorted tuple. Many are sorted blocks, of which two sets that differ in one id share all but one: an id
    more or less costs one block and the list of blocks, and nobody ever has to sort.
    """

    __slots__ = ("_blocks", "_ids", "_size")

    def __init__(self, ids: _Ids | None = (), blocks: tuple[_Ids, ...] = (), size: int | None = None) -> None:
        self._ids = ids
        self._blocks = blocks
        self._size = len(ids or ()) if size is None else size

    def ids(self) -> _Ids:
        """Returns the ids, sorted."""
        if self._ids is None:
            self._ids = tuple(chain.from_iterable(self._blocks))
        return self._ids

    def some(self, limit: int, after: str = "") -> _Ids:
        """Returns the first ids that come after a text, sorted, at most so many; costs nothing for the others."""
        if self._ids is not None:
            start = bisect_right(self._ids, after)
            return self._ids[start : start + limit]
        first = self._block_of(after)
        behind = chain.from_iterable(islice(self._blocks, first, None))
        skipped = bisect_right(self._blocks[first], after)
        return tuple(islice(behind, skipped, skipped + limit))

    def __contains__(self, name: object) -> bool:
        if not isinstance(name, str) or not self._size:
            return False
        block = self._blocks[self._block_of(name)] if self._blocks else self.ids()
        at = bisect_left(block, name)
        return at < len(block) and block[at] == name

    def __len__(self) -> int:
        return self._size

    def with_(self, name: str) -> IdSet:
        """Returns the set with one id more."""
        if name in self:
            return self
        if not self._blocks:
            more = _inserted(self.ids(), name)
            return IdSet(more) if len(more) <= _FEW else IdSet(None, (more,), len(more))
        at = self._block_of(name)
        more = _inserted(self._blocks[at], name)
        half = len(more) // 2
        parts = (more,) if len(more) <= _BLOCK else (more[:half], more[half:])
        return IdSet(None, (*self._blocks[:at], *parts, *self._blocks[at + 1 :]), self._size + 1)

    def without(self, name: str) -> IdSet:
        """Returns the set with one id less."""
        if name not in self:
            return self
        if self._size <= _FEW + 1:
            return IdSet(tuple(other for other in self.ids() if other != name))
        at = self._block_of(name)
        less = tuple(other for other in self._blocks[at] if other != name)
        parts = (less,) if less else ()
        return IdSet(None, (*self._blocks[:at], *parts, *self._blocks[at + 1 :]), self._size - 1)

    def _block_of(self, name: str) -> int:
        """The index of the block in which an id stands or would stand."""
        return max(0, bisect_right(self._blocks, name, key=_first) - 1)


def _first(block: _Ids) -> str:
    return block[0]


def _inserted(ids: _Ids, name: str) -> _Ids:
    at = bisect_left(ids, name)
    return (*ids[:at], name, *ids[at:])


EMPTY = IdSet()
"""The set of no ids."""
