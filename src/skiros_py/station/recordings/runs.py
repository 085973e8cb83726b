"""Recordings of runs and of every running job, one file each; the oldest files are deleted."""

from __future__ import annotations

import logging
import math
import platform
import re
import time
from collections.abc import Callable, Sequence
from functools import partial
from importlib.metadata import PackageNotFoundError, version
from itertools import count
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any
from uuid import uuid4

from skiros_py.errors import FileError, Refused
from skiros_py.messages import Message
from skiros_py.ports.kinematics import write_robot_urdf
from skiros_py.recording import Recorder, Recording, RecordingWriter
from skiros_py.recording.pictures import record_pictures
from skiros_py.recording.reader import RUNS, SUFFIX
from skiros_py.station.recordings.replay import replay_text
from skiros_py.station.recordings.topics import camera_of, record_observations, record_view
from skiros_py.station.session import Session
from skiros_py.tasks.handle import TaskHandle
from skiros_py.tasks.jobs.job import Job
from skiros_py.tasks.jobs.manager import JobManager
from skiros_py.tasks.trace import TraceEntry, TraceEventKind
from skiros_py.world.journal.data_directory import make_folder
from skiros_py.world.scene.writer import scene_turtle

_PACKAGES = (
    "skiros-py", "pybullet", "mujoco-core", "numpy", "up-fast-downward", "kairos-planner", "pin", "roboplan-rrt", "ssik"
)  # fmt: skip
"""Packages whose versions are recorded: results may depend on which of them are installed."""


def run_recorder(session: Session, data: Path) -> Recorder:
    """Returns the recorder of a run, which writes to a data directory.

    Args:
        session: The session, not yet running.
        data: The data directory.

    Raises:
        FileError: The recording cannot be created there.
    """
    folder = data / RUNS
    make_folder(folder)
    camera = camera_of(session)
    sources = [] if camera is None else [record_pictures(camera)]
    sources.append(lambda recorder: recorder.on_end(session.tasks.on_begin(recorder.follow)))
    return recorder_of(session, RecordingWriter(_free(folder, Path(session.scene).stem)), sources)


def recorder_of(
    session: Session, writer: RecordingWriter, sources: Sequence[Callable[[Recorder], object]] = (), **about: object
) -> Recorder:
    """Returns a recorder of a session, with scene and observations in addition to the common topics."""
    own = (_attach_models(session), record_view, record_observations)
    return Recorder(writer, session.runtime, _about(session) | about, (*own, *sources))


def _attach_models(session: Session) -> Callable[[Recorder], None]:
    """Attaches the believed scene and the models of the robots and devices."""

    def attach(recorder: Recorder) -> None:
        index = session.world.snapshot()
        recorder.writer.attach("scene.ttl", "text/turtle", lambda: scene_turtle(index).encode())
        groups = (group for group in session.spec.groups if group.model)
        modelled = (group.model for group in groups if session.runtime.context.frames.kinematics(group) is not None)
        for model in dict.fromkeys(modelled):
            recorder.writer.attach(f"{model}.urdf", "application/xml", partial(_urdf, model))

    return attach


def _urdf(model: str) -> bytes:
    """Returns a robot model whose meshes have package URLs, which other programs can resolve."""
    with TemporaryDirectory(prefix="skiros-model-") as folder:
        text = write_robot_urdf(model, Path(folder)).read_text(encoding="utf-8")
    return re.sub(r'filename="[^"]*/site-packages/', 'filename="package://', text).encode()


def _free(folder: Path, scene: str) -> Path:
    """Returns the path of a new file, named after date, time and scene."""
    name = f"{time.strftime('%Y-%m-%d_%H%M%S')}_{re.sub(r'[^A-Za-z0-9.-]+', '_', scene)}"
    names = (name if number == 1 else f"{name}-{number}" for number in count(1))
    return next(path for name in names if not (path := folder / f"{name}{SUFFIX}").exists())


def _about(session: Session) -> dict[str, Any]:
    options = session.options
    return {
        "scene": Path(session.scene).stem,
        "seed": options.seed,
        "driver": session.cell.kind,
        "pace": options.pace,
        "goal": [str(condition) for condition in session.goal],
        "config": dict(options.config),
        "planner": options.planner or options.planner_command or "",
        "versions": {"python": platform.python_version()} | _versions(),
    }


def _versions() -> dict[str, str]:
    found = {}
    for package in _PACKAGES:
        try:
            found[package] = version(package)
        except PackageNotFoundError:  # not every installation has all of them
            continue
    return found


_log = logging.getLogger(__name__)

_MOST = 200
"""Number of recordings kept."""
_ROOM = 200 * 1024 * 1024
"""Maximum total size of the recordings [bytes]."""
_LIMIT = 20 * 1024 * 1024
"""Maximum size of one recording [bytes]."""


class JobRecordings:
    """The recordings of jobs, by the numbers of the jobs, which are never reused.

    The recording of a job that was held, or interrupted by the end of the server, is continued in the same file.

    Args:
        folder: Folder of the recordings; created with the first one.
        jobs: Returns the jobs of the open session.
        most: Number of recordings kept.
        room: Maximum total size of the recordings [bytes].
    """

    def __init__(self, folder: Path, jobs: Callable[[], JobManager], most: int = _MOST, room: int = _ROOM) -> None:
        self._folder = folder
        self._jobs = jobs
        self._most = most
        self._room = room
        self._run = ""
        self._running: dict[int, Recorder] = {}
        self._writers: dict[int, RecordingWriter] = {}

    def path(self, job: str) -> Path:
        """Returns the path of the recording of a job, an MCAP file.

        Raises:
            UnknownName: There is no such job.
            Refused: It is not recorded, or its recording was deleted.
        """
        known = self._jobs().job(job)
        path = self._file(known.number)
        if not path.is_file():
            raise _no_replay(known, FileError(path, "there is no such recording"))
        return path

    def replay(self, job: str, start: float = -math.inf, end: float = math.inf) -> bytes:
        """Returns the replay of a job, or of a range of it, as JSON.

        Args:
            job: Id of the job.
            start: Start of the range [s, run time].
            end: End of the range [s].

        Raises:
            UnknownName: There is no such job.
            Refused: It is not recorded, or its recording was deleted.
        """
        known = self._jobs().job(job)
        try:
            with Recording(self._file(known.number)) as recording:
                return replay_text(recording, over=not known.state.is_open, start=start, end=end)
        except (FileError, ValueError, KeyError) as error:
            raise _no_replay(known, error) from None

    def _file(self, number: int) -> Path:
        """Returns the path of the recording of a job, whether it exists or not."""
        return self._folder / f"{number:09d}{SUFFIX}"

    # ------------------------------------------------------------------ sessions

    def open(self, session: Session) -> None:
        """Follows the jobs of a session."""
        self._run = uuid4().hex
        follow = session.tasks.on_begin(partial(self._begin, session))
        session.on_close(self._end_all, follow, session.jobs.on_remove(self._remove))

    def _end_all(self) -> None:
        """Ends the recordings of jobs that were interrupted."""
        for recorder in self._running.values():
            recorder.end(cut_off=True)
        self._running = {}

    def close(self) -> None:
        """Waits until everything is written."""
        for writer in tuple(self._writers.values()):
            writer.close()

    # ------------------------------------------------------------------ jobs

    def _begin(self, session: Session, task: TaskHandle) -> None:
        job = session.jobs.open.get(task.name)
        if job is None:
            return
        number, before = job.number, self._writers.get(job.number)
        part = {"run": self._run, "start": session.cycle.board.now}

        def prepare() -> None:
            if before is not None:
                before.close()
            self._make_room()

        writer = RecordingWriter(self._file(number), limit=_LIMIT, part=part, prepare=prepare)
        self._writers = {key: one for key, one in self._writers.items() if one.alive} | {number: writer}
        recorder = recorder_of(session, writer, job=job.id)
        self._running[number] = recorder
        recorder.start()
        recorder.follow(task)

        def on_entry(entry: TraceEntry) -> None:
            if entry.what is TraceEventKind.FINISHED and self._running.get(number) is recorder:
                del self._running[number]
                recorder.end()

        task.trace.subscribe(on_entry)

    def _remove(self, job: Job) -> None:
        recorder = self._running.pop(job.number, None)
        if recorder is not None:
            recorder.end(cut_off=True)
        writer = self._writers.get(job.number)
        if writer is not None:
            writer.end(discard=True)
        self._delete(self._file(job.number))

    def _make_room(self) -> None:
        """Deletes the oldest recordings until number and size are within limits; those being written are kept."""
        make_folder(self._folder)
        files = sorted(file for file in self._folder.glob(f"*{SUFFIX}") if file.stem.isdecimal())  # others are not ours
        sizes = {file: file.stat().st_size for file in files}
        writing = {writer.path for writer in tuple(self._writers.values()) if writer.alive}
        for file in files:
            if len(sizes) < self._most and sum(sizes.values()) <= self._room:
                return
            if file not in writing:
                self._delete(file)
                del sizes[file]

    def _delete(self, file: Path) -> None:
        try:
            file.unlink(missing_ok=True)
        except OSError as error:
            _log.warning("a recording cannot be deleted: %s", error)


def _no_replay(job: Job, error: Exception) -> Refused:
    if job.started is None:
        why = Message("it has not begun") if job.state.is_open else Message("it never began")
    elif job.state.is_open:
        why = Message("nothing is written down yet: ask again in some seconds")
    else:
        why = Message(
            "it is kept no longer, or never was ({error}): there is room for those of the last jobs only", error=error
        )
    return Refused("NoReplay", Message("there is no replay of job '{job}': {why}", job=job.id, why=why))
