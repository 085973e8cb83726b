"""The recording of a run: one file in the data directory."""

from __future__ import annotations

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

from skiros_py.errors import FileError
from skiros_py.ports.models import write_robot_urdf
from skiros_py.recording import RUNS, SUFFIX, Recorder, RecordingWriter
from skiros_py.recording.pictures import record_pictures
from skiros_py.station.recordings.sources import camera_of, frames_of, record_looks, record_view
from skiros_py.station.session import Session
from skiros_py.tasks.task_manager import TaskManager
from skiros_py.world.scene.writer import scene_turtle

_PACKAGES = ("skiros-py", "pybullet", "numpy", "up-fast-downward", "kairos-planner")
"""Packages whose versions are recorded."""


def run_recorder(session: Session, data: Path) -> Recorder:
    """Returns the recorder of a run, which writes to a data directory.

    Args:
        session: The session, not yet running.
        data: The data directory.

    Raises:
        FileError: The recording cannot be created there.
    """
    folder = data / RUNS
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise FileError(folder, f"cannot be made: {error.strerror or error}") from error
    camera = camera_of(session)
    sources = [_tasks(session.tasks), *([record_pictures(camera)] if camera is not None else [])]
    return recorder_of(session, RecordingWriter(_free(folder, Path(session.scene).stem)), sources)


def recorder_of(
    session: Session, writer: RecordingWriter, sources: Sequence[Callable[[Recorder], object]] = (), **about: object
) -> Recorder:
    """Returns a recorder of a session, with frames, scene and looks in addition to the common topics."""
    own = (_attach_models(session), record_view, record_looks)
    return Recorder(writer, session.runtime, _about(session) | about, (*own, *sources), frames_of(session))


def _attach_models(session: Session) -> Callable[[Recorder], None]:
    """Attaches the believed scene and the model of each robot."""

    def attach(recorder: Recorder) -> None:
        index = session.world.snapshot()
        recorder.writer.attach("scene.ttl", "text/turtle", lambda: scene_turtle(index).encode())
        for robot in session.spec.robots:
            if session.runtime.context.frames.kinematics(robot) is not None:
                recorder.writer.attach(f"{robot.model}.urdf", "application/xml", partial(_urdf, robot.model))

    return attach


def _urdf(model: str) -> bytes:
    """Returns a robot model whose meshes have package URLs, which other programs can resolve."""
    with TemporaryDirectory(prefix="skiros-model-") as folder:
        text = write_robot_urdf(model, Path(folder)).read_text(encoding="utf-8")
    return re.sub(r'filename="[^"]*/site-packages/', 'filename="package://', text).encode()


def _tasks(tasks: TaskManager) -> Callable[[Recorder], None]:
    return lambda recorder: recorder.on_end(tasks.on_begin(recorder.follow))


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
