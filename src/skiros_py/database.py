"""One SQLite file, used by one process and any of its threads; its faults are reported in words."""

from __future__ import annotations

import os
import sqlite3
import threading
from collections.abc import Iterable, Iterator, Sequence
from contextlib import closing, contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from skiros_py.errors import FileError, WorldError

_PAGES_BETWEEN_CHECKPOINTS = 4000
"""How long the write-ahead log grows before it is worked into the file (16 MB)."""

_PAGES_AT_MOST = 50_000
"""The same where the log is worked into the file beside what goes on, should that ever not come round (200 MB)."""

_BETWEEN_LOOKS = 0.5
"""How often is looked whether the log has to be worked into the file, beside what goes on [s]."""

_LEAST_SIZE = 512
"""Bytes of the smallest page that a file of SQLite consists of."""

_WORDS = (
    ("SQLITE_FULL", "there is no room left for it on the disk: nothing was changed"),
    ("SQLITE_IOERR", "the disk does not take it (is it full, or gone?): nothing was changed"),
    ("SQLITE_CORRUPT", ""),
    ("SQLITE_NOTADB", ""),
    ("SQLITE_BUSY", "another program has the file open: close that first"),
    ("SQLITE_READONLY", "the file cannot be written: mind the rights of file and folder"),
    ("SQLITE_CANTOPEN", "the file cannot be opened: mind the rights of file and folder"),
    ("SQLITE_PERM", "the file cannot be opened: mind the rights of file and folder"),
)


@dataclass(frozen=True, slots=True)
class Schema:
    """The tables of a kind of file: each version of them is what the one before was, and one step more.

    Attributes:
        kind: What such a file is, in one word: "journal".
        what: The same with what it is of: "the journal of a world".
        application: Marks such a file among all the files that SQLite writes.
        migrations: SQL that leads from one version of the tables to the next; the first makes version 1.
    """

    kind: str
    what: str
    application: int
    migrations: Sequence[str]

    def check(self, connection: sqlite3.Connection, path: Path) -> None:
        """Reads what a file is, and changes nothing.

        Raises:
            FileError: It is of another kind, or a later version of this program wrote it.
            sqlite3.Error: The file is damaged or cannot be read.
        """
        if _number(connection, "application_id") != self.application:
            raise FileError(path, f"is the file of another program, not {self.what}: choose another folder")
        version = _number(connection, "user_version")
        if version > len(self.migrations):
            raise FileError(
                path,
                f"has tables of version {version}, and this program knows those up to {len(self.migrations)}:"
                " open it with the program that wrote it, or a later one",
            )

    def upgrade(self, connection: sqlite3.Connection) -> None:
        """Brings a file, empty or old, to the present version of the tables; each step is done whole or not at all.

        Raises:
            sqlite3.Error: The file is damaged or cannot be written.
        """
        for number in range(_number(connection, "user_version"), len(self.migrations)):
            self._run(connection, number)

    def _run(self, connection: sqlite3.Connection, number: int) -> None:
        steps = self.migrations[number]
        mark = f"PRAGMA application_id = {self.application}; PRAGMA user_version = {number + 1};"
        try:
            connection.executescript(f"BEGIN IMMEDIATE; {steps} {mark} COMMIT;")
        except BaseException:
            if connection.in_transaction:
                connection.execute("ROLLBACK")
            raise

    @property
    def damaged(self) -> str:
        """What is said of a file that cannot be made out."""
        return f"the file is damaged, or no {self.kind}: put a copy of it in its place, or begin in another folder"


class Database:
    """An open file; made where it is missing, brought up to date where it is old.

    What is committed outlives the process, however that ends; a power cut may take the last second of what is not
    durable.

    Attributes:
        path: The file.
    """

    def __init__(
        self, path: Path, schema: Schema, *, durable: bool = False, shared: bool = False, lookups: bool = False
    ) -> None:
        """Opens the file.

        Args:
            path: The file.
            schema: Its tables.
            durable: True where what is committed has to outlive a power cut as well; each commit waits for the disk.
            shared: True where other processes may read what is committed meanwhile.
            lookups: True where :meth:`looked_up` is used; others may then read, too. Commits do not wait then
                until the write-ahead log was worked into the file: a thread sees to that.

        Raises:
            FileError: It cannot be opened or made, is damaged or another program's, or younger than this program.
        """
        self.path = path
        self._schema = schema
        self._durable = durable
        self._guard = threading.RLock()
        self._commits = self._synced = 0
        self._connection: sqlite3.Connection | None = None
        self._looking = threading.Lock()
        self._looker: sqlite3.Connection | None = None
        self._checkpoints: _Checkpoints | None = None
        with self._faults():
            if not path.exists():
                _make(path, schema)
            elif path.stat().st_size < _LEAST_SIZE:  # which SQLite would take for a new one
                raise FileError(path, schema.damaged)
            self._connection = _connect(path)
            try:
                if not (shared or lookups):
                    _run(self._connection, "locking_mode = EXCLUSIVE")
                schema.check(self._connection, path)
                _run(self._connection, "journal_mode = WAL")
                _run(self._connection, f"synchronous = {'FULL' if durable else 'NORMAL'}")
                pages = _PAGES_AT_MOST if lookups else _PAGES_BETWEEN_CHECKPOINTS
                _run(self._connection, f"wal_autocheckpoint = {pages}")
                schema.upgrade(self._connection)
                if lookups:
                    self._looker = _connect(path)
                    _run(self._looker, "query_only = ON")
                    self._checkpoints = _Checkpoints(path)
            except BaseException:
                self.close()
                raise

    @contextmanager
    def transaction(self, *, waits: bool = True) -> Iterator[sqlite3.Connection]:
        """Gives the connection for writes that are all kept when the block ends, or none if anything raises.

        Args:
            waits: False to wait for no disk, though the file be durable: a power cut may take these writes, until the
                next ones that wait.

        Raises:
            FileError: They cannot be kept.
            WorldError: The file is closed.
        """
        with self._guard, self._faults():
            connection = self._open()
            hurries = self._durable and not waits
            if hurries:
                _run(connection, "synchronous = NORMAL")
            try:
                with _committing(connection):
                    yield connection
                self._commits += 1
            finally:
                if hurries:
                    _run(connection, "synchronous = FULL")

    @contextmanager
    def reading(self) -> Iterator[None]:
        """Blocks writers while the block runs: several queries in it see one state of the file."""
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

    def looked_up(self, sql: str, values: Sequence[object] = (), *, room: int | None = None) -> list[tuple[Any, ...]]:
        """Returns the answer to a slow query; writers do not wait for it.

        It sees all that was committed before, and nothing of a transaction that is going on.

        Args:
            sql: The query.
            values: What is bound to its question marks.
            room: After so many characters in the first column no further row is read; None for all rows.

        Raises:
            FileError: The file cannot be read.
            WorldError: The file is closed.
        """
        with self._looking, self._faults():
            if self._looker is None:
                raise self._closed()
            with closing(self._looker.execute(sql, values)) as cursor:
                return cursor.fetchall() if room is None else list(_fitting(cursor, room))

    def sync(self) -> None:
        """Waits until what was committed outlives a power cut as well; readers and writers do not wait.

        Raises:
            FileError: The disk does not take it.
        """
        commits = self._commits
        if self._synced >= commits:
            return
        try:
            log = os.open(self.path.with_name(f"{self.path.name}-wal"), os.O_RDONLY)
            try:
                os.fsync(log)
            finally:
                os.close(log)
        except FileNotFoundError:  # all of it is in the file
            return
        except OSError as error:
            raise FileError(self.path, f"the disk does not take it: {error.strerror or error}") from error
        self._synced = max(self._synced, commits)

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
        checkpoints, self._checkpoints = self._checkpoints, None
        if checkpoints is not None:
            checkpoints.close()
        with self._looking, self._faults():
            looker, self._looker = self._looker, None
            if looker is not None:
                looker.close()
        with self._guard, self._faults():
            connection, self._connection = self._connection, None
            if connection is not None:
                connection.close()

    def _open(self) -> sqlite3.Connection:
        if self._connection is None:
            raise self._closed()
        return self._connection

    def _closed(self) -> WorldError:
        return WorldError(f"{self.path.parent}: the data directory is closed, nothing is read or written any more")

    @contextmanager
    def _faults(self) -> Iterator[None]:
        try:
            yield
        except sqlite3.Error as error:
            raise FileError(self.path, _words(error, self._schema)) from error
        except OSError as error:
            raise FileError(self.path, f"cannot be opened: {error.strerror or error}") from error


class _Checkpoints:
    """Works the write-ahead log into the file from a thread of its own, on a connection of its own.

    It is a passive checkpoint: those who read or write meanwhile are not waited for, and do not wait.
    """

    def __init__(self, path: Path) -> None:
        self._log = path.with_name(f"{path.name}-wal")
        self._connection = _connect(path)
        _run(self._connection, "synchronous = FULL")  # the log restarts only when the file is on the disk
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._work, name="skiros-checkpoints", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Ends it; the last one to close the file works in what is left."""
        self._ended.set()
        self._thread.join()
        self._connection.close()

    def _work(self) -> None:
        while not self._ended.wait(_BETWEEN_LOOKS):
            with suppress(sqlite3.Error, OSError):  # such as a full disk: the log waits, and nothing is lost
                if self._log.stat().st_size > _PAGE * _PAGES_BETWEEN_CHECKPOINTS // 4:
                    self._checkpoint()

    def _checkpoint(self) -> None:
        """Writes the log, and what came meanwhile, into the file: only then the log restarts."""
        for _ in range(_ROUNDS):
            ((_, logged, done),) = self._connection.execute("PRAGMA wal_checkpoint(PASSIVE)").fetchall()
            if logged == done:
                return


_PAGE = 4096
_ROUNDS = 5


def _make(path: Path, schema: Schema) -> None:
    """Makes the file under another name, so that there never is a half-made one."""
    log = path.with_name(f"{path.name}-wal")
    if log.exists():
        raise FileError(path, f"the file is gone, and {log.name} is still there: put it back, or remove that too")
    new = path.with_name(f"{path.name}.new")
    for left in (new, new.with_name(f"{new.name}-journal")):
        left.unlink(missing_ok=True)
    with closing(_connect(new)) as connection:
        schema.upgrade(connection)
    new.replace(path)


def _connect(path: Path) -> sqlite3.Connection:
    # No transaction but those that are begun in so many words; threads take turns by our own lock.
    return sqlite3.connect(path, timeout=1.0, isolation_level=None, check_same_thread=False)


def _fitting(rows: Iterable[tuple[Any, ...]], room: int) -> Iterator[tuple[Any, ...]]:
    """Yields rows until there is no room left; the first in any case."""
    for row in rows:
        yield row
        room -= len(row[0])
        if room <= 0:
            return


@contextmanager
def _committing(connection: sqlite3.Connection) -> Iterator[None]:
    """Keeps what is written while the block lasts, or nothing of it if anything raises."""
    connection.execute("BEGIN IMMEDIATE")
    try:
        yield
        connection.execute("COMMIT")
    except BaseException:
        if connection.in_transaction:
            connection.execute("ROLLBACK")
        raise


def _run(connection: sqlite3.Connection, pragma: str) -> None:
    connection.execute(f"PRAGMA {pragma}").fetchall()


def _number(connection: sqlite3.Connection, pragma: str) -> int:
    ((value,),) = connection.execute(f"PRAGMA {pragma}").fetchall()
    return int(value)


def _words(error: sqlite3.Error, schema: Schema) -> str:
    name = getattr(error, "sqlite_errorname", "")
    said = next((words for begin, words in _WORDS if name.startswith(begin)), "it cannot be used")
    return f"{said or schema.damaged} ({error})"
