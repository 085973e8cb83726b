"""Records what goes on in a runtime: listens to it, and hands it to the writer."""

from __future__ import annotations

import dataclasses
import json
import logging
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack
from functools import partial
from itertools import count
from math import inf
from typing import Any, ParamSpec, Self

from skiros_py.execution.monitor import ModuleEvent, Status
from skiros_py.execution.runtime import Runtime
from skiros_py.geometry import Pose
from skiros_py.interruptions import limited
from skiros_py.ports.adapters import Ports
from skiros_py.ports.cell import CellSpec, RobotSpec
from skiros_py.ports.device import DeviceSpec, MobileSpec
from skiros_py.ports.device_faults import KindGuard
from skiros_py.ports.frames import FrameTree
from skiros_py.ports.signals import Value
from skiros_py.ports.values import Snapshot
from skiros_py.recording import foxglove
from skiros_py.recording.foxglove import FLAG, NUMBER, OBJECT, TEXT, WHOLE, Json, list_of, schema
from skiros_py.recording.reader import FRAMES, JOINTS
from skiros_py.recording.topic import Topic, own_schema, plain, record_plugins
from skiros_py.recording.writer import RecordingWriter, Write
from skiros_py.skills.skill import RunnableDocument
from skiros_py.tasks.handle import TaskHandle
from skiros_py.tasks.report import GoalReport
from skiros_py.tasks.trace import TraceEntry, TraceEventKind
from skiros_py.world.index import Index
from skiros_py.world.journal.snapshot import snapshot_pieces

_log = logging.getLogger(__name__)
P = ParamSpec("P")

_EVERY = 0.05
"""Time between two states of the devices [s]."""
_KEY = 1.0
"""Time between two of them where room runs short [s]."""
_LONGEST = 10.0
"""Wall time that a kind of device may take to encode a state [s]."""
_STEP = 1e-5
"""Devices whose positions differ by less have not moved [m, rad]."""
_LARGEST_WORLD = 20_000
"""Elements of a world whose state at the start is recorded; larger ones are kept in a data directory."""
_LEVELS = ((logging.CRITICAL, 5), (logging.ERROR, 4), (logging.WARNING, 3), (logging.INFO, 2))


_FRAMES = Topic(FRAMES, foxglove.FRAME_TRANSFORMS, foxglove.frame_transforms, _KEY)
_JOINTS = Topic(JOINTS, schema("skiros.Joints"), lambda _time, joints: plain(joints), _KEY)
_LOG = Topic("/log", foxglove.LOG, lambda time, line: foxglove.log(time, *line))
_RUNS = Topic("/runs", own_schema(ModuleEvent))
_TASKS = Topic("/tasks", schema("skiros.Task", number=WHOLE, name=TEXT, goal=list_of(TEXT)))
_TRACE = Topic(
    "/trace",
    schema("skiros.TraceEntry", time=NUMBER, task=WHOLE, what=TEXT, text=TEXT, skill=TEXT, arguments=OBJECT),
)
_SNAPSHOT = Topic("/world/snapshot", schema("skiros.WorldSnapshot", edits=list_of(OBJECT), stamps=OBJECT))
_DOCUMENT = schema("skiros.Document", revision=WHOLE, title=TEXT, behaviour=OBJECT)
_CHANGES = Topic(
    "/world/changes",
    schema("skiros.WorldChange", number=WHOLE, author=TEXT, reason=TEXT, time=NUMBER, edits=list_of(OBJECT)),
    lambda _time, change: change.as_json(),
)


class Recorder:
    """Records a run while it is used in a ``with``.

    What happens is only noted in the control thread; everything else is done in the writer's.

    Args:
        writer: Writes the recording; it is ended with it.
        runtime: What runs modules on the cell.
        about: Facts about the run as plain data: scene, seed, versions and so on.
        sources: Called at the start; each adds topics, as plug-ins do.

    Attributes:
        writer: Writes the recording; its ``fault`` says why it no longer does.
        runtime: What runs modules on the cell.
    """

    def __init__(
        self,
        writer: RecordingWriter,
        runtime: Runtime,
        about: Mapping[str, Any],
        sources: Iterable[Callable[[Recorder], object]] = (),
    ) -> None:
        self.writer = writer
        self.runtime = runtime
        self._about = about
        self._sources = (
            _record_devices,
            _record_runs,
            _record_signals,
            _record_documents,
            _record_log,
            _record_world,
            *sources,
            record_plugins,
        )
        self._stack = ExitStack()
        self._numbers = count(1)
        self._last: tuple[int, TaskHandle] | None = None

    def start(self) -> None:
        """Starts to record."""
        world = self.runtime.world
        own = {"version": world.version, "start": self.runtime.cycle.board.now, "wall": time.time()}
        self.writer.put_metadata("run", {**self._about, **own, "robots": _robots(self.runtime), "ended": None})
        for source in self._sources:
            contained(f"recording source {getattr(source, '__qualname__', source)}", source)(self)

    def end(self, fault: str = "", *, cut_off: bool = False) -> None:
        """Ends the recording; what was noted is still written.

        Args:
            fault: Why the run broke; empty where it did not.
            cut_off: True when the run did not come to its end.
        """
        self._stack.close()
        if not cut_off:
            ended = {"time": self.runtime.cycle.board.now, "wall": time.time(), "fault": fault}
            self.writer.put_metadata("run", {"ended": ended})
        self.writer.end()

    def __enter__(self) -> Self:
        self.start()
        return self

    def __exit__(self, kind: object, error: BaseException | None, trace: object) -> None:
        self.end("" if error is None else f"{type(error).__name__}: {error}")
        self.writer.close()

    # ------------------------------------------------------------------ for sources

    def put(self, topic: Topic, value: object, at: float | None = None) -> None:
        """Records a value; it must not change any more. Quick, and for any thread.

        Args:
            topic: Where it belongs.
            value: What the topic's encoder takes.
            at: Run time [s]; that of the current snapshot where left out.
        """
        self.writer.put(topic, self.runtime.cycle.board.snapshot.time if at is None else at, value)

    def on_cycle(self, callback: Callable[[], object]) -> None:
        """Calls a function at the end of each cycle while it records; one that raises is switched off and logged."""
        name = f"recording source {getattr(callback, '__qualname__', callback)}"
        self.on_end(self.runtime.cycle.observe(contained(name, callback)))

    def on_end(self, callback: Callable[[], object]) -> None:
        """Calls a function when the recording ends, such as one that ends a subscription; what it raises is logged."""
        self._stack.callback(_surely, callback)

    # ------------------------------------------------------------------ tasks

    def follow(self, task: TaskHandle) -> None:
        """Records a task: its trace and its report."""
        number = next(self._numbers)
        self._last = number, task
        self._put_task(number, task, None)

        def on_entry(entry: TraceEntry) -> None:
            self.put(_TRACE, {"task": number, **entry.as_json()}, entry.time)
            self.put(_LOG, (entry.text, task.name), entry.time)
            if entry.what is TraceEventKind.FINISHED:
                self._put_task(number, task, task.report)

        self.on_end(task.trace.subscribe(on_entry))

    def conclude(self, report: GoalReport) -> None:
        """Records the final report of the task that began last: with the truth, and the digest of the run."""
        if self._last is not None:
            self._put_task(*self._last, report)
        self.writer.put_metadata("run", {"digest": report.digest})

    def _put_task(self, number: int, task: TaskHandle, report: GoalReport | None) -> None:
        known: dict[str, Any] = {"number": number, "name": task.name, "goal": list(map(str, task.goal))}
        known["report"] = None if report is None else dataclasses.asdict(report) | {"outcome": report.outcome.value}
        self.put(_TASKS, known)


def contained(name: str, callback: Callable[P, object]) -> Callable[P, None]:
    """Returns a function that calls another; once that raises, it is logged by name and never called again."""
    broken = False

    def call(*args: P.args, **kwargs: P.kwargs) -> None:
        nonlocal broken
        if broken:
            return
        try:
            callback(*args, **kwargs)
        except Exception as error:  # noqa: BLE001 - a run does not end because it cannot be recorded
            broken = True
            _log.warning("%s is switched off: it raised %s: %s", name, type(error).__name__, error)

    return call


def _surely(callback: Callable[[], object]) -> None:
    try:
        callback()
    except Exception:  # noqa: BLE001 - the code of a plug-in
        _log.exception("a recording ends, though this broke: %s", getattr(callback, "__qualname__", callback))


# ---------------------------------------------------------------------- sources


def _record_runs(recorder: Recorder) -> None:
    monitor = recorder.runtime.monitor
    recorder.on_end(monitor.subscribe(lambda event: recorder.put(_RUNS, event, event.time), nodes=True))


def _record_signals(recorder: Recorder) -> None:
    """Records each signal that is read in a channel of its own, where its value changes; reads none itself."""
    board, signals = recorder.runtime.cycle.board, recorder.runtime.signals
    written: dict[str, tuple[float, Value]] = {}

    def on_cycle() -> None:
        now = board.snapshot.time
        for name, value in signals.current().items():
            last, before = written.get(name, (-inf, None))
            if value != before and now - last >= _EVERY - board.period / 2.0:
                written[name] = now, value
                recorder.put(_signal_topic(name, value), value)

    recorder.on_cycle(on_cycle)


def _signal_topic(name: str, value: Value) -> Topic:
    kind, data = next((kind, data) for type_, kind, data in _SIGNALS if isinstance(value, type_))
    return Topic(
        f"/signals/{name}", schema(f"skiros.{kind}", value=data), lambda _time, value: {"value": plain(value)}, _KEY
    )


_SIGNALS = (
    # (type of the value, name of the schema, schema of the value)
    (bool, "Boolean", FLAG),
    (int | float, "Number", NUMBER),
    (tuple, "Vector", list_of(NUMBER)),
)


def _record_documents(recorder: Recorder) -> None:
    """Records each revision of a document that runs, when it first starts; its nodes' events are among the runs."""
    written: set[tuple[str, int]] = set()

    def on_event(event: ModuleEvent) -> None:
        if event.status is not Status.STARTED:
            return
        document = recorder.runtime.managers.documents.get(event.module)
        if document is not None and (event.module, document.revision) not in written:
            written.add((event.module, document.revision))
            recorder.put(Topic(f"/documents/{event.module}", _DOCUMENT, _document), document, event.time)

    recorder.on_end(recorder.runtime.monitor.subscribe(on_event))


def _document(_time: float, document: RunnableDocument) -> Json:
    return {"revision": document.revision, "title": document.help, "behaviour": document.behaviour.to_data()}


def _record_world(recorder: Recorder) -> None:
    index, start = recorder.runtime.world.snapshot(), recorder.runtime.cycle.board.now
    recorder.writer.defer(partial(_write_world, index, start))
    recorder.on_end(recorder.runtime.world.subscribe(lambda change: recorder.put(_CHANGES, change, change.time)))


def _write_world(index: Index, time: float, write: Write) -> None:
    if sum(1 for _ in index.ids()) <= _LARGEST_WORLD:
        for edits, stamps in snapshot_pieces(index):
            write(_SNAPSHOT, time, {"edits": json.loads(edits), "stamps": json.loads(stamps)})


def _record_log(recorder: Recorder) -> None:
    handler = _LogHandler(recorder)
    logger = logging.getLogger("skiros_py")
    logger.addHandler(handler)
    recorder.on_end(lambda: logger.removeHandler(handler))


class _LogHandler(logging.Handler):
    def __init__(self, recorder: Recorder) -> None:
        super().__init__(logging.INFO)
        self._recorder = recorder

    def emit(self, record: logging.LogRecord) -> None:
        level = next((level for least, level in _LEVELS if record.levelno >= least), 1)
        self._recorder.put(_LOG, (record.getMessage(), record.name, level))


def _record_devices(recorder: Recorder) -> None:
    board = recorder.runtime.cycle.board
    devices = Devices(recorder.runtime.context.cell, recorder.runtime.context.ports)
    due = board.snapshot.time

    def on_cycle() -> None:
        nonlocal due
        snapshot = board.snapshot
        if snapshot.time >= due:
            # By half a cycle early rather than always late: the cycle's times are sums of rounded numbers.
            due = snapshot.time + _EVERY - board.period / 2.0
            recorder.writer.defer(partial(devices.take, snapshot))

    on_cycle()
    recorder.on_end(lambda: recorder.writer.defer(devices.end))
    recorder.on_end(lambda: recorder.writer.defer(partial(devices.take, board.snapshot)))
    recorder.on_cycle(on_cycle)


class Devices:
    """Writes states of devices, joints and frames, in the writer's thread: at a standstill only the first and the last.

    Args:
        cell: The devices.
        ports: Where the kinematics of robots are found.
    """

    def __init__(self, cell: CellSpec, ports: Ports) -> None:
        self._cell = cell
        self._ports = ports
        self._guard = KindGuard()  # in the writer's thread it only names what fails
        self._devices = cell.devices
        self._groups: Sequence[RobotSpec] = cell.groups
        self._topics: dict[str, Topic] = {}
        self._off: set[str] = set()
        self._written: list[float] | None = None
        self._passed: Snapshot | None = None

    def take(self, snapshot: Snapshot, write: Write) -> None:
        """Writes a snapshot, unless nothing has moved since the last one that was written."""
        measured = self._measured(snapshot)
        if self._written is not None and _same(measured, self._written):
            self._passed = snapshot
            return
        self.end(write)  # from that moment on it moves
        self._write(snapshot, write)
        self._written = measured

    def end(self, write: Write) -> None:
        """Writes the last snapshot in which nothing had moved yet."""
        if self._passed is not None:
            self._write(self._passed, write)
            self._passed = None

    def _write(self, snapshot: Snapshot, write: Write) -> None:
        states = {name: state for name, state in snapshot.devices.items() if name not in self._off}
        for name, state in states.items():
            write(self._topics[name], snapshot.time, state)
        tree = FrameTree(self._cell, dataclasses.replace(snapshot, devices=states), self._ports, self._guard)
        joints: dict[str, float] = {}
        frames: list[tuple[str, str, Pose]] = []
        for group in self._groups:
            try:
                frames += list(tree.transforms_of(group))
                joints |= {f"{group.id}/{name}": at for name, at in tree.joints(group).items()}
            except Exception as error:  # noqa: BLE001 - the code of a plug-in, or a broken model
                self._groups = [other for other in self._groups if other is not group]
                text = "frames of %s are no longer recorded: %s: %s"
                _log.warning(text, group.id, type(error).__name__, error)
        write(_JOINTS, snapshot.time, joints)
        write(_FRAMES, snapshot.time, frames)

    def _measured(self, snapshot: Snapshot) -> list[float]:
        """Returns the numbers that change when something moves [m, rad]; of a sensor, those that it measures.

        A device whose kind raises is no longer recorded.
        """
        numbers: list[float] = []
        for name, state in snapshot.devices.items():
            spec = self._devices[name]
            if name in self._off:
                continue
            try:
                if name not in self._topics:
                    encode = partial(_encoded, spec)
                    self._topics[name] = Topic(f"/devices/{name}", own_schema(type(state)), encode, every=_KEY)
                numbers += limited(lambda: "it", _LONGEST, partial(_position, spec, state))
            except Exception as error:  # noqa: BLE001 - the code of a plug-in
                self._off.add(name)
                text = "/devices/%s is no longer recorded: its kind '%s' raised %s: %s"
                _log.warning(text, name, spec.kind, type(error).__name__, error)
        return numbers


def _encoded(spec: DeviceSpec[Any, Any], _time: float, state: Any) -> Json:
    return plain(spec.encode(state))  # type: ignore[no-any-return]


def _position(spec: DeviceSpec[Any, Any], state: Any) -> list[float]:
    if isinstance(spec, MobileSpec):
        pose = spec.pose(state)
        return [*pose.position, *pose.orientation]
    return list(map(float, spec.joint_positions(state) if spec.joint_names else _numbers(spec.encode(state))))


def _numbers(data: Any) -> Iterator[float]:
    if isinstance(data, int | float):
        yield float(data)
    elif isinstance(data, list | dict):
        for one in data if isinstance(data, list) else data.values():
            yield from _numbers(one)


def _same(row: list[float], other: list[float]) -> bool:
    return len(row) == len(other) and all(abs(a - b) < _STEP for a, b in zip(row, other, strict=True))


def _robots(runtime: Runtime) -> dict[str, list[str]]:
    """Returns the devices of each robot: its subsystems are among them."""
    return {robot.id: [robot.id, *(device.id for device in robot.devices)] for robot in runtime.context.cell.robots}
