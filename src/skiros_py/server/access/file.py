"""The file with the keys and the audit log: ``access.db`` in a data directory."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path

from skiros_py.database import Database, Schema

FILE = "access.db"
"""Name of the file in a data directory."""

_TABLES = """
CREATE TABLE keys (
    id TEXT PRIMARY KEY, name TEXT NOT NULL, role TEXT NOT NULL, digest BLOB NOT NULL, ending TEXT NOT NULL,
    created REAL NOT NULL, expires REAL, revoked REAL, used REAL
) WITHOUT ROWID;
CREATE TABLE audit (number INTEGER PRIMARY KEY AUTOINCREMENT, data TEXT NOT NULL);
"""

_SCHEMA = Schema("list of keys", "the keys of a server", 0x736B6163, (_TABLES,))
"""Application id of such a file: "skac"."""


def open_access(data: Path) -> Database:
    """Opens the file in a data directory; created if missing, readable by its owner only.

    Other processes may use it at the same time: keys are created and revoked from the shell while the server runs.

    Raises:
        FileError: It cannot be opened or created, or is damaged.
    """
    path = data / FILE
    database = Database(path, _SCHEMA, durable=True, shared=True)
    with suppress(OSError):  # some file systems have no permissions; keys are stored hashed in any case
        path.chmod(0o600)
    return database
