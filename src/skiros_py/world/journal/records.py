"""Single changes in the tables of a journal."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from skiros_py.database import Database
from skiros_py.errors import FileError
from skiros_py.world.change import Change, Edit, ElementEdit
from skiros_py.world.journal.codec import LONGEST_PART, decode_change, decode_edits, encode_change
from skiros_py.world.past import subjects_of

__all__ = [
    "Entry",
    "Head",
    "delete_from",
    "delete_until",
    "insert",
    "select",
    "select_after",
    "select_edits",
    "select_heads",
]

_SELECT = "SELECT number, wall, more, data FROM changes WHERE "
_SELECT_HEADS = (
    "SELECT number, wall, more, data, (SELECT json_array_length(edits) FROM more_edits"
    " WHERE more_edits.number = changes.number AND part = changes.more - 1) FROM changes WHERE "
)
_AT_ONCE = 500


@dataclass(frozen=True, slots=True)
class Entry:
    """A change as the journal remembers it.

    Attributes:
        change: The change.
        wall: When it was written [s since 1970, UTC].
    """

    change: Change
    wall: float


@dataclass(frozen=True, slots=True)
class Head:
    """The beginning of a change: all of it but the edits after the first thousand.

    Attributes:
        change: The change, with its first edits only.
        wall: When it was written [s since 1970, UTC].
        edits: How many edits it has.
    """

    change: Change
    wall: float
    edits: int


def insert(connection: sqlite3.Connection, change: Change, wall: float) -> None:
    """Writes a change, which elements it is about, and which ids it gave."""
    first, *more = encode_change(change)
    number = change.number
    row = (number, wall, change.writer.value, change.undoes, len(more), first)
    connection.execute("INSERT INTO changes VALUES (?, ?, ?, ?, ?, ?)", row)
    if more:
        rows = ((number, part, edits) for part, edits in enumerate(more))
        connection.executemany("INSERT INTO more_edits VALUES (?, ?, ?)", rows)
    marks = [(subject, number) for subject in sorted(subjects_of(change))]
    connection.executemany("INSERT INTO marks VALUES (?, ?)", marks)
    given = [(edit.element,) for edit in change.edits if isinstance(edit, ElementEdit) and edit.new is not None]
    if given:
        connection.executemany("INSERT OR IGNORE INTO given_ids VALUES (?)", given)


def delete_from(connection: sqlite3.Connection, number: int) -> None:
    """Deletes a change and all after it; ids stay given."""
    connection.execute("DELETE FROM changes WHERE number >= ?", (number,))
    connection.execute("DELETE FROM more_edits WHERE number >= ?", (number,))
    connection.execute("DELETE FROM marks WHERE number >= ?", (number,))


def delete_until(connection: sqlite3.Connection, number: int) -> None:
    """Deletes a change and all before it; ids stay given."""
    connection.execute("DELETE FROM changes WHERE number <= ?", (number,))
    connection.execute("DELETE FROM more_edits WHERE number <= ?", (number,))
    connection.execute("DELETE FROM marks WHERE number <= ?", (number,))


def select(database: Database, condition: str, values: Sequence[object] = ()) -> list[Entry]:
    """Reads the changes for which a condition holds (SQL after WHERE).

    Raises:
        FileError: The file cannot be read, or a change cannot be understood.
    """
    rows = database.rows(_SELECT + condition, values)
    return [_entry(database, *row) for row in rows]


def select_after(database: Database, version: int) -> Iterator[Entry]:
    """Reads all changes after a version, in order, some at a time.

    Raises:
        FileError: The file cannot be read, or a change is missing or cannot be understood.
    """
    while True:
        entries = select(database, "number > ? ORDER BY number LIMIT ?", (version, _AT_ONCE))
        for entry in entries:
            if entry.change.number != version + 1:
                raise FileError(database.path, f"the file is damaged: change {version + 1} is missing")
            yield entry
            version += 1
        if len(entries) < _AT_ONCE:
            return


def select_heads(database: Database, condition: str, values: Sequence[object] = ()) -> list[Head]:
    """Reads the beginnings of the changes for which a condition holds (SQL after WHERE), in one query.

    So whoever writes meanwhile waits for the query only, not until all is understood.

    Raises:
        FileError: The file cannot be read, or a change cannot be understood.
    """
    return [_head(database, *row) for row in database.rows(_SELECT_HEADS + condition, values)]


def _head(database: Database, number: int, wall: float, more: int, data: str, last: int | None) -> Head:
    entry = _entry(database, number, wall, 0, data)
    total = more * LONGEST_PART + (last or 0) if more else len(entry.change.edits)
    return Head(entry.change, wall, total)


def select_edits(database: Database, number: int, start: int, most: int) -> list[Edit]:
    """Reads some edits of a change, from the first beyond a thousand on; the others are in its head.

    Args:
        database: The journal.
        number: Number of the change.
        start: The first edit to read, from :data:`~skiros_py.world.journal.codec.LONGEST_PART` on.
        most: How many of them at most.

    Raises:
        FileError: The file cannot be read.
    """
    first, last = start // LONGEST_PART - 1, (start + most - 1) // LONGEST_PART - 1
    sql = "SELECT edits FROM more_edits WHERE number = ? AND part BETWEEN ? AND ? ORDER BY part"
    found = [edit for (text,) in database.rows(sql, (number, first, last)) for edit in decode_edits(text)]
    skipped = start - (first + 1) * LONGEST_PART
    return found[skipped : skipped + most]


def _entry(database: Database, number: int, wall: float, more: int, data: str) -> Entry:
    sql = "SELECT edits FROM more_edits WHERE number = ? ORDER BY part"
    others: list[Any] = [edits for (edits,) in database.rows(sql, (number,))] if more else []
    try:
        change = decode_change(data, others)
    except ValueError as error:
        raise FileError(database.path, f"the file is damaged: change {number} cannot be understood: {error}") from None
    if len(others) != more or change.number != number:
        raise FileError(database.path, f"the file is damaged: change {number} is not whole")
    return Entry(change, wall)
