"""A world's initial state, and the storage of its changes."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Protocol

from skiros_py.world.change import Change, GoalsEdit, Writer
from skiros_py.world.ids import Ids
from skiros_py.world.index import Index

GOALS = ""
"""Stands for the goals among the subjects of a change; no element has this id."""


def subjects_of(change: Change) -> frozenset[str]:
    """Returns the subjects of a change: the elements that it marks, and :data:`GOALS`."""
    sets_goals = any(isinstance(edit, GoalsEdit) for edit in change.edits)
    return change.marks() | {GOALS} if sets_goals else change.marks()


class ChangeLog(Protocol):
    """Stores changes in order."""

    @property
    def version(self) -> int:
        """Number of the last change, 0 before the first."""

    @property
    def first(self) -> int:
        """Number of the oldest change that is kept."""

    def append(self, change: Change) -> None:
        """Stores a change.

        What a robot has sensed or done cannot be refused: while the disk cannot be written, it waits in memory.

        Raises:
            SkirosError: It cannot be stored.
        """

    def flush(self) -> None:
        """Stores the changes that could not be stored when they were made.

        Raises:
            DiskFault: They still cannot be.
        """

    def since(self, version: int) -> Sequence[Change]:
        """Returns the changes after a version, in order.

        Raises:
            WorldError: Some of them are no longer kept.
        """

    def undoable(self) -> Change | None:
        """Returns the last stored change by a user that has not been undone yet, or None."""

    def redoable(self) -> Change | None:
        """Returns the last undo that was not reverted, if no edit by a user followed it; otherwise None."""

    def about(self, subjects: Iterable[str], after: int) -> Sequence[Change]:
        """Returns the stored changes after a version that are about any of the subjects, in order.

        Args:
            subjects: Ids of elements; :data:`GOALS`.
            after: The version.
        """


class MemoryLog:
    """Stores changes in memory.

    Attributes:
        first: Number of the oldest change that is kept.
    """

    first = 1

    def __init__(self) -> None:
        self._changes: list[Change] = []

    @property
    def version(self) -> int:
        """Number of the last change, 0 before the first."""
        return len(self._changes)

    def append(self, change: Change) -> None:
        """Stores a change."""
        self._changes.append(change)

    def flush(self) -> None:
        """Has no effect: nothing waits."""

    def since(self, version: int) -> Sequence[Change]:
        """Returns the changes after a version, in order."""
        return tuple(self._changes[version:])

    def undoable(self) -> Change | None:
        """Returns the last change by a user that has not been undone yet, or None."""
        reverted = {change.undoes for change in self._changes}
        undone = {change.undoes for change in self._changes if change.number not in reverted}
        people = (c for c in reversed(self._changes) if c.writer is Writer.PERSON and c.undoes is None)
        return next((change for change in people if change.number not in undone), None)

    def redoable(self) -> Change | None:
        """Returns the last undo that was not reverted, if no edit by a user followed it; otherwise None."""
        reverted = {change.undoes for change in self._changes}
        people = [change for change in self._changes if change.writer is Writer.PERSON]
        edits = {change.number for change in people if change.undoes is None}
        undos = [c for c in people if c.undoes in edits and c.number not in reverted and c.number > max(edits)]
        return undos[-1] if undos else None

    def about(self, subjects: Iterable[str], after: int) -> Sequence[Change]:
        """Returns the changes after a version that are about any of the subjects, in order."""
        wanted = frozenset(subjects)
        return tuple(change for change in self._changes[after:] if wanted & subjects_of(change))


@dataclass(frozen=True, slots=True)
class Past:
    """The state that a world begins with, the ids given so far, and the log of changes that led there and go on."""

    index: Index
    ids: Ids = field(default_factory=Ids)
    log: ChangeLog = field(default_factory=MemoryLog)
