"""The tables of a record file."""

from __future__ import annotations

from skiros_py.database import Schema

__all__ = ["SCHEMA", "THINNED"]

_TABLES = """
CREATE TABLE meta (key TEXT PRIMARY KEY, data TEXT NOT NULL) WITHOUT ROWID;
CREATE TABLE beginning (part INTEGER PRIMARY KEY, data BLOB NOT NULL);
CREATE TABLE frames (
    id INTEGER PRIMARY KEY,
    start REAL NOT NULL,            -- run time of its first snapshot [s]
    thinned INTEGER NOT NULL,       -- 1 where only the first is left of a block
    data BLOB NOT NULL
);
CREATE TABLE events (id INTEGER PRIMARY KEY, time REAL NOT NULL, data TEXT NOT NULL);
CREATE TABLE trace (id INTEGER PRIMARY KEY, time REAL NOT NULL, task INTEGER NOT NULL, data TEXT NOT NULL);
CREATE TABLE changes (id INTEGER PRIMARY KEY, time REAL NOT NULL, data BLOB NOT NULL);
CREATE TABLE pictures (id INTEGER PRIMARY KEY, time REAL NOT NULL, caption TEXT NOT NULL, data BLOB NOT NULL);
CREATE TABLE tasks (id INTEGER PRIMARY KEY, data TEXT NOT NULL);
CREATE TABLE forgotten (what TEXT PRIMARY KEY, count INTEGER NOT NULL) WITHOUT ROWID;
"""

SCHEMA = Schema("record of a run", "the record of a run", 0x736B7275, (_TABLES,))
"""Such a file is marked "skru"."""

THINNED = ("frames", "pictures", "events", "changes", "trace")
"""The tables that are thinned out where room runs short."""
