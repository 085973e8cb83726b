"""Ids of elements: those already used, and persistent sorted sets of ids."""

from __future__ import annotations

import re
from bisect import bisect_left, bisect_right
from functools import lru_cache
from itertools import chain, islice

from skiros_py.world.names import local_name

_ID = re.compile(r"(?:learned:)?[A-Za-z_][A-Za-z0-9_]{0,199}")
_NUMBERED = re.compile(r"(.+)_(\d{1,15})")
_LONGEST_STEM = 160


def is_valid_id(element_id: str) -> bool:
    """Returns True for at most 200 letters, digits and underscores that do not begin with a digit.

    Ids of learned concepts have the prefix ``learned:`` before that.
    """
    return isinstance(element_id, str) and _ID.fullmatch(element_id) is not None


class Ids:
    """All ids ever used. A transaction has a set of its own on top of it."""

    def __init__(self, before: Ids | None = None) -> None:
        self._before = before
        self._used: set[str] = set()
        self._last: dict[str, int] = {}

    def used(self, element_id: str) -> bool:
        """Returns True if the id was ever used."""
        return element_id in self._used or (self._before is not None and self._before.used(element_id))

    def claim(self, element_id: str) -> None:
        """Marks an id as used."""
        self._used.add(element_id)
        numbered = _NUMBERED.fullmatch(element_id)
        if numbered:
            self._raise(numbered[1], int(numbered[2]))

    def next(self, class_: str, *, learned: bool = False) -> str:
        """Returns the next id for an element of a class: ``kitting:RelayBox`` -> ``relay_box_1``."""
        stem = ("learned:" if learned else "") + _stem(class_)
        number = self.highest(stem) + 1
        while self.used(f"{stem}_{number}"):  # assigned manually, beyond the counter
            number += 1
        self.claim(f"{stem}_{number}")
        return f"{stem}_{number}"

    def highest(self, stem: str) -> int:
        """Returns the highest number ever used after a stem ("relay_box"), or 0."""
        before = self._before.highest(stem) if self._before is not None else 0
        return max(before, self._last.get(stem, 0))

    def _raise(self, stem: str, number: int) -> None:
        self._last[stem] = max(number, self._last.get(stem, 0))


@lru_cache(maxsize=4096)
def _stem(class_: str) -> str:
    words = re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", local_name(class_)).lower()
    plain = re.sub(r"\W+", "_", words, flags=re.ASCII).strip("_")
    return (plain if plain[:1].isalpha() else f"element_{plain}")[:_LONGEST_STEM].rstrip("_")


# ---------------------------------------------------------------- sorted sets


_FEW = 32
"""Maximum number of ids in a single sorted tuple."""
_BLOCK = 256
"""Maximum number of ids in a block of a larger set."""

_Ids = tuple[str, ...]


class IdSet:
    """An immutable sorted set of ids.

    A small set is a sorted tuple. A large one consists of sorted blocks, of which two sets that differ in one id share
    all but one: adding or removing an id copies one block and the list of blocks, and nothing is sorted again.
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
        """Returns the first ids that sort after a text, at most ``limit``, without reading the others."""
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
        """Returns the set with an id added."""
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
        """Returns the set with an id removed."""
        if name not in self:
            return self
        if self._size <= _FEW + 1:
            return IdSet(tuple(other for other in self.ids() if other != name))
        at = self._block_of(name)
        less = tuple(other for other in self._blocks[at] if other != name)
        parts = (less,) if less else ()
        return IdSet(None, (*self._blocks[:at], *parts, *self._blocks[at + 1 :]), self._size - 1)

    def _block_of(self, name: str) -> int:
        """The index of the block in which an id is or would be."""
        return max(0, bisect_right(self._blocks, name, key=_first) - 1)


def _first(block: _Ids) -> str:
    return block[0]


def _inserted(ids: _Ids, name: str) -> _Ids:
    at = bisect_left(ids, name)
    return (*ids[:at], name, *ids[at:])


EMPTY = IdSet()
"""The set of no ids."""
