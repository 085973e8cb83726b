"""Keeps what jobs look like: the control thread only notes that something happened, another thread writes it down."""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from queue import Empty, SimpleQueue
from uuid import uuid4

from skiros_py.ports.values import Snapshot
from skiros_py.server.replays.lines import Line, read_lines
from skiros_py.server.replays.recording import EVERY, Beginning, Recording
from skiros_py.server.replays.shelf import ReplayShelf
from skiros_py.station.session import Session
from skiros_py.tasks.handle import TaskHandle
from skiros_py.tasks.jobs import Job
from skiros_py.tasks.trace import Happening, TraceEntry
from skiros_py.world.change import Change
from skiros_py.world.index import Index

__all__ = ["ReplayRecorder"]

_log = logging.getLogger(__name__)

_BETWEEN_WRITES = 2.0
"""Wall time between two pieces of a file [s]: what is lost when the process is killed."""
_LONGEST_QUEUE = 20_000
"""What waits for a disk that does not keep up; then the replays that are being written end there."""


@dataclass(frozen=True, slots=True)
class _Changed:
    change: Change
    index: Index
    snapshot: Snapshot


@dataclass(frozen=True, slots=True)
class _Ended:
    number: int
    time: float


@dataclass(frozen=True, slots=True)
class _Removed:
    number: int


class _Closed:
    """The session is over: what runs still was cut off."""


class _Last:
    """Nothing comes any more."""


_Note = Beginning | Snapshot | _Changed | _Ended | _Removed | _Closed | _Last


class ReplayRecorder:
    """Records every job while it runs. Start it, and close it.

    Args:
        shelf: Where replays are kept.
    """

    def __init__(self, shelf: ReplayShelf) -> None:
        self._shelf = shelf
        self._notes: SimpleQueue[_Note] = SimpleQueue()
        self._thread = threading.Thread(target=self._write_on, name="skiros-replays", daemon=True)
        self._session: Session | None = None
        self._run = ""
        self._running: set[int] = set()
        self._next = 0.0
        self._ends: list[Callable[[], object]] = []
        self._recordings: dict[int, Recording] = {}

    def start(self) -> None:
        """Starts to write."""
        self._thread.start()

    def close(self) -> None:
        """Writes what has come; may be called twice."""
        if self._thread.is_alive():
            self._notes.put(_Last())
            self._thread.join()

    def lines(self, number: int) -> list[Line]:
        """Returns what is kept of a job, by its number; nothing where nothing is.

        Raises:
            OSError: It cannot be read.
        """
        try:
            return read_lines(self._shelf.path(number))
        except FileNotFoundError:
            return []

    # ------------------------------------------------------------------ noted where it happens

    def open(self, session: Session) -> None:
        """Follows the jobs of a session."""
        self._session, self._run = session, uuid4().hex
        self._ends = [
            session.tasks.on_begin(self._follow),
            session.world.subscribe(self._change),
            session.cycle.observe(self._attend),
            session.jobs.on_remove(self._remove),
        ]

    def close_session(self, _session: Session) -> None:
        """Follows them no longer."""
        for end in self._ends:
            end()
        self._ends = []
        self._session = None
        self._running.clear()
        self._notes.put(_Closed())

    def _follow(self, task: TaskHandle) -> None:
        session = self._session
        job = session.jobs.open.get(task.name) if session is not None else None
        if session is None or job is None:
            return
        number, snapshot = job.number, session.cycle.board.snapshot
        self._running.add(number)
        self._notes.put(Beginning(job.id, number, self._run, snapshot, session.world.snapshot()))

        def on_entry(entry: TraceEntry) -> None:
            if entry.what is Happening.FINISHED and self._session is session:
                self._running.discard(number)
                self._notes.put(session.cycle.board.snapshot)
                self._notes.put(_Ended(number, entry.time))

        task.trace.subscribe(on_entry)

    def _attend(self) -> None:
        if not self._running or self._session is None:
            return
        board = self._session.cycle.board
        if board.snapshot.time >= self._next or board.snapshot.time < self._next - EVERY:
            # By half a cycle early rather than always late: the cycle's times are sums of rounded numbers.
            self._next = board.snapshot.time + EVERY - board.period / 2.0
            self._put(board.snapshot)

    def _change(self, change: Change) -> None:
        if self._running and self._session is not None:
            self._put(_Changed(change, self._session.world.snapshot(), self._session.cycle.board.snapshot))

    def _remove(self, job: Job) -> None:
        self._notes.put(_Removed(job.number))

    def _put(self, note: _Note) -> None:
        if self._notes.qsize() < _LONGEST_QUEUE:
            self._notes.put(note)
        else:
            self._running.clear()
            self._notes.put(_Closed())

    # ------------------------------------------------------------------ the thread

    def _write_on(self) -> None:
        written = time.monotonic()
        while True:
            try:
                note = self._notes.get(timeout=_BETWEEN_WRITES)
            except Empty:
                note = None
            if isinstance(note, _Last):
                return self._close_all()
            if note is not None:
                self._take(note)
            if time.monotonic() - written > _BETWEEN_WRITES:
                written = time.monotonic()
                for number in tuple(self._recordings):
                    self._do(number, Recording.flush)

    def _take(self, note: _Note) -> None:
        match note:
            case Beginning():
                self._begin(note)
            case Snapshot():
                self._each(lambda recording: recording.frame(note))
            case _Changed():
                self._each(lambda recording: recording.change(note.change, note.index, note.snapshot))
            case _Ended():
                self._do(note.number, lambda recording: recording.end(note.time))
                self._recordings.pop(note.number, None)
            case _Removed():
                self._recordings.pop(note.number, None)
                self._shelf.remove(note.number)
            case _Closed():
                self._close_all()

    def _begin(self, beginning: Beginning) -> None:
        path = self._shelf.path(beginning.number)
        self._attempt(path, lambda: self._open(path, beginning))

    def _open(self, path: Path, beginning: Beginning) -> None:
        self._shelf.prepare()
        self._shelf.make_room({*self._recordings, beginning.number})
        self._recordings[beginning.number] = Recording(path, beginning)

    def _each(self, action: Callable[[Recording], None]) -> None:
        for number in tuple(self._recordings):
            self._do(number, action)

    def _do(self, number: int, action: Callable[[Recording], None]) -> None:
        """Does something to a recording; one that cannot be written any more ends there."""
        recording = self._recordings.get(number)
        if recording is not None and not self._attempt(self._shelf.path(number), lambda: action(recording)):
            del self._recordings[number]

    def _close_all(self) -> None:
        for number in tuple(self._recordings):
            self._do(number, Recording.flush)
        self._recordings.clear()

    def _attempt(self, path: Path, action: Callable[[], None]) -> bool:
        try:
            action()
        except Exception as error:  # noqa: BLE001 - a replay is never worth a job
            _log.warning("%s: this replay is not gone on with: %s", path.name, error)
            return False
        return True
