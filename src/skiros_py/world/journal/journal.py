"""The changes of a world in a file: acknowledged changes are never lost, and can be queried."""

from __future__ import annotations

import json
import logging
import os
import time
from collections import deque
from collections.abc import Iterable, Sequence
from pathlib import Path

from skiros_py.database import Database
from skiros_py.errors import DiskFault, FileError, UsageError, WorldError
from skiros_py.world.change import Change, Edit, Writer
from skiros_py.world.ids import Ids
from skiros_py.world.index import Index, collection_paused
from skiros_py.world.journal.records import (
    SCHEMA,
    Entry,
    delete,
    insert,
    select,
    select_after,
    select_edits,
)
from skiros_py.world.journal.snapshot import read_piece, snapshot_pieces, unfit
from skiros_py.world.past import Past, subjects_of

_log = logging.getLogger(__name__)

_MOST_CHANGES = 10_000
"""Number of the latest changes that are kept in memory, if they do not have too many edits."""
_MOST_EDITS = 100_000
"""Number of edits of the latest changes that are kept in memory; the last change is always kept."""

_PEOPLE = "writer = 'person' OR undoes IS NOT NULL"
_REVERTED = f"SELECT undoes FROM changes WHERE ({_PEOPLE}) AND undoes IS NOT NULL"  # noqa: S608  all ours
_TAKEN_BACK = f"{_REVERTED} AND number NOT IN ({_REVERTED})"
_UNDOABLE = f"({_PEOPLE}) AND undoes IS NULL AND number NOT IN ({_TAKEN_BACK}) ORDER BY number DESC LIMIT 1"
_LAST_EDIT = f"SELECT number FROM changes WHERE ({_PEOPLE}) AND undoes IS NULL ORDER BY number DESC LIMIT 1"  # noqa: S608
_REDOABLE = (
    f"({_PEOPLE}) AND undoes IS NOT NULL AND undoes NOT IN (SELECT number FROM changes WHERE undoes IS NOT NULL)"  # noqa: S608
    f" AND number NOT IN ({_REVERTED}) AND number > ({_LAST_EDIT}) ORDER BY number DESC LIMIT 1"
)
"""An undo reverts an edit, a redo an undo; after a redo, an undo reverts the edit again."""
_MOST_PROBLEMS = 20


class Journal:
    """A :class:`~skiros_py.world.past.ChangeLog` in a file that survives the process, however it ends.

    Any thread may read; changes are appended by the thread that writes to the world.

    Attributes:
        version: Number of the last change, 0 before the first.
        first: Number of the oldest change that is kept.
    """

    def __init__(self, path: Path) -> None:
        """Opens a journal, or creates a new one.

        Raises:
            FileError: The file cannot be opened or created, is damaged or belongs to another program.
        """
        self._path = path
        self._process = os.getpid()
        self._database = Database(path, SCHEMA)
        try:
            stored = self._database.rows("SELECT version FROM snapshot WHERE part = 0")
            self._snapshot_version = int(stored[0][0]) if stored else 0
            ((first, last),) = self._database.rows("SELECT min(number), max(number) FROM changes")
        except BaseException:
            self._database.close()
            raise
        self.version: int = max(last or 0, self._snapshot_version)
        self.first: int = first or self.version + 1
        self._recent: deque[Change] = deque()
        self._recent_edits = 0
        self._waiting: list[Change] = []
        self._unsure = False

    # ------------------------------------------------------------ the change log

    def append(self, change: Change) -> None:
        """Stores a change durably.

        What a robot has sensed or done cannot be refused: while the disk cannot be written, it waits in memory.

        Raises:
            FileError: It cannot be stored: the disk is full or missing.
        """
        try:
            self.append_all([change])
        except DiskFault as fault:
            if change.writer not in (Writer.SKILL, Writer.SYSTEM):
                raise
            _log.warning("change %d waits in memory: %s", change.number, fault)
            self._waiting.append(change)
            self._remember(change)

    def flush(self) -> None:
        """Stores the changes that wait in memory.

        Raises:
            DiskFault: They still cannot be stored.
        """
        if self._waiting:
            self.append_all(())

    def append_all(self, changes: Sequence[Change]) -> None:
        """Stores several changes, or none.

        Raises:
            FileError: They cannot be stored.
        """
        if os.getpid() != self._process:
            raise FileError(
                self._path, f"this data directory is open in process {self._process}; a copy of that cannot write to it"
            )
        with self._database.reading():
            unsure, self._unsure = self._unsure, True
            with self._database.transaction(_shown((*self._waiting, *changes))) as connection:
                if unsure:  # the last write was cut off, perhaps once it was in the file, and never acknowledged
                    delete(connection, "number > ?", self.version - len(self._waiting))
                for change in (*self._waiting, *changes):
                    insert(connection, change, time.time())
            self._waiting.clear()
            for change in changes:
                self._remember(change)
            self._unsure = False

    def _remember(self, change: Change) -> None:
        self.version = change.number
        self._recent.append(change)
        self._recent_edits += len(change.edits)
        while len(self._recent) > 1 and (len(self._recent) > _MOST_CHANGES or self._recent_edits > _MOST_EDITS):
            self._recent_edits -= len(self._recent.popleft().edits)

    def since(self, version: int) -> Sequence[Change]:
        """Returns the changes after a version, in order.

        Raises:
            WorldError: Some of them are no longer kept.
        """
        with self._database.reading():  # a compaction meanwhile would look like damage
            if version < self.first - 1:
                raise WorldError(
                    f"the changes after version {version} are not remembered: the journal was compacted and begins"
                    f" with change {self.first}"
                )
            wanted = self.version - version
            if wanted <= len(self._recent):
                return tuple(self._recent[at] for at in range(-wanted, 0))
            return (*(entry.change for entry in select_after(self._database, version)), *self._waiting)

    def undoable(self) -> Change | None:
        """Returns the last stored change by a user that has not been undone yet, or None."""
        return next((entry.change for entry in self._select(_UNDOABLE)), None)

    def redoable(self) -> Change | None:
        """Returns the last undo that was not reverted, if no edit by a user followed it; otherwise None."""
        return next((entry.change for entry in self._select(_REDOABLE)), None)

    def about(self, subjects: Iterable[str], after: int) -> Sequence[Change]:
        """Returns the remembered changes after a version that are about any of the subjects, in order."""
        condition = (
            "number IN (SELECT number FROM marks WHERE number > ?"
            " AND element IN (SELECT value FROM json_each(?))) ORDER BY number"
        )
        wanted = frozenset(subjects)
        entries = self._select(condition, (after, json.dumps(sorted(wanted))))
        return (*(entry.change for entry in entries), *(one for one in self._waiting if wanted & subjects_of(one)))

    # ------------------------------------------------------------ history

    def history(self, element: str | None = None, *, last: int | None = None) -> tuple[Entry, ...]:
        """Returns the remembered changes of an element, which may be gone, or all; in order.

        Args:
            element: Its id.
            last: How many of the latest ones; None for all.
        """
        about, values = _about(element)
        limit = -1 if last is None else last
        return tuple(reversed(self._select(f"{about} ORDER BY number DESC LIMIT ?", (*values, limit))))

    def page(
        self, beyond: int, limit: int, *, element: str | None = None, newest_first: bool = False
    ) -> tuple[Entry, ...]:
        """Returns the beginnings of some of the remembered changes of an element, which may be gone, or of all.

        Args:
            beyond: Only changes after this number; with ``newest_first``, only those before it.
            limit: How many at most.
            element: Its id.
            newest_first: True to go back in time.
        """
        about, values = _about(element)
        order = "number < ? ORDER BY number DESC LIMIT ?" if newest_first else "number > ? ORDER BY number LIMIT ?"
        return tuple(select(self._database, f"{about} AND {order}", (*values, beyond, limit), whole=False))

    def edits(self, head: Entry, start: int, most: int) -> Sequence[Edit]:
        """Returns some edits of a remembered change.

        Args:
            head: Its beginning.
            start: The first of them.
            most: How many at most.
        """
        here = head.change.edits[start : start + most]
        missing = min(most, head.edits - start) - len(here)
        if missing <= 0:
            return here
        return (*here, *select_edits(self._database, head.change.number, start + len(here), missing))

    def undoable_entry(self) -> Entry | None:
        """Returns the beginning of the last remembered change by a person that was not undone yet, or None."""
        return next(iter(select(self._database, _UNDOABLE, whole=False)), None)

    def redoable_entry(self) -> Entry | None:
        """Returns the beginning of the undo that a redo would revert, or None."""
        return next(iter(select(self._database, _REDOABLE, whole=False)), None)

    def was_given(self, element: str) -> bool:
        """Returns True when there was an element of that id at any time."""
        return bool(self._database.rows("SELECT 1 FROM given_ids WHERE id = ?", (element,)))

    # ------------------------------------------------------------ opening and compaction

    def past(self, beginning: Index) -> Past:
        """Reads the state that the changes led to.

        Args:
            beginning: What there is without any change: the individuals of the ontology.

        Raises:
            FileError: The file is damaged, or its content does not fit the ontology.
        """
        with collection_paused():
            index = beginning.copy()
            self._read_snapshot(index)
            for entry in select_after(self._database, self._snapshot_version):
                try:
                    index.take(entry.change)
                except KeyError as error:
                    reason = f"the file is damaged: change {entry.change.number} is about {error}, which was not there"
                    raise FileError(self._database.path, f"{reason} then") from None
            problems = list(unfit(index))
            if problems:
                says = "does not fit the ontology, which was another when it was written:"
                raise FileError(self._database.path, "\n  - ".join([says, *problems[:_MOST_PROBLEMS]]))
            return Past(index, self.ids(), self)

    def ids(self) -> Ids:
        """Returns every id that was ever given."""
        ids = Ids()
        for (name,) in self._database.rows("SELECT id FROM given_ids"):
            ids.claim(name)
        return ids

    @property
    def since_snapshot(self) -> int:
        """How many changes must be done again when the file is opened."""
        return self.version - self._snapshot_version

    def compact(self, state: Index, keep: int | None = None) -> None:
        """Keeps a state as a whole, so that opening is quick, and forgets old changes.

        Where a later state is kept already, as another thread may have done just now, nothing happens.

        Args:
            state: The state.
            keep: How many changes up to that one are still remembered; None for as many as now.

        Raises:
            FileError: There is no room for it; nothing was changed.
            UsageError: The number is negative.
        """
        if keep is not None and keep < 0:
            raise UsageError(f"keep: how many changes are remembered, a number from 0, not {keep}")
        with self._database.reading():  # readers must not see the file and the in-memory state out of step
            self.flush()
            version = state.version
            if version < self._snapshot_version:
                return
            with self._database.transaction(f"a snapshot of version {version}") as connection:
                connection.execute("DELETE FROM snapshot")
                rows = ((part, version, *texts) for part, texts in enumerate(snapshot_pieces(state)))
                connection.executemany("INSERT INTO snapshot VALUES (?, ?, ?, ?)", rows)
                if keep is not None:
                    delete(connection, "number <= ?", version - keep)
            self._snapshot_version = version
            if keep is not None:
                self.first = max(self.first, version - keep + 1)
                try:
                    self._database.shrink()
                except FileError as error:
                    _log.warning("compacted, but the file is as long as before: %s", error)

    def close(self) -> None:
        """Closes the file; may be called twice.

        Raises:
            DiskFault: Changes that wait in memory cannot be stored: they are lost.
        """
        try:
            self.flush()
        except DiskFault as fault:
            lost, self._waiting = self._waiting, []
            numbers = f"{lost[0].number} to {lost[-1].number}"
            raise DiskFault(self._path, f"the last changes ({numbers}) are lost: {fault.reason}") from fault
        finally:
            self._database.close()

    def _select(self, condition: str, values: Sequence[object] = ()) -> list[Entry]:
        with self._database.reading():  # a change may lie in several tables
            return select(self._database, condition, values)

    def _read_snapshot(self, index: Index) -> None:
        ((pieces,),) = self._database.rows("SELECT count(*) FROM snapshot")
        for part in range(pieces):
            rows = self._database.rows("SELECT edits, stamps FROM snapshot WHERE part = ?", (part,))
            try:
                read_piece(index, *rows[0])
            except (ValueError, IndexError) as error:
                reason = f"the file is damaged: piece {part} of the snapshot cannot be understood: {error}"
                raise FileError(self._database.path, reason) from None


def _about(element: str | None) -> tuple[str, Sequence[str]]:
    """Returns the condition, in SQL, for changes of an element, or for all; and its values."""
    return ("1", ()) if element is None else ("number IN (SELECT number FROM marks WHERE element = ?)", (element,))


def _shown(changes: Sequence[Change]) -> str:
    """Returns changes in words, for people."""
    if len(changes) > 1:
        return f"changes {changes[0].number} to {changes[-1].number}"
    return "".join(f"change {one.number} by {one.author}: {one.reason}" for one in changes)
