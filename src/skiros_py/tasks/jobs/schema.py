"""The tables of the file of jobs, and how older files are migrated."""

from skiros_py.database import COUNTED, Schema
from skiros_py.messages import Message

_FIRST = """
CREATE TABLE jobs (id TEXT PRIMARY KEY, number INTEGER NOT NULL UNIQUE, data TEXT NOT NULL) WITHOUT ROWID;
CREATE TABLE transitions (job TEXT NOT NULL, data TEXT NOT NULL);
CREATE INDEX transitions_by_job ON transitions (job);
CREATE TABLE intents (job TEXT NOT NULL, number INTEGER NOT NULL, data TEXT NOT NULL, PRIMARY KEY (job, number))
    WITHOUT ROWID;
CREATE TABLE trace (job TEXT NOT NULL, data TEXT NOT NULL);
CREATE INDEX trace_by_job ON trace (job);
CREATE TABLE numbers (last INTEGER NOT NULL);
INSERT INTO numbers VALUES (0);
"""

_SECOND = """
ALTER TABLE jobs ADD COLUMN state INTEGER NOT NULL DEFAULT 0;
ALTER TABLE jobs ADD COLUMN changed REAL NOT NULL DEFAULT 0;
UPDATE jobs SET
    state = json_extract(data, '$.state'),
    changed = coalesce(json_extract(data, '$.ended'), json_extract(data, '$.started'),
        json_extract(data, '$.ordered'), 0)
    WHERE json_valid(data);
CREATE INDEX jobs_by_state ON jobs (state, number);
CREATE TABLE receipts (caller TEXT NOT NULL, key TEXT NOT NULL, digest TEXT NOT NULL, job TEXT NOT NULL,
    wall REAL NOT NULL, last TEXT, PRIMARY KEY (caller, key)) WITHOUT ROWID;
CREATE INDEX receipts_by_job ON receipts (job);
CREATE INDEX receipts_by_age ON receipts (wall);
CREATE TABLE announcements (number INTEGER PRIMARY KEY AUTOINCREMENT, wall REAL NOT NULL, trigger TEXT NOT NULL,
    data TEXT NOT NULL);
"""
"""Pages by state without reading all jobs; answers to repeated requests; announcements to forward.

AUTOINCREMENT: numbers are not reused, even if all announcements were delivered and deleted.
"""

_THIRD = """
ALTER TABLE numbers ADD COLUMN version INTEGER NOT NULL DEFAULT 0;
"""
"""The largest version of any removed job: clients holding an old version do not mistake a later job for it."""

_FOURTH = """
CREATE TABLE removed (id TEXT PRIMARY KEY, wall REAL NOT NULL, data TEXT NOT NULL) WITHOUT ROWID;
CREATE INDEX removed_by_age ON removed (wall);
CREATE INDEX jobs_by_change ON jobs (changed, number, state);
"""
"""Removed jobs; pages of changed jobs without reading all jobs."""

SCHEMA = Schema(Message("a list of jobs"), 0x736B6A6F, (_FIRST, _SECOND, _THIRD, _FOURTH, COUNTED))
"""Such a file is marked "skjo"."""
