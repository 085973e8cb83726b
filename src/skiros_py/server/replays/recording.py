"""The replay of one job as it is written: frames while something moves, changes where something looks different."""

from __future__ import annotations

import base64
import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from skiros_py.api.replays import ReplayChange
from skiros_py.api.view import WorldView
from skiros_py.devices.base import BaseState
from skiros_py.geometry import Pose
from skiros_py.ports.values import Snapshot
from skiros_py.records.frames import Layout, encode_block
from skiros_py.server.replays.lines import Kind, Line, add_lines, mend
from skiros_py.station.world.view import view_of
from skiros_py.world.change import Change
from skiros_py.world.index import Index

__all__ = ["EVERY", "MOST_FRAMES", "Beginning", "Recording"]

EVERY = 0.1
"""Time between two frames at least [s]."""
MOST_FRAMES = 5000
"""Frames from which on they are kept half as often."""
_LARGEST = 20 * 1024 * 1024
"""Bytes of one replay; what comes after that is left out."""
_STEP = 1e-5
"""Numbers of which none differs by more are the same posture [m, rad]."""


@dataclass(frozen=True, slots=True)
class Beginning:
    """How a job, or what is left of one, begins.

    Attributes:
        job: Id of the job.
        number: Its number.
        run: Which run of the server it is in: a job that comes back in another one was cut off.
        snapshot: Where the devices are.
        index: What is believed.
    """

    job: str
    number: int
    run: str
    snapshot: Snapshot
    index: Index


class Recording:
    """Writes the replay of one job; used in one thread.

    Args:
        path: The file; what is there already is gone on with.
        beginning: How it begins.

    Raises:
        OSError: The file cannot be read or written.
    """

    def __init__(self, path: Path, beginning: Beginning) -> None:
        if path.exists():
            mend(path)
        self._path = path
        self._size = path.stat().st_size if path.exists() else 0
        self._layout = Layout.of(beginning.snapshot)
        self._interval = EVERY
        self._due = beginning.snapshot.time
        self._kept = 0
        self._passed: tuple[float, list[float]] | None = None
        self._stood = False
        self._last: list[float] = []
        self._times: list[float] = []
        self._rows: list[list[float]] = []
        self._seen: set[str] = set()
        self._shapes: set[str] = set()
        self._lines: list[Line] = []
        self._full = False
        self._begin(beginning)

    def _begin(self, beginning: Beginning) -> None:
        snapshot = beginning.snapshot
        head = {"job": beginning.job, "run": beginning.run, "time": snapshot.time, "layout": self._layout.as_json()}
        view = view_of(beginning.index, None, _bases(snapshot))
        self._seen, self._shapes = {element.id for element in view.elements}, set(view.shapes)
        self._lines += [(Kind.BEGINNING, json.dumps(head).encode()), (Kind.VIEW, _json(view))]
        self.frame(snapshot)
        self.flush()

    # ------------------------------------------------------------------ what happens

    def frame(self, snapshot: Snapshot) -> None:
        """Takes where the devices are; while nothing moves only the first and the last of it."""
        row = self._layout.row(snapshot)
        stands = _same(row, self._last)
        if stands or snapshot.time < self._due - EVERY / 4.0:
            self._passed, self._stood = (snapshot.time, row), stands
            return
        if self._stood:
            self._keep_passed()  # from which moment on it moves
        self._keep(snapshot.time, row)

    def change(self, change: Change, index: Index, snapshot: Snapshot) -> None:
        """Takes a change of the world; what nobody sees is left out."""
        view = view_of(index, change.marks(), _bases(snapshot))
        gone = tuple(name for name in view.gone if name in self._seen)
        if not (view.elements or gone):
            return
        self._seen = (self._seen | {element.id for element in view.elements}) - set(gone)
        shapes = {key: shape for key, shape in view.shapes.items() if key not in self._shapes}
        self._shapes |= shapes.keys()
        view = view.model_copy(update={"shapes": shapes, "gone": gone})
        self._lines.append((Kind.CHANGE, _json(ReplayChange(time=change.time, author=change.author, view=view))))

    def end(self, time: float) -> None:
        """Takes that the job, or this part of it, ended in good order [s, run time]."""
        self._keep_passed()
        self.flush()
        self._full = False
        self._lines.append((Kind.END, json.dumps({"time": time}).encode()))
        self.flush()

    def flush(self) -> None:
        """Writes what has come.

        Raises:
            OSError: The file cannot be written.
        """
        if self._times:
            block = base64.b64encode(encode_block(self._times, self._rows))
            self._lines.append((Kind.FRAMES, block))
            self._times, self._rows = [], []
        lines, self._lines = self._lines, []
        if lines and not self._full:
            self._size += add_lines(self._path, lines)
            if self._size > _LARGEST:
                self._full = True
                add_lines(self._path, [(Kind.FULL, b"")])

    # ------------------------------------------------------------------ frames

    def _keep_passed(self) -> None:
        """Keeps the last moment that was passed over."""
        if self._passed is not None:
            self._keep(*self._passed)

    def _keep(self, time: float, row: list[float]) -> None:
        self._passed, self._stood = None, False
        self._times.append(time)
        self._rows.append(row)
        self._last = row
        self._due = time + self._interval
        self._kept += 1
        if self._kept > MOST_FRAMES:  # whoever reads takes every second one of those before
            self._kept //= 2
            self._interval *= 2.0


def _same(row: list[float], other: list[float]) -> bool:
    return len(row) == len(other) and all(abs(a - b) < _STEP for a, b in zip(row, other, strict=True))


def _bases(snapshot: Snapshot) -> Mapping[str, Pose]:
    return {name: base.pose for name, base in snapshot.of(BaseState).items()}


def _json(model: WorldView | ReplayChange) -> bytes:
    return model.model_dump_json(by_alias=True).encode()
