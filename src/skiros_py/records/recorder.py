"""Records a run: listens to everything that goes on, and hands it to the writer."""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from itertools import count
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from skiros_py.execution.monitor import ModuleEvent
from skiros_py.execution.runtime import Runtime
from skiros_py.records.frames import Layout
from skiros_py.records.pictures import Camera, KeyMoments
from skiros_py.records.writer import LIMIT, RecordWriter
from skiros_py.tasks.handle import TaskHandle
from skiros_py.tasks.report import GoalReport
from skiros_py.tasks.task_manager import TaskManager
from skiros_py.tasks.trace import Happening, TraceEntry

__all__ = ["RunRecorder"]

_EVERY = 0.05
"""Time between two snapshots [s]."""
_BLOCK = 20
"""Snapshots in a block: what is lost of them when the process is killed, one second."""
_LARGEST_WORLD = 20_000
"""Elements of a world whose state at the start is recorded; larger ones are kept in a data directory."""


class RunRecorder:
    """Writes the record of a run while it is used in a ``with``.

    What happens is only noted in the control thread; all else is done in the writer's.

    Args:
        path: The file; it must not exist.
        runtime: What runs everything.
        tasks: The task manager, whose tasks are recorded.
        about: What shall be known of the run besides, as plain data: scene, seed, versions and so on.
        camera: Takes pictures; None where there is nothing to see.
        limit: Bytes that the record takes at most.

    Attributes:
        writer: Writes what is recorded; its ``fault`` says why it no longer does.

    Raises:
        UsageError: The limit is too small.
        FileError: The file is there already, or cannot be made.
    """

    def __init__(
        self,
        path: Path,
        runtime: Runtime,
        tasks: TaskManager,
        about: Mapping[str, Any],
        *,
        camera: Camera | None = None,
        limit: int = LIMIT,
    ) -> None:
        self._runtime = runtime
        self._tasks = tasks
        self._camera = camera
        self._stack = ExitStack()
        self._numbers = count(1)
        self._last: tuple[int, TaskHandle] | None = None
        self._board = runtime.cycle.board
        self._layout = Layout.of(self._board.snapshot)
        self._next = self._board.snapshot.time
        self._times: list[float] = []
        self._rows: list[list[float]] = []
        self._captions: dict[str, list[str]] = {}
        self._about = dict(about)
        self.writer = RecordWriter(path, limit=limit)

    def __enter__(self) -> Self:
        runtime, writer = self._runtime, self.writer
        version, index = runtime.world.state()
        own = {"layout": self._layout.as_json(), "version": version, "start": self._board.now, "wall": time.time()}
        for key, value in (self._about | own | {"robots": _robots(runtime)}).items():
            writer.put_meta(key, value)
        if sum(1 for _ in index.ids()) <= _LARGEST_WORLD:
            writer.put_beginning(index)
        self._listen(runtime.world.subscribe(writer.put_change))
        self._listen(self._tasks.on_begin(self._follow))
        self._listen(runtime.cycle.observe(self._on_cycle))
        self._listen(runtime.monitor.subscribe(self._on_event))
        if self._camera is not None:
            self._listen(KeyMoments(runtime.monitor, self._want_picture).leave)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._shoot()
        self._stack.close()
        self._flush()
        ended = "" if error is None else f"{type(error).__name__}: {error}"
        self.writer.put_meta("ended", {"time": self._board.now, "wall": time.time(), "fault": ended})
        self.writer.close()

    def conclude(self, report: GoalReport) -> None:
        """Takes the final report of the task that began last: with the truth, and the digest of the run."""
        if self._last is not None:
            number, task = self._last
            self.writer.put_task(number, _task(task, report))
        self.writer.put_meta("digest", report.digest)

    # ------------------------------------------------------------------ listening

    def _listen(self, leave: Callable[[], object]) -> None:
        self._stack.callback(leave)

    def _on_cycle(self) -> None:
        snapshot = self._board.snapshot
        if self._captions:
            self._shoot()
        if snapshot.time < self._next:
            return
        # By half a cycle early rather than always late: the cycle's times are sums of rounded numbers.
        self._next = snapshot.time + _EVERY - self._board.period / 2.0
        self._times.append(snapshot.time)
        self._rows.append(self._layout.row(snapshot))
        if len(self._times) == _BLOCK:
            self._flush()

    def _flush(self) -> None:
        if self._times:
            self.writer.put_frames(self._times, self._rows)
            self._times, self._rows = [], []

    def _on_event(self, event: ModuleEvent) -> None:
        plain = {"kind": event.kind, "module": event.module, "status": event.status.value, "code": event.code}
        plain |= {"text": event.text, "target": event.target, "agent": event.agent, "caller": event.caller}
        self.writer.put_event(event.time, plain)

    def _follow(self, task: TaskHandle) -> None:
        number = next(self._numbers)
        self._last = number, task
        self.writer.put_task(number, _task(task, None))

        def on_entry(entry: TraceEntry) -> None:
            self.writer.put_trace(entry.time, number, entry.as_json())
            if entry.what is Happening.FINISHED:
                self.writer.put_task(number, _task(task, task.report))

        self._listen(task.trace.subscribe(on_entry))

    def _want_picture(self, caption: str, agent: str) -> None:
        """Notes a moment that is worth a picture; a skill and its last primitive end in the same one."""
        self._captions.setdefault(agent, []).append(caption)

    def _shoot(self) -> None:
        """Takes the pictures of this cycle's moments."""
        wanted, self._captions = self._captions, {}
        snapshot = self._board.snapshot
        for agent, captions in wanted.items():
            if self._camera is not None:
                self.writer.put_picture(snapshot.time, ", ".join(captions), self._camera(snapshot, agent))


def _task(task: TaskHandle, report: GoalReport | None) -> dict[str, Any]:
    """Returns what is known of a task as plain data."""
    known: dict[str, Any] = {"name": task.name, "goal": [str(condition) for condition in task.goal]}
    known["report"] = None if report is None else dataclasses.asdict(report) | {"outcome": report.outcome.value}
    return known


def _robots(runtime: Runtime) -> dict[str, list[str]]:
    """Returns the devices of each robot: its subsystems are among them."""
    robots = {}
    for robot in runtime.context.cell.robots:
        robots[robot.id] = [robot.id, *(device.id for device in robot.devices)]
    return robots
