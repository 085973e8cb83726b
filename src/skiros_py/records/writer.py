"""Writes the record of a run: block by block, in a thread of its own, into a file that never outgrows its limit."""

from __future__ import annotations

import io
import json
import logging
import threading
import zlib
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from queue import Empty, SimpleQueue
from sqlite3 import Connection
from typing import TYPE_CHECKING, Any

from skiros_py.database import Database
from skiros_py.errors import FileError, SkirosError, UsageError
from skiros_py.ports.pending import Pending
from skiros_py.records.frames import encode_block
from skiros_py.records.room import Room
from skiros_py.records.schema import SCHEMA
from skiros_py.world.change import Change
from skiros_py.world.index import Index
from skiros_py.world.journal.codec import encode_change
from skiros_py.world.journal.snapshot import snapshot_pieces

if TYPE_CHECKING:
    from numpy.typing import NDArray

__all__ = ["LEAST_LIMIT", "LIMIT", "RecordWriter"]

_log = logging.getLogger(__name__)

LIMIT = 64 * 1024 * 1024
"""Bytes that a record takes at most, where nobody says otherwise."""
LEAST_LIMIT = 1024 * 1024
"""Bytes without which no record is worth having."""

_PAUSE = 0.25
"""Wall time between two commits [s]: what is lost when the process is killed."""
_LOG_PAGES = 250
"""Pages after which the write-ahead log is worked into the file (1 MB)."""
_LONGEST_QUEUE = 100_000
"""Items that wait for a disk that does not keep up; what comes then is left out."""
_LONGEST_BATCH = 2000
"""Items in one commit."""
_QUALITY = 70

_Work = Callable[[Connection], None]


class RecordWriter:
    """An open record. Its methods may be called in any thread, and never wait for the disk. Close it.

    When the file can no longer be written, the run goes on without a record: see :attr:`fault`.

    Args:
        path: The file; it must not exist.
        limit: Bytes that it takes at most.

    Attributes:
        path: The file.
        fault: Why nothing is written any more; empty while it is.

    Raises:
        UsageError: The limit is too small.
        FileError: The file is there already, or cannot be made.
    """

    def __init__(self, path: Path, *, limit: int = LIMIT) -> None:
        if limit < LEAST_LIMIT:
            raise UsageError(f"a record needs room for at least {LEAST_LIMIT} bytes, not {limit}")
        if path.exists():
            raise FileError(path, "there is a record already: choose another name")
        self.path = path
        self.fault = ""
        self._room = Room(limit)
        self._queue: SimpleQueue[_Work | None] = SimpleQueue()
        self._pictures: deque[tuple[float, str, Pending[NDArray[Any]]]] = deque()
        self._dropped = 0
        self._database = Database(path, SCHEMA, shared=True)
        self._database.rows(f"PRAGMA wal_autocheckpoint = {_LOG_PAGES}")
        self._thread = threading.Thread(target=self._write_on, name="record of the run", daemon=True)
        self._thread.start()

    # ------------------------------------------------------------------ what is recorded

    def put_meta(self, key: str, value: object) -> None:
        """Takes what is said once of the whole run, as plain data; later ones replace earlier ones."""
        text = _text(value)
        self._put(lambda db: _run(db, "INSERT OR REPLACE INTO meta VALUES (?, ?)", key, text))

    def put_beginning(self, index: Index) -> None:
        """Takes the state of the world with which the run begins."""
        self._put(lambda db: self._write_beginning(db, index))

    def put_frames(self, times: Sequence[float], rows: Sequence[Sequence[float]]) -> None:
        """Takes snapshots; see :class:`skiros_py.records.frames.Layout`."""
        sql = "INSERT INTO frames (start, thinned, data) VALUES (?, 0, ?)"
        self._put(lambda db: _run(db, sql, times[0], encode_block(times, rows)))

    def put_event(self, time: float, event: Mapping[str, Any]) -> None:
        """Takes a module event."""
        sql = "INSERT INTO events (time, data) VALUES (?, ?)"
        self._put(lambda db: _run(db, sql, time, _text(event)))

    def put_trace(self, time: float, task: int, entry: Mapping[str, Any]) -> None:
        """Takes an entry of a task's trace."""
        sql = "INSERT INTO trace (time, task, data) VALUES (?, ?, ?)"
        self._put(lambda db: _run(db, sql, time, task, _text(entry)))

    def put_task(self, number: int, task: Mapping[str, Any]) -> None:
        """Takes what is known of a task; later ones replace earlier ones."""
        text = _text(task)
        self._put(lambda db: _run(db, "INSERT OR REPLACE INTO tasks VALUES (?, ?)", number, text))

    def put_change(self, change: Change) -> None:
        """Takes a change of the world."""
        self._put(lambda db: self._write_change(db, change))

    def put_picture(self, time: float, caption: str, picture: Pending[NDArray[Any]]) -> None:
        """Takes a picture, RGB, that may still be on its way."""
        if not self.fault:
            self._pictures.append((time, caption, picture))

    def close(self) -> None:
        """Writes what is left, and makes it one plain file; may be called twice."""
        if self._thread.is_alive():
            self._queue.put(None)
            self._thread.join()
        try:
            self._database.rows("PRAGMA journal_mode = DELETE")
            self._database.close()
        except SkirosError as error:  # closed already, or a reader has it open: then the log stays beside it
            _log.debug("%s", error)
            self._database.close()

    # ------------------------------------------------------------------ the thread

    def _put(self, work: _Work) -> None:
        if self.fault:
            return
        if self._queue.qsize() < _LONGEST_QUEUE:
            self._queue.put(work)
        else:
            self._dropped += 1

    def _write_on(self) -> None:
        """Writes what comes until the end, or until the file cannot be written."""
        going = True
        while going:
            batch, going = self._batch()
            try:
                self._commit(batch, last=not going)
            except Exception as error:  # noqa: BLE001 - a record is never worth a run
                self.fault = str(error) or type(error).__name__
                _log.warning("the run is recorded no longer: %s", self.fault)
                return

    def _batch(self) -> tuple[list[_Work], bool]:
        """Waits for something to write, lets more gather, and returns it; False with the last of it."""
        batch: list[_Work] = []
        try:
            work = self._queue.get(timeout=_PAUSE)
            while work is not None:
                batch.append(work)
                if len(batch) == _LONGEST_BATCH:
                    return batch, True
                work = self._queue.get(timeout=_PAUSE) if len(batch) == 1 else self._queue.get_nowait()
        except Empty:
            return batch, True
        return batch, False

    def _commit(self, batch: Sequence[_Work], *, last: bool) -> None:
        pictures = self._taken(last=last)
        if not (batch or pictures or self._dropped):
            return
        with self._database.transaction() as connection:
            for work in (*batch, *map(_picture, pictures)):
                work(connection)
                self._room.keep(connection)
            dropped, self._dropped = self._dropped, 0
            self._room.note(connection, "everything", dropped)

    def _taken(self, *, last: bool) -> list[tuple[float, str, bytes]]:
        """Returns the pictures that have arrived; at the end it waits for all."""
        taken = []
        while self._pictures and (last or self._pictures[0][2].done()):
            time, caption, picture = self._pictures.popleft()
            try:
                taken.append((time, caption, _webp(picture.result())))
            except SkirosError as error:  # the simulation is gone
                _log.debug("a picture is missing: %s", error)
        return taken

    def _write_beginning(self, db: Connection, index: Index) -> None:
        packed = [_packed([edits, stamps]) for edits, stamps in snapshot_pieces(index)]
        if sum(map(len, packed)) > self._room.largest:
            self._room.note(db, "beginning", 1)
            return
        for data in packed:
            _run(db, "INSERT INTO beginning (data) VALUES (?)", data)

    def _write_change(self, db: Connection, change: Change) -> None:
        data = _packed(encode_change(change))
        if len(data) > self._room.largest:
            self._room.note(db, "changes", 1)
        else:
            _run(db, "INSERT INTO changes (time, data) VALUES (?, ?)", change.time, data)


def _picture(picture: tuple[float, str, bytes]) -> _Work:
    return lambda db: _run(db, "INSERT INTO pictures (time, caption, data) VALUES (?, ?, ?)", *picture)


def _run(db: Connection, sql: str, *values: object) -> None:
    db.execute(sql, values)


def _text(value: object) -> str:
    return json.dumps(value, separators=(",", ":"), default=str)


def _packed(texts: Sequence[str]) -> bytes:
    return zlib.compress(json.dumps(texts).encode())


def _webp(picture: NDArray[Any]) -> bytes:
    from PIL import Image

    buffer = io.BytesIO()
    Image.fromarray(picture).save(buffer, "WEBP", quality=_QUALITY, method=2)
    return buffer.getvalue()
