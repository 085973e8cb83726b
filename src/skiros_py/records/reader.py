"""Reads the record of a run, also while it is still being written or when it was cut off."""

from __future__ import annotations

import json
import sqlite3
import zlib
from bisect import bisect_right
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from skiros_py.errors import FileError, UsageError
from skiros_py.records.frames import Frame, Layout, decode_block
from skiros_py.records.schema import SCHEMA
from skiros_py.world.change import Change
from skiros_py.world.index import Index
from skiros_py.world.journal.codec import decode_change
from skiros_py.world.journal.content import Content
from skiros_py.world.journal.snapshot import read_piece

__all__ = ["RUNS", "SUFFIX", "Picture", "Record", "find_record"]

RUNS = "runs"
"""Folder in a data directory that holds the records of its runs."""
SUFFIX = ".record"
"""How the name of a record ends."""
_SLACK = 1e-4
"""Times of snapshots are rounded by less than that [s]."""
_BROKEN = (ValueError, KeyError, TypeError, IndexError, zlib.error)


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


class Record:
    """The record of a run; nothing in it is changed. Close it, or use it in a ``with``.

    Args:
        path: The file.

    Attributes:
        path: The file.
        meta: What is known of the run as a whole: scene, seed, goal, versions, robots.

    Raises:
        FileError: There is no such file, it is damaged or another program's, or cannot be read.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        if not path.is_file():
            raise FileError(path, "there is no such record")
        with self._faults():
            self._connection = sqlite3.connect(f"{path.resolve().as_uri()}?mode=ro", uri=True, timeout=2.0)
            try:
                SCHEMA.check(self._connection, path)
                self.meta: dict[str, Any] = {key: json.loads(data) for key, data in self._rows("SELECT * FROM meta")}
                self._layout = Layout.from_json(self.meta["layout"]) if "layout" in self.meta else Layout((), (), ())
            except BaseException:
                self._connection.close()
                raise

    # ------------------------------------------------------------------ what it holds

    @property
    def complete(self) -> bool:
        """False while it is being written, and for ever when the process was killed."""
        return "ended" in self.meta

    @property
    def tasks(self) -> tuple[dict[str, Any], ...]:
        """Name, goal and report of each task; the report is None for what did not end."""
        return self._plain("SELECT id, data FROM tasks ORDER BY id")

    @property
    def events(self) -> tuple[dict[str, Any], ...]:
        """What the modules told of themselves, in order, with the run time [s]."""
        return self._plain("SELECT time, data FROM events ORDER BY id")

    @property
    def trace(self) -> tuple[dict[str, Any], ...]:
        """What happened in the tasks, in order."""
        return self._plain("SELECT task, data FROM trace ORDER BY id")

    @property
    def forgotten(self) -> dict[str, int]:
        """How much had to be left out for lack of room, by kind."""
        with self._faults():
            return dict(self._rows("SELECT what, count FROM forgotten ORDER BY what"))

    def changes(self) -> Iterator[Change]:
        """Yields the changes of the world, in order."""
        with self._faults():
            for (data,) in self._rows("SELECT data FROM changes ORDER BY id"):
                first, *others = json.loads(zlib.decompress(data))
                yield decode_change(first, others)

    def pictures(self) -> Iterator[Picture]:
        """Yields the pictures of the key moments, in order."""
        with self._faults():
            for row in self._rows("SELECT time, caption, data FROM pictures ORDER BY time, id"):
                yield Picture(*row)

    def frames(self, start: float = float("-inf"), end: float = float("inf")) -> Iterator[Frame]:
        """Yields the snapshots from one run time to another [s], in order."""
        with self._faults():
            for (data,) in self._rows("SELECT data FROM frames WHERE start <= ? ORDER BY start", end):
                times, rows = decode_block(data)
                for time, row in zip(times.tolist(), rows.tolist(), strict=True):
                    if start <= time <= end:
                        yield self._layout.frame(time, row)

    def frame(self, time: float) -> Frame:
        """Returns the last snapshot up to a run time [s], or the first.

        Raises:
            UsageError: There is none.
        """
        with self._faults():
            starts = [start for (start,) in self._rows("SELECT start FROM frames ORDER BY start")]
        if not starts:
            raise UsageError(f"{self.path}: there are no snapshots in it")
        first = starts[max(0, bisect_right(starts, time + _SLACK) - 1)]
        block = list(self.frames(first - _SLACK, max(first, time) + _SLACK))
        return block[-1] if block[-1].time <= time + _SLACK else block[0]

    def world_at(self, time: float, beginning: Index) -> Index:
        """Returns what was believed at a run time.

        Args:
            time: Run time [s].
            beginning: What there is without any change: the individuals of the ontology.

        Raises:
            UsageError: The record does not go back to the start of the run, because it had to be thinned out.
        """
        content = Content()
        with self._faults():
            pieces = self._rows("SELECT data FROM beginning ORDER BY part")
            for (data,) in pieces:
                edits, stamps = json.loads(zlib.decompress(data))
                read_piece(content, edits, stamps)
            if not pieces or "changes" in self.forgotten:
                raise UsageError(f"{self.path}: what was believed at the start is no longer in it")
            for change in self.changes():
                if change.time <= time:
                    content.take(change)
            return content.index(beginning)

    def as_json(self) -> dict[str, Any]:
        """Returns all but snapshots and pictures as plain data; of those it says how many there are."""
        times = [frame.time for frame in self.frames()]
        shots = [{"time": shot.time, "caption": shot.caption} for shot in self.pictures()]
        return {
            "record": str(self.path),
            "complete": self.complete,
            "meta": self.meta,
            "tasks": list(self.tasks),
            "events": list(self.events),
            "trace": list(self.trace),
            "changes": [change.as_json() for change in self.changes()],
            "pictures": shots,
            "snapshots": {"count": len(times), "first": min(times, default=None), "last": max(times, default=None)},
            "forgotten": self.forgotten,
        }

    # ------------------------------------------------------------------ reading

    def _plain(self, sql: str) -> tuple[dict[str, Any], ...]:
        """Returns rows of a number and a text as plain data; the number goes in under its column's name."""
        name = sql.split()[1].rstrip(",")
        with self._faults():
            return tuple({name: number, **json.loads(data)} for number, data in self._rows(sql))

    def _rows(self, sql: str, *values: object) -> list[tuple[Any, ...]]:
        return self._connection.execute(sql, values).fetchall()

    @contextmanager
    def _faults(self) -> Iterator[None]:
        try:
            yield
        except sqlite3.OperationalError as error:
            raise FileError(
                self.path, f"the record cannot be read: mind the rights of file and folder ({error})"
            ) from error
        except (sqlite3.Error, *_BROKEN) as error:
            raise FileError(self.path, f"the file is damaged, or no {SCHEMA.kind} ({error})") from error

    def close(self) -> None:
        """Closes the file; may be called twice."""
        self._connection.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


def find_record(path: Path) -> Path:
    """Returns the file of a record.

    Args:
        path: The file, or a data directory for the record of its latest run.

    Raises:
        FileError: There is none.
    """
    if not path.is_dir():
        return path
    found = [*path.glob(f"{RUNS}/*{SUFFIX}"), *path.glob(f"*{SUFFIX}")]
    if not found:
        raise FileError(path, "there is no record of a run in it: 'skiros run SCENE --data DIR' keeps one of each run")
    return max(found, key=lambda file: file.stem)
