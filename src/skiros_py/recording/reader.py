"""Reads a recording, also while it is still being written or after it was cut off."""

from __future__ import annotations

import base64
import io
import json
import mmap
import struct
from bisect import bisect_right
from collections import Counter
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path
from typing import IO, Any, cast

from mcap import records
from mcap.exceptions import McapError
from mcap.reader import SeekingReader
from mcap.stream_reader import MAGIC_SIZE, StreamReader, breakup_chunk
from mcap.summary import Summary
from zstandard import ZstdError

from skiros_py.errors import FileError, UsageError
from skiros_py.world.change import Change
from skiros_py.world.index import Index
from skiros_py.world.journal.records import decode_change
from skiros_py.world.journal.snapshot import read_piece

RUNS = "runs"
"""Folder in a data directory that holds the recordings of its runs."""
JOBS = "recordings"
"""Folder in the data directory of a server that holds the recordings of its jobs."""
SUFFIX = ".mcap"
"""How the name of a recording ends."""
DEVICES = "/devices/"
"""Prefix of the topics of device states."""
JOINTS, FRAMES = "/joints", "/frames"
"""Topics of the positions of all joints by "robot/joint", and of the frame tree."""
_HEAD = struct.Struct("<BQ")
"""Every MCAP record begins with its kind and the length of its content."""
_BROKEN = (McapError, ZstdError, struct.error, ValueError, KeyError, TypeError, IndexError, OverflowError, MemoryError)


@dataclass(frozen=True, slots=True)
class Frame:
    """States of the devices at one moment.

    Attributes:
        time: Run time [s].
        devices: State by device id, as plain data.
    """

    time: float
    devices: dict[str, dict[str, Any]]


@dataclass(frozen=True, slots=True)
class Picture:
    """A picture of a key moment.

    Attributes:
        time: Run time [s].
        caption: What had just happened.
        data: A WebP file.
    """

    time: float
    caption: str
    data: bytes


class Recording(AbstractContextManager["Recording"]):
    """A recording, which is never changed. Close it, or use it in a ``with``.

    Args:
        path: The file.

    Attributes:
        path: The file.
        meta: Facts about the whole run: scene, seed, goal, versions, robots.
        parts: Run, start and shift of each part, where it was continued by other processes.
        left_out: Number of messages that were left out for lack of room, by topic.

    Raises:
        FileError: There is no such file, it cannot be read, is damaged or no recording.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        if not path.is_file():
            raise FileError(path, "there is no such recording")
        with self._faults():
            with path.open("rb") as file:
                self._stream = mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ)
            try:
                self._reader = _Reader(self._stream)
                self.meta: dict[str, Any] = {}
                self.parts: list[dict[str, Any]] = []
                self.left_out: dict[str, int] = {}
                for record in self.metadata():
                    data = {key: json.loads(text) for key, text in record.metadata.items()}
                    match record.name:
                        case "part":
                            self.parts.append(data)
                        case "left out":
                            self.left_out |= data
                        case "run":
                            self.meta |= data
            except BaseException:
                self._stream.close()
                raise

    # ------------------------------------------------------------------ what it holds

    @property
    def complete(self) -> bool:
        """False while it is being written, and for good when the process was killed."""
        return self.meta.get("ended") is not None

    @property
    def topics(self) -> dict[str, int]:
        """Number of messages by topic."""
        return self._reader.counts

    @property
    def start(self) -> float:
        """Run time of the first message [s]."""
        return min((chunk.message_start_time for chunk in self._reader.chunks), default=0) / 1e9

    @property
    def end(self) -> float:
        """Run time of the last message [s]."""
        return max((chunk.message_end_time for chunk in self._reader.chunks), default=0) / 1e9

    def median_time(self) -> float:
        """Returns the run time before which half of the content lies [s]."""
        chunks = sorted(self._reader.chunks, key=lambda chunk: chunk.message_end_time)
        half, so_far = sum(chunk.compressed_size for chunk in chunks) / 2.0, 0
        for chunk in chunks:
            so_far += chunk.compressed_size
            if so_far >= half:
                return chunk.message_end_time / 1e9
        return 0.0

    def messages(
        self, *topics: str, start: float = float("-inf"), end: float = float("inf")
    ) -> Iterator[tuple[str, float, dict[str, Any]]]:
        """Yields topic, run time [s] and message, in order of time.

        Args:
            topics: Names of topics; none for all. One that ends with a slash stands for all below it.
            start: First run time [s].
            end: Last run time [s].
        """
        for _, channel, message in self.raw_messages(*topics, start=start, end=end):
            yield channel.topic, message.log_time / 1e9, json.loads(message.data)

    def raw_messages(
        self, *topics: str, start: float = float("-inf"), end: float = float("inf")
    ) -> Iterator[tuple[records.Schema | None, records.Channel, records.Message]]:
        """Yields messages as they are in the file, with schema and channel; see :meth:`messages`."""
        wanted = [name for name in self.topics if not topics or any(_below(name, topic) for topic in topics)]
        with self._faults():
            if wanted and self._reader.chunks:
                yield from self._reader.iter_messages(
                    wanted,
                    starting_at=nanoseconds(start) if start > 0.0 else None,
                    ending_before=nanoseconds(end) + 1 if end < float("inf") else None,
                )

    def attachments(self) -> Iterator[records.Attachment]:
        """Yields the attached files."""
        with self._faults():
            yield from self._reader.iter_attachments()

    def metadata(self) -> Iterator[records.Metadata]:
        """Yields the records with facts about the whole."""
        with self._faults():
            yield from self._reader.iter_metadata()

    # ------------------------------------------------------------------ what its topics say

    @property
    def tasks(self) -> tuple[dict[str, Any], ...]:
        """Name, goal and report of each task; the report is None for a task that did not end."""
        last = {task["number"]: task for _, _, task in self.messages("/tasks")}
        return tuple(last[number] for number in sorted(last))

    @property
    def events(self) -> tuple[dict[str, Any], ...]:
        """Start, progress and end of every skill and primitive, in order."""
        return tuple(message for _, _, message in self.messages("/runs") if message["kind"] != "node")

    @property
    def trace(self) -> tuple[dict[str, Any], ...]:
        """The entries of the tasks' traces, in order."""
        return tuple(message for _, _, message in self.messages("/trace"))

    def changes(self) -> Iterator[Change]:
        """Yields the changes of the world, in order."""
        with self._faults():
            for _, _, message in self.messages("/world/changes"):
                yield decode_change(json.dumps(message))

    def pictures(self) -> Iterator[Picture]:
        """Yields the pictures of the key moments, in order."""
        with self._faults():
            for _, time, message in self.messages("/camera/overview"):
                yield Picture(time, message["caption"], base64.b64decode(message["data"]))

    def frames(self, start: float = float("-inf"), end: float = float("inf")) -> Iterator[Frame]:
        """Yields the states of the devices from one run time to another [s], in order.

        While nothing moves, only the first and the last one are there.
        """
        for time, group in groupby(self.messages(DEVICES, start=start, end=end), key=lambda message: message[1]):
            yield Frame(time, {topic.removeprefix(DEVICES): state for topic, _, state in group})

    def frame(self, time: float) -> Frame:
        """Returns the last states of the devices up to a run time [s], or the first.

        Raises:
            UsageError: There are none.
        """
        starts = sorted(chunk.message_start_time / 1e9 for chunk in self._reader.chunks)
        for first in reversed(starts[: max(bisect_right(starts, time), 1)]):
            block = list(self.frames(first, max(first, time)))
            if block:
                return block[-1]
        first_frame = next(self.frames(), None)
        if first_frame is None:
            raise UsageError(f"{self.path}: there are no states of devices in it")
        return first_frame

    def world_at(self, time: float, beginning: Index) -> Index:
        """Returns what was believed at a run time.

        Args:
            time: Run time [s].
            beginning: The individuals of the ontology, without any change.

        Raises:
            UsageError: The recording does not go back to the start of the run, because it had to be thinned out.
        """
        index = beginning.copy()
        with self._faults():
            pieces = [message for _, _, message in self.messages("/world/snapshot")]
            for piece in pieces:
                read_piece(index, json.dumps(piece["edits"]), json.dumps(piece["stamps"]))
            if not pieces or "/world/changes" in self.left_out:
                raise UsageError(f"{self.path}: what was believed at the start is no longer in it")
            for change in self.changes():
                if change.time <= time:
                    index.take(change)
            return index

    def as_json(self) -> dict[str, Any]:
        """Returns everything but device states and pictures as plain data; of those the number."""
        times = [frame.time for frame in self.frames()]
        return {
            "recording": str(self.path),
            "complete": self.complete,
            "meta": self.meta,
            "tasks": list(self.tasks),
            "events": list(self.events),
            "trace": list(self.trace),
            "changes": [change.as_json() for change in self.changes()],
            "pictures": [{"time": picture.time, "caption": picture.caption} for picture in self.pictures()],
            "snapshots": {"count": len(times), "first": min(times, default=None), "last": max(times, default=None)},
            "topics": self.topics,
            "forgotten": self.left_out,
        }

    # ------------------------------------------------------------------ reading

    @contextmanager
    def _faults(self) -> Iterator[None]:
        try:
            yield
        except OSError as error:
            raise FileError(self.path, f"cannot be read: {error.strerror or error}") from error
        except _BROKEN as error:
            if isinstance(error, FileError | UsageError):
                raise
            raise FileError(self.path, f"the file is damaged, or no recording of a run ({error})") from error

    def close(self) -> None:
        """Closes the file; may be called twice."""
        self._stream.close()

    def __exit__(self, *_: object) -> None:
        self.close()


class _Reader(SeekingReader):
    """Reads files without a summary, too: a process that was killed could not write one."""

    def __init__(self, stream: mmap.mmap) -> None:
        super().__init__(cast(IO[bytes], stream), validate_crcs=True, record_size_limit=len(stream))
        self._bytes = stream
        try:
            summary = super().get_summary()
        except _BROKEN:
            summary = None
        self._own = summary if summary is not None else self._scanned()
        self.chunks = self._own.chunk_indexes

    @property
    def counts(self) -> dict[str, int]:
        statistics = self._own.statistics
        assert statistics is not None
        counts = statistics.channel_message_counts
        return {channel.topic: counts.get(number, 0) for number, channel in self._own.channels.items()}

    def get_summary(self) -> Summary:
        return self._own

    def _scanned(self) -> Summary:
        """Indexes the file up to where it was cut off."""
        data, summary, counts = self._bytes, Summary(), Counter[int]()
        at = MAGIC_SIZE
        while at + _HEAD.size <= len(data):
            _, length = _HEAD.unpack_from(data, at)
            end = at + _HEAD.size + length
            if end > len(data):
                break
            record = next(StreamReader(io.BytesIO(data[at:end]), skip_magic=True, emit_chunks=True).records, None)
            if isinstance(record, records.Chunk):
                summary.chunk_indexes.append(_chunk_index(record, at, end - at))
                for one in breakup_chunk(record):
                    if isinstance(one, records.Schema):
                        summary.schemas[one.id] = one
                    elif isinstance(one, records.Channel):
                        summary.channels[one.id] = one
                    elif isinstance(one, records.Message):
                        counts[one.channel_id] += 1
            elif isinstance(record, records.Attachment):
                summary.attachment_indexes.append(
                    records.AttachmentIndex(at, end - at, 0, 0, 0, record.name, record.media_type)
                )
            elif isinstance(record, records.Metadata):
                summary.metadata_indexes.append(records.MetadataIndex(at, end - at, record.name))
            at = end
        summary.statistics = records.Statistics(0, 0, counts, 0, 0, 0, 0, 0, 0)
        return summary


def _chunk_index(chunk: records.Chunk, offset: int, length: int) -> records.ChunkIndex:
    return records.ChunkIndex(
        chunk_length=length,
        chunk_start_offset=offset,
        compression=chunk.compression,
        compressed_size=len(chunk.data),
        message_end_time=chunk.message_end_time,
        message_index_length=0,
        message_index_offsets={},
        message_start_time=chunk.message_start_time,
        uncompressed_size=chunk.uncompressed_size,
    )


def _below(name: str, topic: str) -> bool:
    return name.startswith(topic) if topic.endswith("/") else name == topic


def nanoseconds(time: float) -> int:
    """Returns a time [s] as MCAP counts it; there are none before zero."""
    return max(round(time * 1e9), 0)


def find_recording(path: Path) -> Path:
    """Returns the file of a recording.

    Args:
        path: The file, or a data directory for the recording of its latest run or job.

    Raises:
        FileError: There is none.
    """
    if not path.is_dir():
        return path
    globs = (path.glob(f"{folder}*{SUFFIX}") for folder in ("", f"{RUNS}/", f"{JOBS}/"))
    latest = [file for found in globs if (file := max(found, key=lambda one: one.stem, default=None))]
    if not latest:
        raise FileError(path, "there is no recording of a run in it: 'skiros run SCENE --data DIR' keeps one of each")
    return max(latest, key=lambda file: file.stat().st_mtime)
