"""Ids of elements: those already used, and persistent sorted sets of ids."""

from __future__ import annotations

import re
from bisect import bisect_left, bisect_right
from functools import lru_cache
from itertools import chain, islice
from operator import itemgetter

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
            self._last[numbered[1]] = max(int(numbered[2]), self._last.get(numbered[1], 0))

    def next(self, class_: str, *, learned: bool = False) -> str:
        """Returns the next id for an element of a class: ``kitting:RelayBox`` -> ``relay_box_1``."""
        stem = ("learned:" if learned else "") + _stem(class_)
        number = self.highest(stem) + 1
        while self.used(element_id := f"{stem}_{number}"):  # assigned manually, beyond the counter
            number += 1
        self._used.add(element_id)
        self._last[stem] = number
        return element_id

    def highest(self, stem: str) -> int:
        """Returns the highest number ever used after a stem ("relay_box"), or 0."""
        before = self._before.highest(stem) if self._before is not None else 0
        return max(before, self._last.get(stem, 0))


@lru_cache(maxsize=4096)
def _stem(class_: str) -> str:
    words = re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", local_name(class_)).lower()
    plain = re.sub(r"\W+", "_", words, flags=re.ASCII).strip("_")
    return (plain if plain[:1].isalpha() else f"element_{plain}")[:_LONGEST_STEM].rstrip("_")


# ---------------------------------------------------------------- sorted sets


_BLOCK = 256
"""Maximum number of ids in a block."""

_Ids = tuple[str, ...]


class IdSet:
    """An immutable sorted set of ids.

    It consists of sorted blocks, of which two sets that differ in one id share all but one: adding or removing an id
    copies one block and the list of blocks, and nothing is sorted again.
    """

    __slots__ = ("_blocks", "_ids", "_size")

    def __init__(self, blocks: tuple[_Ids, ...] = ((),), size: int = 0) -> None:
        self._blocks = blocks
        self._ids = blocks[0] if len(blocks) == 1 else None
        self._size = size

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
        first, at, found = self._find(after)
        behind = chain.from_iterable(islice(self._blocks, first, None))
        return tuple(islice(behind, at + found, at + found + limit))

    def __contains__(self, name: object) -> bool:
        return isinstance(name, str) and self._find(name)[2]

    def __len__(self) -> int:
        return self._size

    def with_(self, name: str) -> IdSet:
        """Returns the set with an id added."""
        number, at, found = self._find(name)
        if found:
            return self
        block = self._blocks[number]
        more = (*block[:at], name, *block[at:])
        half = len(more) // 2
        parts = (more,) if len(more) <= _BLOCK else (more[:half], more[half:])
        return IdSet((*self._blocks[:number], *parts, *self._blocks[number + 1 :]), self._size + 1)

    def without(self, name: str) -> IdSet:
        """Returns the set with an id removed."""
        number, at, found = self._find(name)
        if not found:
            return self
        block = self._blocks[number]
        less = (*block[:at], *block[at + 1 :])
        parts = (less,) if less or len(self._blocks) == 1 else ()
        return IdSet((*self._blocks[:number], *parts, *self._blocks[number + 1 :]), self._size - 1)

    def _find(self, name: str) -> tuple[int, int, bool]:
        """The number of the block in which an id is or would be, the place in that, and whether it is there."""
        blocks = self._blocks
        number = max(0, bisect_right(blocks, name, key=itemgetter(0)) - 1) if len(blocks) > 1 else 0
        block = blocks[number]
        at = bisect_left(block, name)
        return number, at, at < len(block) and block[at] == name


EMPTY = IdSet()
"""The set of no ids."""
