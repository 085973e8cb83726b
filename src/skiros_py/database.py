"""A SQLite file used by the threads of one process; its errors are raised as messages for people."""

from __future__ import annotations

import errno
import logging
import os
import sqlite3
import threading
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import closing, contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

from skiros_py import commits
from skiros_py.commits import CommitLog, LostCommits
from skiros_py.database_file import connect, find_loss, give_up, last_commit, set_pragma
from skiros_py.errors import DiskFault, FileError, WorldError
from skiros_py.files import open_private
from skiros_py.messages import Message

_log = logging.getLogger(__name__)

T = TypeVar("T")

_PAGES_BETWEEN_CHECKPOINTS = 4000
"""Size of the write-ahead log at which it is checkpointed [pages] (16 MB)."""

_PAGES_AT_MOST = 50_000
"""The same where a thread makes the checkpoints, in case it cannot keep up [pages] (200 MB)."""

_BETWEEN_LOOKS = 0.5
"""Period in which that thread syncs the log and checks its size [s]."""

_LEAST_SIZE = 512
"""Minimum page size of SQLite [bytes]: a shorter file is no database."""

_WORDS = (
    ("SQLITE_FULL", Message("the disk is full: nothing was changed")),
    ("SQLITE_IOERR", Message("the disk cannot be written (is it full, or removed?): nothing was changed")),
    ("SQLITE_CORRUPT", ""),
    ("SQLITE_NOTADB", ""),
    ("SQLITE_BUSY", Message("another program uses the file: close it first")),
    ("SQLITE_READONLY", Message("the file cannot be written: check the permissions of the file and its folder")),
    ("SQLITE_CANTOPEN", Message("the file cannot be opened: check the permissions of the file and its folder")),
    ("SQLITE_PERM", Message("the file cannot be opened: check the permissions of the file and its folder")),
)
_SYSTEM_WORDS = {
    errno.ENOSPC: Message("No space left on device"),
    errno.EIO: Message("Input/output error"),
    errno.EROFS: Message("Read-only file system"),
    errno.EDQUOT: Message("Disk quota exceeded"),
}
"""The errors of a disk, by what the system calls them."""
COUNTED = "CREATE TABLE commits (last INTEGER NOT NULL); INSERT INTO commits VALUES (0x534b430000000000);"
"""The migration that counts commits; each schema has it."""
_DISK = ("SQLITE_FULL", "SQLITE_IOERR", "SQLITE_READONLY", "SQLITE_CORRUPT")
"""Errors of the disk, which may end; SQLite takes a read that fails with EIO for a damaged file."""


@dataclass(frozen=True, slots=True)
class Schema:
    """The tables of a kind of file, and the migrations between their versions.

    Attributes:
        what: The kind of file ("the journal of a world").
        application: SQLite's application id of such files.
        migrations: SQL from each version of the tables to the next; the first creates version 1.
    """

    what: str
    application: int
    migrations: Sequence[str]

    def check(self, connection: sqlite3.Connection, path: Path) -> None:
        """Checks the kind and version of a file, without changing it.

        Raises:
            FileError: It is of another kind, or was written by a later version of this program.
            sqlite3.Error: The file is damaged or cannot be read.
        """
        if _number(connection, "application_id") != self.application:
            raise FileError(path, f"is the file of another program, not {self.what}: choose another folder")
        version = _number(connection, "user_version")
        if version > len(self.migrations):
            raise FileError(
                path,
                f"has tables of version {version}, and this program supports versions up to {len(self.migrations)}:"
                " open it with the version that wrote it, or a later one",
            )

    def upgrade(self, connection: sqlite3.Connection) -> None:
        """Migrates an empty or old file to the current version of the tables; each migration is atomic.

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
        """The message for a file that cannot be read as such."""
        return Message(
            "the file is damaged, or not {what}, or the disk cannot be read: restore a copy, or use another folder",
            what=self.what,
        )


class Database:
    """An open file; created if it is missing, migrated if it is old.

    Committed writes survive a crash of the process. A power failure may lose the last second of writes that are not
    durable. Each commit is also noted in a second file (:mod:`~skiros_py.commits`): a file that ends before what was
    committed is not opened, unless a power failure explains that; then the missing writes are logged.

    Other processes may read committed content at any time.

    Attributes:
        path: The file.
        fault: Why the last write failed; None if it did not.
        unreadable: The records that :meth:`readable` has left out, by name.
    """

    def __init__(self, path: Path, schema: Schema, *, durable: bool = False, lookups: bool = False) -> None:
        """Opens the file.

        Args:
            path: The file.
            schema: Its tables.
            durable: Whether committed writes also survive a power failure; each commit waits for the disk. Otherwise a
                separate thread syncs and checkpoints the write-ahead log, so that commits do not wait for that.
            lookups: Whether :meth:`looked_up` is used.

        Raises:
            FileError: It cannot be opened or created, is damaged, is another program's, or is of a later version.
            LostCommits: It ends before what was acknowledged.
        """
        self.path = path
        self._schema = schema
        self._durable = durable
        self._guard = threading.RLock()
        self._syncing = threading.Lock()
        self._writes: list[str] = []
        self._committed = self._synced = 0
        self._unsafe = False
        self.fault: DiskFault | None = None
        self.unreadable: dict[str, FileError] = {}
        self._connection: sqlite3.Connection | None = None
        self._looking = threading.Lock()
        self._looker: sqlite3.Connection | None = None
        self._upkeep: _Upkeep | None = None
        self._notes: CommitLog | None = None
        with self._faults():
            if not path.exists():
                _make(path, schema)
            elif path.stat().st_size < _LEAST_SIZE:  # SQLite would treat it as a new one
                raise FileError(path, schema.damaged)
            _make_private(path)
            _check_complete(path, schema)
            self._connection = connect(path)
            try:
                schema.check(self._connection, path)
                set_pragma(self._connection, "journal_mode = WAL")
                set_pragma(self._connection, f"synchronous = {'FULL' if durable else 'NORMAL'}")
                pages = _PAGES_BETWEEN_CHECKPOINTS if durable else _PAGES_AT_MOST
                set_pragma(self._connection, f"wal_autocheckpoint = {pages}")
                schema.upgrade(self._connection)
                self._committed = last_commit(self._connection)
                if not commits.exists(path):
                    commits.create(path, self._committed, "the file was opened")
                self._notes = CommitLog(path)
                self.sync()
                if lookups:
                    self._looker = connect(path)
                    set_pragma(self._looker, "query_only = ON")
                if not durable:
                    self._upkeep = _Upkeep(self)
            except BaseException:
                self.close()
                raise

    @contextmanager
    def transaction(self, what: str = "") -> Iterator[sqlite3.Connection]:
        """Lends the connection for writes: all are committed at the end of the block, or none if it raises.

        A block within a block of the same thread belongs to the outer one.

        Args:
            what: What is written, in words: said to people if it is missing in the file later.

        Raises:
            FileError: They cannot be stored.
            WorldError: The file is closed.
        """
        with self._guard, self._faults():
            connection = self._open()
            if self._writes:
                with self._part(connection, what):
                    yield connection
                return
            writes = self._writes = [what]
            try:
                with _committing(connection):
                    yield connection
                    self._check_open(connection)
                    connection.execute("UPDATE commits SET last = last + 1")  # RETURNING would take ten times as long
                    committed = last_commit(connection)
            finally:
                self._writes = []
            self._committed = committed
            if self._notes is not None:
                self._notes.note(committed, commits.listed(writes), synced=self._durable)
            if not self._unsafe:
                self.fault = None

    @contextmanager
    def _part(self, connection: sqlite3.Connection, what: str) -> Iterator[None]:
        """A block within a transaction: if it raises, its own writes are taken back, whatever the outer one does."""
        self._check_open(connection)
        before = len(self._writes)
        connection.execute("SAVEPOINT part")
        self._writes.append(what)
        try:
            yield
        except BaseException:
            del self._writes[before:]
            if connection.in_transaction:
                connection.execute("ROLLBACK TO part")
                connection.execute("RELEASE part")
            raise
        self._check_open(connection)
        connection.execute("RELEASE part")

    def _check_open(self, connection: sqlite3.Connection) -> None:
        """Raises DiskFault if SQLite has rolled the transaction back by itself, as on a full disk."""
        if not connection.in_transaction:
            raise DiskFault(self.path, Message("the disk cannot be written: nothing was changed"))

    @contextmanager
    def reading(self) -> Iterator[None]:
        """Blocks writers during the block, so that several queries see one state of the file."""
        with self._guard:
            yield

    def rows(self, sql: str, values: Sequence[object] = ()) -> list[tuple[Any, ...]]:
        """Returns the rows of a query.

        Raises:
            FileError: The file cannot be read.
            WorldError: The file is closed.
        """
        with self._guard, self._faults():
            return self._open().execute(sql, values).fetchall()

    def looked_up(self, sql: str, values: Sequence[object] = (), *, room: int | None = None) -> list[tuple[Any, ...]]:
        """Returns the rows of a slow query, without blocking writers.

        It sees all committed content, and nothing of a transaction in progress.

        Args:
            sql: The query.
            values: Values of its question marks.
            room: Maximum number of characters in the first column: then no further row is read; None for all rows.

        Raises:
            FileError: The file cannot be read.
            WorldError: The file is closed.
        """
        with self._looking, self._faults():
            if self._looker is None:
                raise self._closed()
            with closing(self._looker.execute(sql, values)) as cursor:
                return cursor.fetchall() if room is None else list(_fitting(cursor, room))

    def read(self, name: str, read: Callable[..., T], *columns: Any) -> T:
        """Reads a record.

        Args:
            name: Its name, for people.
            read: Makes it of its columns; raises ValueError or TypeError if it cannot.
            *columns: The columns.

        Raises:
            FileError: It cannot be read.
        """
        try:
            return read(*columns)
        except (ValueError, TypeError) as error:
            raise FileError(self.path, f"{name} cannot be read: {_first_fault(error)}") from error

    def readable(self, rows: Iterable[tuple[str, *tuple[Any, ...]]], read: Callable[..., T]) -> Iterator[T]:
        """Yields the records that can be read; one that cannot is reported once, and hides no other.

        Args:
            rows: The rows of a query; the first column names the record.
            read: Makes a record of its other columns; raises ValueError or TypeError if it cannot.
        """
        for name, *columns in rows:
            try:
                yield self.read(name, read, *columns)
            except FileError as error:
                if name not in self.unreadable:
                    self.unreadable[name] = error
                    _log.error("%s; it is left out, and stays in the file", error)

    def sync(self) -> None:
        """Waits until all committed writes survive a power failure, without blocking readers and writers.

        Raises:
            DiskFault: The disk cannot be written.
        """
        with self._syncing:  # who waits meanwhile may find its writes synced
            self._sync(self._committed)

    def _sync(self, committed: int) -> None:
        if self._synced >= committed:
            return
        try:
            if self._unsafe:  # a failed sync may have dropped pages of the log: they are written to the file instead
                with self._guard, self._faults():
                    ((busy, _, _),) = self._open().execute("PRAGMA wal_checkpoint(TRUNCATE)").fetchall()
                if busy:
                    reason = Message("the disk failed, and the log cannot be written again while it is read")
                    raise DiskFault(self.path, reason)
                self._unsafe, self.fault = False, None
            log = os.open(self.path.with_name(f"{self.path.name}-wal"), os.O_RDONLY)
            try:
                os.fsync(log)
            finally:
                os.close(log)
        except FileNotFoundError:
            pass  # there is no log: everything is in the file
        except OSError as error:
            self._unsafe = True
            why = _SYSTEM_WORDS.get(error.errno or 0, error.strerror or str(error))
            self.fault = DiskFault(self.path, Message("the disk cannot be written: {error}", error=why))
            raise self.fault from error
        self._synced = max(self._synced, committed)
        if self._notes is not None:
            self._notes.synced(self._synced)

    def sync_notes(self) -> None:
        """Waits until it is also on the disk which writes are; nobody else needs to wait for that."""
        if self._notes is not None:
            self._notes.sync()

    def shrink(self) -> None:
        """Frees the space of deleted content.

        Raises:
            FileError: There is not enough space to do so; the content is unchanged.
        """
        with self._guard, self._faults():
            connection = self._open()
            connection.execute("VACUUM")
            connection.execute("PRAGMA wal_checkpoint(TRUNCATE)")

    def close(self) -> None:
        """Closes the file; may be called twice."""
        upkeep, self._upkeep = self._upkeep, None
        if upkeep is not None:
            upkeep.close()
        with self._looking, self._faults():
            looker, self._looker = self._looker, None
            if looker is not None:
                looker.close()
        if self._connection is not None:
            with suppress(FileError):
                self.sync()
        with self._syncing, self._guard, self._faults():
            connection, self._connection = self._connection, None
            if connection is not None:
                connection.close()
            notes, self._notes = self._notes, None
            if notes is not None:
                notes.close()

    def _open(self) -> sqlite3.Connection:
        if self._connection is None:
            raise self._closed()
        return self._connection

    def _closed(self) -> WorldError:
        return WorldError(f"{self.path.parent}: the data directory is closed: it can no longer be read or written")

    @contextmanager
    def _faults(self) -> Iterator[None]:
        try:
            yield
        except sqlite3.Error as error:
            if getattr(error, "sqlite_errorname", "").startswith(_DISK):
                self.fault = DiskFault(self.path, _words(error, self._schema))
                raise self.fault from error
            raise FileError(self.path, _words(error, self._schema)) from error
        except OSError as error:
            raise FileError(self.path, f"cannot be opened: {error.strerror or error}") from error


class _Upkeep:
    """A thread that syncs and checkpoints the write-ahead log, with a connection of its own.

    The checkpoints are passive: they neither wait for readers and writers nor block them.
    """

    def __init__(self, database: Database) -> None:
        self._database = database
        self._log = database.path.with_name(f"{database.path.name}-wal")
        self._connection = connect(database.path)
        set_pragma(self._connection, "synchronous = FULL")  # the log restarts only when the file is on the disk
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._work, name="skiros-upkeep", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Ends the thread; SQLite checkpoints the rest when the last connection is closed."""
        self._ended.set()
        self._thread.join()
        self._connection.close()

    def _work(self) -> None:
        while not self._ended.wait(_BETWEEN_LOOKS):
            with suppress(sqlite3.Error, OSError, FileError):  # such as a full disk: the content stays in the log
                self._database.sync()
                self._database.sync_notes()
                if self._log.stat().st_size > _PAGE * _PAGES_BETWEEN_CHECKPOINTS // 4:
                    self._checkpoint()

    def _checkpoint(self) -> None:
        """Checkpoints the log with what was added meanwhile: only then can it restart."""
        for _ in range(_ROUNDS):
            ((_, logged, done),) = self._connection.execute("PRAGMA wal_checkpoint(PASSIVE)").fetchall()
            if logged == done:
                return


_PAGE = 4096
_ROUNDS = 5


def _make_private(path: Path) -> None:
    """Takes the permissions of others from a database and its log; SQLite gives new ones those of the file."""
    for file in (path, *(path.with_name(f"{path.name}-{end}") for end in ("wal", "shm", "commits"))):
        with suppress(OSError):  # some file systems have no permissions, and the file may be another user's
            file.chmod(0o600)


def _make(path: Path, schema: Schema) -> None:
    """Creates the file under a temporary name, so that it is never incomplete."""
    for end in ("-wal", commits.ENDING):
        left = path.with_name(f"{path.name}{end}")
        if left.exists() and not (end == commits.ENDING and commits.unused(path)):
            raise FileError(
                path, f"the file is missing, but {left.name} exists: restore the file, or remove {left.name}"
            )
    new = path.with_name(f"{path.name}.new")
    for left in (new, new.with_name(f"{new.name}-journal")):
        left.unlink(missing_ok=True)
    os.close(open_private(os.fspath(new), os.O_CREAT | os.O_EXCL))
    with closing(connect(new)) as connection:
        schema.upgrade(connection)
    commits.create(path, 0, "the file was made")
    new.replace(path)


def _check_complete(path: Path, schema: Schema) -> None:
    """Checks that a file, which is not changed by that, holds everything that was acknowledged.

    Raises:
        FileError: It does not, or is of another kind or a later version.
        sqlite3.Error: The file is damaged or cannot be read.
    """
    loss = find_loss(path, schema.check)
    if loss is None:
        return
    if not loss.power_cut:
        raise LostCommits(loss)
    for line in f"{loss}\nthe machine went down before they were on the disk".splitlines():
        _log.warning("%s: %s", path.name, line.strip())
    give_up(loss)


def _fitting(rows: Iterable[tuple[Any, ...]], room: int) -> Iterator[tuple[Any, ...]]:
    """Yields rows until the room is used up; always the first."""
    for row in rows:
        yield row
        room -= len(row[0])
        if room <= 0:
            return


@contextmanager
def _committing(connection: sqlite3.Connection) -> Iterator[None]:
    """Commits the writes of the block, or rolls them back if it raises."""
    connection.execute("BEGIN IMMEDIATE")
    try:
        yield
        connection.execute("COMMIT")
    except BaseException:
        if connection.in_transaction:
            connection.execute("ROLLBACK")
        raise


def _number(connection: sqlite3.Connection, pragma: str) -> int:
    ((value,),) = connection.execute(f"PRAGMA {pragma}").fetchall()
    return int(value)


def _first_fault(error: Exception) -> str:
    from pydantic import ValidationError

    if not isinstance(error, ValidationError):
        return str(error)
    fault = error.errors()[0]
    return ": ".join(filter(None, (".".join(map(str, fault["loc"])), fault["msg"])))


def _words(error: sqlite3.Error, schema: Schema) -> str:
    name = getattr(error, "sqlite_errorname", "")
    said = next((words for begin, words in _WORDS if name.startswith(begin)), f"it cannot be used ({error})")
    return said or schema.damaged
