"""The tables of a journal file."""

from __future__ import annotations

from skiros_py.database import Schema

__all__ = ["SCHEMA"]

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

SCHEMA = Schema("journal", "the journal of a world", 0x736B696A, (_CHANGES, _MARKS))
"""Such a file is marked "skij"."""
