"""PDDL names for the world model's names, both ways and without collisions."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from types import MappingProxyType

_LOGIC = frozenset({"and", "or", "not", "exists", "forall", "when", "imply", "either"})
_STRUCTURE = frozenset({"object", "define", "domain", "problem"})
_NUMBERS = frozenset({"number", "total-cost", "total-time", "increase", "decrease", "assign", "minimize", "maximize"})
RESERVED = _LOGIC | _STRUCTURE | _NUMBERS
"""Words of PDDL itself; a variable, with its question mark, may be called like one."""


class NameMap:
    """Gives each name a PDDL name (lower case, letters, digits, '_' and '-'), deterministically, and maps it back.

    Args:
        names: Names that are mapped first, in this order.
        avoid: Maps whose PDDL names are not reused: some parsers require one name space for everything.
        reserved: Words that are never used.
    """

    def __init__(
        self, names: Iterable[str] = (), *, avoid: Sequence[NameMap] = (), reserved: frozenset[str] = RESERVED
    ) -> None:
        self._reserved = reserved
        self._to: dict[str, str] = {}
        self._from: dict[str, str] = {}
        self._avoid = avoid
        for name in names:
            self.pddl(name)

    def pddl(self, name: str, word: str | None = None) -> str:
        """Returns the PDDL name of a name; of two similar names, the first gets the plain one.

        Args:
            name: The name.
            word: What its PDDL name is made from, where that is not the name itself.
        """
        if name not in self._to:
            plain = _plain(word or name)
            candidate, number = plain, 1
            while self._taken(candidate):
                number += 1
                candidate = f"{plain}-{number}"
            self._to[name] = candidate
            self._from[candidate] = name
        return self._to[name]

    @property
    def known(self) -> Mapping[str, str]:
        """PDDL names by name, of those requested so far; a cheap view."""
        return MappingProxyType(self._to)

    def back(self, pddl_name: str) -> str:
        """Returns the name that a PDDL name stands for.

        Raises:
            KeyError: It is unknown.
        """
        return self._from[pddl_name.lower()]

    def gives(self, pddl_name: str) -> bool:
        """Returns True when the PDDL name stands for something."""
        return pddl_name in self._from

    def _taken(self, candidate: str) -> bool:
        return candidate in self._reserved or any(other.gives(candidate) for other in (self, *self._avoid))


def _plain(name: str) -> str:
    local = name.partition(" #")[0]  # the suffix that makes variables unique is not part of their name
    local = local.partition(":")[2] or local
    snake = re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", local).lower()
    safe = re.sub(r"[^a-z0-9_-]+", "_", snake).strip("_-")
    return safe if safe[:1].isalpha() else f"x{safe}"
