"""Persistent sorted sets of ids: adding to one gives another, and both stay as they are."""

from __future__ import annotations

from bisect import bisect_left

from immutables import Map

__all__ = ["EMPTY", "IdSet"]

_FEW = 32
"""Up to so many ids a sorted tuple is smaller and faster than a tree."""


class IdSet:
    """A set of ids that never changes; :meth:`ids` gives them sorted.

    Few ids are a sorted tuple. Many are a hash tree, of which two sets that differ in one id share nearly all; they are
    sorted when somebody first asks.
    """

    __slots__ = ("_sorted", "_tree")

    def __init__(self, ids: tuple[str, ...] | None = (), tree: Map[str, None] | None = None) -> None:
        self._sorted = ids
        self._tree = tree

    def ids(self) -> tuple[str, ...]:
        """Returns the ids, sorted."""
        if self._sorted is None:
            assert self._tree is not None
            self._sorted = tuple(sorted(self._tree))
        return self._sorted

    def __contains__(self, name: object) -> bool:
        if self._tree is not None:
            return name in self._tree
        return self._sorted is not None and name in self._sorted

    def __len__(self) -> int:
        return len(self.ids() if self._tree is None else self._tree)

    def with_(self, name: str) -> IdSet:
        """Returns the set with one id more."""
        if name in self:
            return self
        if self._tree is not None:
            return IdSet(None, self._tree.set(name, None))
        few = self.ids()
        at = bisect_left(few, name)
        more = (*few[:at], name, *few[at:])
        return IdSet(more) if len(more) <= _FEW else IdSet(more, Map((other, None) for other in more))

    def without(self, name: str) -> IdSet:
        """Returns the set with one id less."""
        if name not in self:
            return self
        if self._tree is None:
            return IdSet(tuple(other for other in self.ids() if other != name))
        tree = self._tree.delete(name)
        return IdSet(None, tree) if len(tree) > _FEW else IdSet(tuple(sorted(tree)))


EMPTY = IdSet()
"""The set of no ids."""
