"""The tables of a journal file: each version of them is what the one before was, and one step more."""

from __future__ import annotations

import sqlite3
from collections.abc import Sequence
from pathlib import Path

from skiros_py.errors import FileError

__all__ = ["APPLICATION", "MIGRATIONS", "check", "upgrade"]

APPLICATION = 0x736B696A
"""Marks a file as a journal, among all the files that SQLite writes: "skij"."""

_CHANGES = """
CREATE TABLE changes (
    number INTEGER PRIMARY KEY,
    wall REAL NOT NULL,         -- when it was written [s since 1970]
    writer TEXT NOT NULL,
    undoes INTEGER,
    more INTEGER NOT NULL,      -- how many texts of further edits there are
    data TEXT NOT NULL
);
CREATE INDEX changes_by_people ON changes (number) WHERE writer = 'person' OR undoes IS NOT NULL;
CREATE TABLE more_edits (
    number INTEGER NOT NULL,
    part INTEGER NOT NULL,
    edits TEXT NOT NULL,
    UNIQUE (number, part)
);
CREATE TABLE snapshot (
    part INTEGER PRIMARY KEY,
    version INTEGER NOT NULL,
    edits TEXT NOT NULL,        -- what leads from nothing to the state
    stamps TEXT NOT NULL        -- the last change of each element, and when
);
CREATE TABLE given_ids (id TEXT PRIMARY KEY) WITHOUT ROWID;
"""

_MARKS = """
CREATE TABLE marks (
    element TEXT NOT NULL,      -- '' stands for the goals
    number INTEGER NOT NULL,
    PRIMARY KEY (element, number)
) WITHOUT ROWID;
CREATE TEMP VIEW edits AS
    SELECT changes.number AS number, edit.value AS edit FROM changes, json_each(changes.data, '$.edits') AS edit
    UNION ALL
    SELECT more_edits.number, edit.value FROM more_edits, json_each(more_edits.edits) AS edit;
INSERT OR IGNORE INTO marks SELECT json_extract(edit, '$.element'), number FROM edits
    WHERE json_extract(edit, '$.edit') IN ('element', 'placement', 'property');
INSERT OR IGNORE INTO marks SELECT json_extract(edit, '$.subject'), number FROM edits
    WHERE json_extract(edit, '$.edit') = 'relation';
INSERT OR IGNORE INTO marks SELECT json_extract(edit, '$.object'), number FROM edits
    WHERE json_extract(edit, '$.edit') = 'relation';
INSERT OR IGNORE INTO marks SELECT '', number FROM edits WHERE json_extract(edit, '$.edit') = 'goals';
DROP VIEW edits;
"""

MIGRATIONS: Sequence[str] = (_CHANGES, _MARKS)
"""SQL that leads from one version of the tables to the next; the first makes version 1."""


def check(connection: sqlite3.Connection, path: Path) -> None:
    """Reads what a file is, and changes nothing.

    Raises:
        FileError: It is no journal, or a later version of this program wrote it.
        sqlite3.Error: The file is damaged or cannot be read.
    """
    if _number(connection, "application_id") != APPLICATION:
        raise FileError(path, "is the file of another program, not the journal of a world: choose another folder")
    version = _number(connection, "user_version")
    if version > len(MIGRATIONS):
        raise FileError(
            path,
            f"has tables of version {version}, and this program knows those up to {len(MIGRATIONS)}:"
            " open it with the program that wrote it, or a later one",
        )


def upgrade(connection: sqlite3.Connection) -> None:
    """Brings a file, empty or old, to the present version of the tables; each step is done whole or not at all.

    Raises:
        sqlite3.Error: The file is damaged or cannot be written.
    """
    for number in range(_number(connection, "user_version"), len(MIGRATIONS)):
        _run(connection, number)


def _run(connection: sqlite3.Connection, number: int) -> None:
    steps = MIGRATIONS[number]
    mark = f"PRAGMA application_id = {APPLICATION}; PRAGMA user_version = {number + 1};"
    try:
        connection.executescript(f"BEGIN IMMEDIATE; {steps} {mark} COMMIT;")
    except BaseException:
        if connection.in_transaction:
            connection.execute("ROLLBACK")
        raise


def _number(connection: sqlite3.Connection, pragma: str) -> int:
    ((value,),) = connection.execute(f"PRAGMA {pragma}").fetchall()
    return int(value)
