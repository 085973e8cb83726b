"""The last changes, as they are asked for most: a bounded number of them."""

from __future__ import annotations

import threading
from collections import deque

from skiros_py.world.change import Change

__all__ = ["Recent"]

_MOST_CHANGES = 10_000
_MOST_EDITS = 100_000


class Recent:
    """The changes up to a version, as many as are few; any thread may ask.

    Args:
        version: Number of the last change so far.
    """

    def __init__(self, version: int) -> None:
        self._guard = threading.Lock()
        self._version = version
        self._changes: deque[Change] = deque()
        self._edits = 0

    @property
    def version(self) -> int:
        """Number of the last change."""
        return self._version

    def add(self, change: Change) -> None:
        """Takes the next change, and forgets the oldest where there are too many; the last one is always there."""
        with self._guard:
            self._changes.append(change)
            self._edits += len(change.edits)
            while len(self._changes) > 1 and (len(self._changes) > _MOST_CHANGES or self._edits > _MOST_EDITS):
                self._edits -= len(self._changes.popleft().edits)
            self._version = change.number

    def since(self, version: int) -> tuple[Change, ...] | None:
        """Returns the changes after a version, in order; None where some of them are not here any more."""
        with self._guard:
            wanted = self._version - version
            if wanted > len(self._changes):
                return None
            return tuple(self._changes[at] for at in range(-wanted, 0))
