"""One SQLite file, used by one process and any of its threads; its faults are told in words."""

from __future__ import annotations

import sqlite3
import threading
from collections.abc import Iterator, Sequence
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any

from skiros_py.errors import FileError, WorldError
from skiros_py.world.journal.schema import check, upgrade

__all__ = ["Database"]

_PAGES_BETWEEN_CHECKPOINTS = 4000
"""How long the write-ahead log grows before it is worked into the file (16 MB)."""

_LEAST_SIZE = 512
"""Bytes of the smallest page that a file of SQLite consists of."""

_DAMAGED = "the file is damaged, or no journal: put a copy of it in its place, or begin in another folder"

_WORDS = (
    ("SQLITE_FULL", "there is no room left for it on the disk: nothing was changed"),
    ("SQLITE_IOERR", "the disk does not take it (is it full, or gone?): nothing was changed"),
    ("SQLITE_CORRUPT", _DAMAGED),
    ("SQLITE_NOTADB", _DAMAGED),
    ("SQLITE_BUSY", "another program has the file open: close that first"),
    ("SQLITE_READONLY", "the file cannot be written: mind the rights of file and folder"),
    ("SQLITE_CANTOPEN", "the file cannot be opened: mind the rights of file and folder"),
    ("SQLITE_PERM", "the file cannot be opened: mind the rights of file and folder"),
)


class Database:
    """An open file; made where it is missing, brought up to date where it is old.

    What is committed outlives the process, however that ends; a power cut may take the last second.

    Attributes:
        path: The file.
    """

    def __init__(self, path: Path) -> None:
        """Opens the file.

        Raises:
            FileError: It cannot be opened or made, is damaged or another program's, or younger than this program.
        """
        self.path = path
        self._guard = threading.RLock()
        self._connection: sqlite3.Connection | None = None
        with self._faults():
            if not path.exists():
                _make(path)
            elif path.stat().st_size < _LEAST_SIZE:  # which SQLite would take for a new one
                raise FileError(path, _DAMAGED)
            self._connection = _connect(path)
            try:
                _run(self._connection, "locking_mode = EXCLUSIVE")
                check(self._connection, path)
                _run(self._connection, "journal_mode = WAL")
                _run(self._connection, "synchronous = NORMAL")
                _run(self._connection, f"wal_autocheckpoint = {_PAGES_BETWEEN_CHECKPOINTS}")
                upgrade(self._connection)
            except BaseException:
                self.close()
                raise

    @contextmanager
    def transaction(self) -> Iterator[sqlite3.Connection]:
        """Gives the connection for writes that are all kept when the block ends, or none if anything raises.

        Raises:
            FileError: They cannot be kept.
            WorldError: The file is closed.
        """
        with self._guard, self._faults():
            connection = self._open()
            connection.execute("BEGIN IMMEDIATE")
            try:
                yield connection
                connection.execute("COMMIT")
            except BaseException:
                if connection.in_transaction:
                    connection.execute("ROLLBACK")
                raise

    @contextmanager
    def reading(self) -> Iterator[None]:
        """Lets nobody write while the block lasts: several queries in it see one state of the file."""
        with self._guard:
            yield

    def rows(self, sql: str, values: Sequence[object] = ()) -> list[tuple[Any, ...]]:
        """Returns the answer to a query.

        Raises:
            FileError: The file cannot be read.
            WorldError: The file is closed.
        """
        with self._guard, self._faults():
            return self._open().execute(sql, values).fetchall()

    def shrink(self) -> None:
        """Gives back the room of what was deleted.

        Raises:
            FileError: There is no room for doing so; the content is as before.
        """
        with self._guard, self._faults():
            connection = self._open()
            connection.execute("VACUUM")
            connection.execute("PRAGMA wal_checkpoint(TRUNCATE)")

    def close(self) -> None:
        """Closes the file; may be called twice."""
        with self._guard, self._faults():
            connection, self._connection = self._connection, None
            if connection is not None:
                connection.close()

    def _open(self) -> sqlite3.Connection:
        if self._connection is None:
            raise WorldError(f"{self.path.parent}: the data directory is closed, nothing is read or written any more")
        return self._connection

    @contextmanager
    def _faults(self) -> Iterator[None]:
        try:
            yield
        except sqlite3.Error as error:
            raise FileError(self.path, _words(error)) from error
        except OSError as error:
            raise FileError(self.path, f"cannot be opened: {error.strerror or error}") from error


def _make(path: Path) -> None:
    """Makes the file under another name, so that there never is a half-made one."""
    log = path.with_name(f"{path.name}-wal")
    if log.exists():
        raise FileError(path, f"the file is gone, and {log.name} is still there: put it back, or remove that too")
    new = path.with_name(f"{path.name}.new")
    for left in (new, new.with_name(f"{new.name}-journal")):
        left.unlink(missing_ok=True)
    with closing(_connect(new)) as connection:
        upgrade(connection)
    new.replace(path)


def _connect(path: Path) -> sqlite3.Connection:
    # No transaction but those that are begun in so many words; threads take turns by our own lock.
    return sqlite3.connect(path, timeout=1.0, isolation_level=None, check_same_thread=False)


def _run(connection: sqlite3.Connection, pragma: str) -> None:
    connection.execute(f"PRAGMA {pragma}").fetchall()


def _words(error: sqlite3.Error) -> str:
    name = getattr(error, "sqlite_errorname", "")
    said = next((words for begin, words in _WORDS if name.startswith(begin)), "it cannot be used")
    return f"{said} ({error})"
