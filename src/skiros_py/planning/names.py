"""PDDL names for the world model's names, both ways and without collisions."""

from __future__ import annotations

import re
from collections.abc import Iterable

__all__ = ["NameMap"]

_RESERVED = frozenset({"and", "or", "not", "exists", "forall", "when", "imply", "object", "either", "define", "domain"})


class NameMap:
    """Gives each name a PDDL name (lower case, letters, digits, '_' and '-'), always the same, and finds it back."""

    def __init__(self, names: Iterable[str] = ()) -> None:
        self._to: dict[str, str] = {}
        self._from: dict[str, str] = {}
        for name in names:
            self.pddl(name)

    def pddl(self, name: str) -> str:
        """Returns the PDDL name of a name; the first caller of two that look alike gets the plain one."""
        if name not in self._to:
            plain = _plain(name)
            candidate, number = plain, 1
            while candidate in self._from or candidate in _RESERVED:
                number += 1
                candidate = f"{plain}-{number}"
            self._to[name] = candidate
            self._from[candidate] = name
        return self._to[name]

    def back(self, pddl_name: str) -> str:
        """Returns the name that a PDDL name stands for.

        Raises:
            KeyError: It stands for none.
        """
        return self._from[pddl_name.lower()]


def _plain(name: str) -> str:
    local = name.partition(":")[2] or name
    snake = re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", local).lower()
    safe = re.sub(r"[^a-z0-9_-]+", "_", snake).strip("_-")
    return safe if safe[:1].isalpha() else f"x{safe}"
