"""Ids of elements: given once, never again."""

from __future__ import annotations

import re
from functools import lru_cache

from skiros_py.world.names import local_name

__all__ = ["Ids", "is_valid_id"]


_ID = re.compile(r"(?:learned:)?[A-Za-z_][A-Za-z0-9_]{0,199}")
_NUMBERED = re.compile(r"(.+)_(\d{1,15})")
_LONGEST_STEM = 160


def is_valid_id(element_id: str) -> bool:
    """Returns True for at most 200 letters, digits and underscores that do not begin with a digit.

    What is learned has the prefix ``learned:`` before that.
    """
    return isinstance(element_id, str) and _ID.fullmatch(element_id) is not None


class Ids:
    """Which ids were ever given. A transaction keeps a book of its own beside it."""

    def __init__(self, before: Ids | None = None) -> None:
        self._before = before
        self._used: set[str] = set()
        self._last: dict[str, int] = {}

    def used(self, element_id: str) -> bool:
        """Returns True when the id was ever given."""
        return element_id in self._used or (self._before is not None and self._before.used(element_id))

    def claim(self, element_id: str) -> None:
        """Notes that the id is given."""
        self._used.add(element_id)
        numbered = _NUMBERED.fullmatch(element_id)
        if numbered:
            self._raise(numbered[1], int(numbered[2]))

    def next(self, class_: str, *, learned: bool = False) -> str:
        """Gives the next id for an element of a class: ``kitting:RelayBox`` -> ``relay_box_1``."""
        stem = ("learned:" if learned else "") + _stem(class_)
        number = self.highest(stem) + 1
        while self.used(f"{stem}_{number}"):  # given by somebody's hand beyond what is counted
            number += 1
        self.claim(f"{stem}_{number}")
        return f"{stem}_{number}"

    def highest(self, stem: str) -> int:
        """Returns the highest number ever given after a stem ("relay_box"), or 0."""
        before = self._before.highest(stem) if self._before is not None else 0
        return max(before, self._last.get(stem, 0))

    def _raise(self, stem: str, number: int) -> None:
        self._last[stem] = max(number, self._last.get(stem, 0))


@lru_cache(maxsize=4096)
def _stem(class_: str) -> str:
    words = re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", local_name(class_)).lower()
    plain = re.sub(r"\W+", "_", words, flags=re.ASCII).strip("_")
    return (plain if plain[:1].isalpha() else f"element_{plain}")[:_LONGEST_STEM].rstrip("_")
