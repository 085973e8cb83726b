"""A SQLite file as it lies on the disk: read while others use it, copied, and compared with its noted commits."""

from __future__ import annotations

import os
import re
import sqlite3
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, closing, contextmanager, suppress
from pathlib import Path
from typing import Any

from skiros_py import commits
from skiros_py.errors import FileError
from skiros_py.files import open_private

_ZERO = int.from_bytes(b"SKC".ljust(8, b"\0"))
"""The count of commits begins there: so large, it is stored in a fixed length, after three letters."""
_COUNTED = re.compile(rb"SKC(.{5})", re.DOTALL)


def connect(path: Path) -> sqlite3.Connection:
    """Opens a file for writing, too."""
    # Transactions are begun explicitly; our own lock serialises threads.
    connection = sqlite3.connect(path, timeout=1.0, isolation_level=None, check_same_thread=False)
    connection.text_factory = _decoded
    return connection


def _connect_read_only(path: Path, more: str = "") -> sqlite3.Connection:
    """Opens a file without changing it: SQLite neither checkpoints nor removes its log at the end."""
    connection = sqlite3.connect(
        f"{path.absolute().as_uri()}?mode=ro{more}", timeout=1.0, isolation_level=None, uri=True
    )
    connection.text_factory = _decoded
    return connection


def _decoded(text: bytes) -> str | bytes:
    """Returns a text of a file; its bytes if it is damaged, so that it hides no other row of a query."""
    try:
        return text.decode()
    except UnicodeDecodeError:
        return text


def find_loss(path: Path, check: Callable[[sqlite3.Connection, Path], None] | None = None) -> commits.Loss | None:
    """Returns which acknowledged writes are missing in a file; None if none is.

    The file is not changed, and may be in use.

    Args:
        path: The file.
        check: Called with the open file, which it may refuse.

    Raises:
        FileError: The file is of another kind or a later version, or older than its log.
        sqlite3.Error: The file is damaged or cannot be read.
    """
    noted = commits.read(path)  # first: commits may be added meanwhile
    with closing(_connect_read_only(path)) as connection:
        if check is not None:
            check(connection, path)
        if not _counts(connection):
            return None  # of an earlier version
        last = last_commit(connection)
        root = _page_of_commits(connection)
    in_file, root = _in_file(path, root)  # VACUUM, which may be in the log, moves that page
    first = _first_in_log(path, root)
    if first is not None and in_file is not None and in_file < first - 1 < last:
        log = f"{path.name}-wal"
        raise FileError(
            path,
            f"is older than its log {log}, as if a copy had been put in its place while {log} was left: restore the"
            f" whole data directory, or move {log} away",
        )
    return commits.find_loss(path, last, noted)


def accept_loss(path: Path) -> commits.Loss | None:
    """Gives up the acknowledged writes that are missing in a file, so that it can be opened.

    A copy of its write-ahead log is kept beside it.

    Returns:
        What was missing; None if nothing was.

    Raises:
        FileError: The file is older than its log, or cannot be written.
        sqlite3.Error: The file is damaged or cannot be read.
    """
    loss = find_loss(path)
    if loss is not None:
        give_up(loss)
    return loss


def give_up(loss: commits.Loss) -> None:
    """Counts missing writes as given up; a copy of the file's write-ahead log is kept beside it."""
    log = loss.path.with_name(f"{loss.path.name}-wal")
    with suppress(FileNotFoundError), open(log.with_name(f"{log.name}.kept"), "wb", opener=open_private) as kept:
        kept.write(log.read_bytes())
    with closing(connect(loss.path)) as connection:
        connection.execute("UPDATE commits SET last = ?", (_ZERO + loss.last,))
        set_pragma(connection, "wal_checkpoint(TRUNCATE)")
    commits.create(loss.path, loss.last, "missing writes were given up")


def delete(path: Path) -> None:
    """Deletes a file that is closed, with its notes; a kill leaves it as it was, or nothing that hinders a new one."""
    with suppress(OSError):  # on a full disk only a kill would be noticed
        commits.create(path, 0, "the file is deleted")
    for end in ("-wal", "-shm", "", commits.ENDING):
        path.with_name(f"{path.name}{end}").unlink(missing_ok=True)


class DatabaseFile:
    """A file that is only read, and may be in use. Close it.

    Args:
        path: The file.

    Attributes:
        path: The file.

    Raises:
        FileError: It cannot be opened.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        with _read_faults(path):
            self._connection = _connect_read_only(path)
            self._connection.execute("BEGIN")  # all queries see one state

    def rows(self, sql: str, values: Sequence[object] = ()) -> list[tuple[Any, ...]]:
        """Returns the rows of a query.

        Raises:
            FileError: The file is damaged or cannot be read.
        """
        with _read_faults(self.path):
            return self._connection.execute(sql, values).fetchall()

    def faults(self) -> Iterator[str]:
        """Yields what is wrong with pages, indexes, and the texts that should be JSON.

        Raises:
            FileError: The file cannot be read.
        """
        found = [text for (text,) in self.rows("PRAGMA integrity_check(20)")]
        yield from () if found == ["ok"] else found
        sql = (
            "SELECT tables.name, columns.name FROM sqlite_schema AS tables, pragma_table_info(tables.name) AS columns"
            " WHERE tables.type = 'table' AND columns.name IN ('data', 'edits', 'stamps')"
        )
        for table, column in self.rows(sql):
            broken = self.rows(f"SELECT count(*) FROM {table} WHERE NOT json_valid({column})")  # noqa: S608 - our names
            if broken != [(0,)]:
                yield f"{broken[0][0]} rows of the table {table} cannot be read"

    def close(self) -> None:
        """Closes the file."""
        self._connection.close()


@contextmanager
def _read_faults(path: Path) -> Iterator[None]:
    try:
        yield
    except sqlite3.Error as error:
        raise FileError(path, f"the file is damaged, or cannot be read ({error})") from error


def back_up(paths: Sequence[Path], folder: Path) -> None:
    """Copies files, which may be in use, as they are at one moment; each copy is complete without a log.

    Args:
        paths: The files, in the order in which their states are taken, a few milliseconds one after the other.
        folder: Where the copies are made.

    Raises:
        sqlite3.Error: A file is damaged, or a copy cannot be written.
        OSError: A copy cannot be written.
    """
    with ExitStack() as stack:
        sources = [stack.enter_context(closing(_connect_read_only(path))) for path in paths]
        for source in sources:
            source.execute("BEGIN")
            source.execute("SELECT count(*) FROM sqlite_schema").fetchall()  # the state is taken by the first read
        for path, source in zip(paths, sources, strict=True):
            target = folder / path.name
            os.close(open_private(os.fspath(target), os.O_CREAT | os.O_EXCL))
            with closing(connect(target)) as copy:
                source.backup(copy)
                if _counts(copy):
                    commits.create(target, last_commit(copy), "the backup was made")


def _counts(connection: sqlite3.Connection) -> bool:
    """Returns whether a file counts its commits: those of earlier versions do not."""
    return bool(connection.execute("SELECT 1 FROM sqlite_schema WHERE name = 'commits'").fetchall())


def last_commit(connection: sqlite3.Connection) -> int:
    """Returns the number of the last commit."""
    ((last,),) = connection.execute("SELECT last FROM commits").fetchall()
    return int(last) - _ZERO


def _page_of_commits(connection: sqlite3.Connection) -> int:
    ((root,),) = connection.execute("SELECT rootpage FROM sqlite_schema WHERE name = 'commits'").fetchall()
    return int(root)


def _in_file(path: Path, root: int) -> tuple[int | None, int]:
    """Returns the last commit in a file itself, without its log, and the page where it is; None if that is unknown.

    A checkpoint that goes on, or was cut off, may leave the file without sense until its log is read, too.
    """
    try:
        with closing(_connect_read_only(path, "&immutable=1")) as connection:
            if not _counts(connection):
                return 0, root
            root, last = _page_of_commits(connection), last_commit(connection)
    except (sqlite3.Error, ValueError, TypeError):
        return None, root
    return last if last >= 0 else None, root


def _first_in_log(path: Path, page: int) -> int | None:
    """Returns the first commit in a write-ahead log; None if there is none.

    Args:
        path: The file.
        page: Its page with the count of commits.
    """
    try:
        with path.with_name(f"{path.name}-wal").open("rb") as log:
            header = log.read(32)
            size = int.from_bytes(header[8:12]) or 1
            while (frame := log.read(24))[8:16] == header[16:24] and len(frame) == 24:
                content = log.read(size)
                if int.from_bytes(frame[:4]) == page and (found := _COUNTED.search(content)):
                    return int.from_bytes(found[1])
    except FileNotFoundError:
        pass
    return None


def set_pragma(connection: sqlite3.Connection, pragma: str) -> None:
    """Sets a parameter of a connection ("synchronous = FULL")."""
    connection.execute(f"PRAGMA {pragma}").fetchall()
