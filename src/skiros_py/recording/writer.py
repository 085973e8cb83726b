"""Writes a recording: in a thread of its own, chunk by chunk, into a file that never outgrows its limit."""

from __future__ import annotations

import json
import logging
import threading
import time
from collections import Counter, deque
from collections.abc import Callable, Mapping
from contextlib import suppress
from math import inf
from pathlib import Path
from queue import Empty, SimpleQueue
from typing import Any

from mcap.well_known import MessageEncoding, SchemaEncoding
from mcap.writer import CompressionType, Writer

from skiros_py.errors import FileError, SkirosError, UsageError
from skiros_py.files import open_private
from skiros_py.interruptions import limited
from skiros_py.ports.values import Pending
from skiros_py.recording.reader import Recording, nanoseconds
from skiros_py.recording.topic import Topic

_log = logging.getLogger(__name__)

LIMIT = 64 * 1024 * 1024
"""Size of a recording where nothing else is said [bytes]."""
LEAST_LIMIT = 1024 * 1024
"""Smallest limit [bytes]."""

_FULL, _THINNED = 0.8, 0.6
"""Share of the limit at which the older half is thinned out, and to which that must bring the file."""
_SPACINGS = (1.0, 4.0, 16.0, 64.0, inf)
"""Factors of a topic's ``every`` that are tried; with the last one the older half is left out altogether."""
_LARGEST = 8
"""A single message may take one eighth of the limit."""
_PAUSE = 0.25
"""Longest wait for something to write, wall time [s]."""
_FLUSH = 1.0
"""Wall time between two chunks [s]: what is lost when the process is killed."""
_LONGEST = 10.0
"""Wall time that the encoder of a message may take [s]."""
_LONGEST_QUEUE = 20_000
"""Items that wait for a slow disk; what comes then is left out."""
_GAP = 1.0
"""Time between two parts of a recording that was continued by another process [s]."""

Write = Callable[[Topic, float, Any], None]
"""Writes a value to a topic at a run time [s]."""
_Work = Callable[[], None]


class RecordingWriter:
    """An open recording. Its methods may be called in any thread and never wait for the disk. Close it.

    When the file can no longer be written, the run goes on without a recording: see :attr:`fault`.

    Args:
        path: The file.
        limit: Largest size of the file [bytes].
        part: What is known of the run that is recorded: ``run`` (a key that no other run has) and ``start`` (its run
            time [s]); None for a file of one part.
        prepare: Called in the writer's thread before the file is opened.

    Attributes:
        path: The file.
        fault: Why nothing is written any more; empty while it is.

    Raises:
        UsageError: The limit is too small.
        FileError: The file exists already and is not to be continued, or cannot be made.
    """

    def __init__(
        self,
        path: Path,
        *,
        limit: int = LIMIT,
        part: Mapping[str, Any] | None = None,
        prepare: Callable[[], None] = lambda: None,
    ) -> None:
        if limit < LEAST_LIMIT:
            raise UsageError(f"a recording needs room for at least {LEAST_LIMIT} bytes, not {limit}")
        self.path = path
        self.fault = ""
        self._limit = limit
        self._part = part
        self._prepare = prepare
        self._shift = 0.0
        self._queue: SimpleQueue[_Work | None] = SimpleQueue()
        self._pending: deque[tuple[Topic, float, Pending[Any]]] = deque()
        self._discard = False
        self._dropped = 0
        self._left_out: Counter[str] = Counter()
        self._off: set[str] = set()
        self._every: dict[str, float] = {}
        self._opened = None if part is not None else _McapFile(path)
        self._thread = threading.Thread(target=self._write_on, name=f"recording {path.name}", daemon=True)
        self._thread.start()

    @property
    def alive(self) -> bool:
        """False when the file is finished."""
        return self._thread.is_alive()

    # ------------------------------------------------------------------ what is recorded

    def put(self, topic: Topic, time: float, value: Any) -> None:
        """Records a value at a run time [s]."""
        self._add(lambda: self._write(topic, time, value))

    def put_pending(self, topic: Topic, time: float, value: Pending[Any]) -> None:
        """Records a value that is still on its way, at the run time at which it was asked for [s]."""
        self._add(lambda: self._pending.append((topic, time, value)))

    def defer(self, work: Callable[[Write], None]) -> None:
        """Calls a function in the writer's thread, in turn with everything else; it may write any number of values."""
        self._add(lambda: work(self._write))

    def put_metadata(self, name: str, data: Mapping[str, Any]) -> None:
        """Records facts about the whole recording, as plain data; later ones replace earlier ones of the same key."""
        self._add(lambda: self._file.metadata(name, data))

    def attach(self, name: str, media_type: str, data: bytes | Callable[[], bytes]) -> None:
        """Attaches a file, which may be made in the writer's thread."""
        self._add(lambda: self._file.attach(name, media_type, data if isinstance(data, bytes) else data()))

    def end(self, *, discard: bool = False) -> None:
        """Has everything written that was put so far, and the file finished, without waiting for that.

        Args:
            discard: True to delete the file instead.
        """
        self._discard = self._discard or discard
        self._queue.put(None)
        if discard and not self._thread.is_alive():
            self.path.unlink(missing_ok=True)

    def close(self) -> None:
        """Ends it and waits until the file is finished; may be called twice."""
        self.end()
        self._thread.join()

    # ------------------------------------------------------------------ the thread

    @property
    def _file(self) -> _McapFile:
        assert self._opened is not None
        return self._opened

    def _add(self, work: _Work) -> None:
        if self.fault:
            return
        if self._queue.qsize() < _LONGEST_QUEUE:
            self._queue.put(work)
        else:
            self._dropped += 1

    def _write_on(self) -> None:
        """Writes until the end, or until the file cannot be written."""
        try:
            self._open()
            self._write_all()
        except Exception as error:  # noqa: BLE001 - a recording must never disturb a run
            self.fault = str(error) or type(error).__name__
            _log.warning("recording of %s stopped: %s", self.path.name, self.fault)
        finally:
            if self._opened is not None:
                self._opened.close()
            if self._discard:
                self.path.unlink(missing_ok=True)

    def _open(self) -> None:
        self._prepare()
        if self._part is None:
            return
        if not self.path.exists():
            self._opened = _McapFile(self.path)
        else:
            with Recording(self.path) as before:
                self._rewrite(before, lambda _topic, _time: True)
                if before.parts and before.parts[-1]["run"] == self._part["run"]:
                    self._shift = before.parts[-1]["shift"]
                else:
                    self._shift = max(0.0, before.end + _GAP - self._part["start"])
        self._file.metadata("part", {**self._part, "shift": self._shift})
        self._file.flush()

    def _write_all(self) -> None:
        flushed, going = time.monotonic(), True
        while going:
            try:
                work = self._queue.get(timeout=_PAUSE)
                going = work is not None
                if work is not None:
                    work()
            except Empty:
                pass
            self._write_pending(last=not going)
            if not going or time.monotonic() - flushed > _FLUSH or self._file.pending > self._limit // _LARGEST:
                self._left_out["everything"] += self._dropped
                self._dropped = 0
                self._file.flush()
                self._keep_limit()
                flushed = time.monotonic()
        if any(self._left_out.values()):
            self._file.metadata("left out", +self._left_out)
        self._file.finish()

    def _write(self, topic: Topic, time: float, value: Any) -> None:
        if topic.name in self._off:
            return
        at = time + self._shift
        try:
            message = limited(lambda: f"the encoder of {topic.name}", _LONGEST, lambda: topic.encode(at, value))
            data = json.dumps(message, separators=(",", ":"), allow_nan=False).encode()
        except Exception as error:  # noqa: BLE001 - the code of a plug-in
            self._off.add(topic.name)
            _log.warning("%s is no longer recorded: its encoder raised %s: %s", topic.name, type(error).__name__, error)
            self._file.metadata("switched off", {topic.name: f"{type(error).__name__}: {error}"})
            return
        if len(data) > self._limit // _LARGEST:
            self._left_out[topic.name] += 1
            return
        if topic.every is not None:
            self._every[topic.name] = topic.every
        self._file.message(topic, at, data)

    def _write_pending(self, *, last: bool) -> None:
        """Writes the values that have arrived; at the end it waits for all."""
        while self._pending and (last or self._pending[0][2].done()):
            topic, at, value = self._pending.popleft()
            try:
                self._write(topic, at, value.result())
            except SkirosError as error:  # the worker or device is gone
                _log.debug("%s: a value is missing: %s", topic.name, error)

    # ------------------------------------------------------------------ room

    def _keep_limit(self) -> None:
        """Thins out the older half when the file has grown too large."""
        if self._file.size <= self._limit * _FULL:
            return
        for factor in _SPACINGS:
            with Recording(self.path) as before:
                self._thin(before, before.median_time(), factor)
            if self._file.size <= self._limit * _THINNED:
                return

    def _thin(self, before: Recording, until: float, factor: float) -> None:
        last: dict[str, float] = {}

        def keep(topic: str, time: float) -> bool:
            every = self._every.get(topic)
            if time > until or (every is None and factor < inf):
                return True
            if every is not None and time - last.get(topic, -inf) >= every * factor:
                last[topic] = time
                return True
            self._left_out[topic] += 1
            return False

        self._rewrite(before, keep)

    def _rewrite(self, before: Recording, keep: Callable[[str, float], bool]) -> None:
        """Replaces the file by one with the messages of it that are to be kept, and goes on writing to that."""
        path = self.path.with_suffix(".part")
        file = _McapFile(path, replace=True)
        try:
            file.copy(before, keep)
            file.flush()
            path.replace(self.path)
        except BaseException:
            file.close()
            raise
        if self._opened is not None:
            self._opened.close()
        self._opened = file


def export(recording: Recording, path: Path) -> None:
    """Writes a copy of a recording that is complete with its index, also of one that was cut off.

    Raises:
        FileError: The file exists already, or cannot be made.
    """
    file = _McapFile(path, private=False)
    try:
        file.copy(recording, lambda _topic, _time: True)
        file.finish()
    finally:
        file.close()


class _McapFile:
    """An MCAP file that is being written; see :class:`RecordingWriter` for what is raised."""

    def __init__(self, path: Path, *, replace: bool = False, private: bool = True) -> None:
        mode, opener = "wb" if replace else "xb", open_private if private else None
        try:
            self._stream = open(path, mode, opener=opener)  # noqa: SIM115 - Path.open takes no opener
        except FileExistsError:
            raise FileError(path, "there is a recording already: choose another name") from None
        except OSError as error:
            raise FileError(path, f"cannot be made: {error.strerror or error}") from error
        self._writer = Writer(self._stream, chunk_size=1 << 40, compression=CompressionType.ZSTD)
        self._writer.start("skiros")
        self._schemas: dict[str, int] = {}
        self._channels: dict[str, int] = {}
        self.pending = 0

    @property
    def size(self) -> int:
        """Bytes on the disk."""
        return self._stream.tell()

    def message(self, topic: Topic, time: float, data: bytes) -> None:
        if topic.name not in self._channels:
            schema = json.dumps(topic.schema.data, separators=(",", ":")).encode()
            self._add_channel(topic.name, topic.schema.name, schema)
        self._add(topic.name, nanoseconds(time), data)

    def metadata(self, name: str, data: Mapping[str, Any]) -> None:
        self.flush()  # it may say that the run ended: then all messages must be there
        self._writer.add_metadata(name, {key: json.dumps(value, default=str) for key, value in data.items()})

    def attach(self, name: str, media_type: str, data: bytes) -> None:
        self._writer.add_attachment(0, 0, name, media_type, data)

    def copy(self, other: Recording, keep: Callable[[str, float], bool]) -> None:
        """Takes over what another recording holds; of the messages those of which topic and time [s] are to be kept."""
        for attachment in other.attachments():
            self._writer.add_attachment(0, 0, attachment.name, attachment.media_type, attachment.data)
        for record in other.metadata():
            self._writer.add_metadata(record.name, record.metadata)
        for schema, channel, message in other.raw_messages():
            if keep(channel.topic, message.log_time / 1e9):
                if channel.topic not in self._channels and schema is not None:
                    self._add_channel(channel.topic, schema.name, schema.data)
                self._add(channel.topic, message.log_time, message.data)
            if self.pending > 1 << 20:
                self.flush()
                time.sleep(0.001)  # other threads of the process go first

    def flush(self) -> None:
        self._writer.flush()  # type: ignore[no-untyped-call]
        self.pending = 0

    def finish(self) -> None:
        self._writer.finish()  # type: ignore[no-untyped-call]
        self._stream.flush()

    def close(self) -> None:
        with suppress(OSError):  # what is not written yet: the disk is full
            self._stream.close()

    def _add_channel(self, topic: str, schema: str, data: bytes) -> None:
        if schema not in self._schemas:
            self._schemas[schema] = self._writer.register_schema(schema, SchemaEncoding.JSONSchema, data)
        self._channels[topic] = self._writer.register_channel(topic, MessageEncoding.JSON, self._schemas[schema])

    def _add(self, topic: str, time: int, data: bytes) -> None:
        self._writer.add_message(self._channels[topic], time, data, time)
        self.pending += len(data)
