"""What a world begins with, and where its changes are kept."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Protocol

from skiros_py.world.change import Change
from skiros_py.world.ids import Ids
from skiros_py.world.index import Index

__all__ = ["ChangeLog", "MemoryLog", "Past"]


class ChangeLog(Protocol):
    """Keeps changes in order."""

    @property
    def version(self) -> int:
        """Number of the last change, 0 before the first."""
        ...

    @property
    def first(self) -> int:
        """Number of the oldest change that is remembered."""
        ...

    def append(self, change: Change) -> None:
        """Keeps a change; when this returns, it is kept.

        Raises:
            SkirosError: It cannot be kept, and is not.
        """
        ...

    def since(self, version: int) -> Sequence[Change]:
        """Returns the changes after a version, in order.

        Raises:
            WorldError: Some of them are remembered no longer.
        """
        ...


class MemoryLog:
    """Keeps changes as long as the process lives."""

    def __init__(self) -> None:
        self._changes: list[Change] = []

    @property
    def version(self) -> int:
        """Number of the last change, 0 before the first."""
        return len(self._changes)

    @property
    def first(self) -> int:
        """Number of the oldest change that is remembered."""
        return 1

    def append(self, change: Change) -> None:
        """Keeps a change."""
        self._changes.append(change)

    def since(self, version: int) -> Sequence[Change]:
        """Returns the changes after a version, in order."""
        return tuple(self._changes[version:])


@dataclass(frozen=True, slots=True)
class Past:
    """The state that a world begins with, the ids given so far, and the log of changes that led there and go on."""

    index: Index
    ids: Ids = field(default_factory=Ids)
    log: ChangeLog = field(default_factory=MemoryLog)
