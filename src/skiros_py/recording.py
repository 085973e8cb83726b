"""What is kept of a run: its record, and on request a contact sheet of the key moments or an animation."""

from __future__ import annotations

import math
import platform
import re
import time
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING, Any

from skiros_py.errors import FileError, UsageError
from skiros_py.ports.pending import Pending
from skiros_py.ports.values import Snapshot
from skiros_py.records.pictures import HEIGHT, WIDTH, KeyMoments, over_the_shoulder
from skiros_py.records.reader import RUNS, SUFFIX
from skiros_py.records.recorder import RunRecorder

if TYPE_CHECKING:
    from PIL.Image import Image

    from skiros_py.station.session import Session

__all__ = ["RunPictures", "check_recording", "run_recorder"]

_SHEET, _ANIMATIONS = ".png", (".gif", ".webp")
_EVERY = 1.0
"""Time between two pictures of an animation [s]."""
_COLUMNS = 4
_PACKAGES = ("skiros-py", "pybullet", "numpy", "up-fast-downward", "kairos-planner")
"""Whose versions a record names."""


def check_recording(path: Path, *, fake: bool) -> None:
    """Checks a recording's file before anything starts.

    Raises:
        UsageError: It cannot be written, is of an unknown kind, or there is nothing to see.
    """
    if fake:
        raise UsageError("--record needs physics: a fake run has nothing to see")
    if path.suffix not in (_SHEET, *_ANIMATIONS):
        raise UsageError(f"--record {path}: use .png for a contact sheet, .gif or .webp for an animation")
    new = not path.exists()
    try:
        with path.open("ab"):
            pass
        if new:
            path.unlink()
    except OSError as error:
        raise UsageError(f"--record {path} cannot be written: {error.strerror}") from error


@dataclass(frozen=True, slots=True)
class _Shot:
    time: float
    caption: str
    picture: Pending[Any]


class RunPictures:
    """Takes pictures of a run: for a contact sheet when something that took a while ends, for an animation regularly.

    Args:
        session: The session, not yet running.
        path: Where the recording will go; its ending says which of the two is wanted.
    """

    def __init__(self, session: Session, path: Path) -> None:
        self._session = session
        self._path = path
        self._shots: list[_Shot] = []
        self._next = 0.0
        if path.suffix == _SHEET:
            self._leave = KeyMoments(session.monitor, self._shoot).leave
        else:
            self._leave = session.cycle.observe(self._on_cycle)

    def _on_cycle(self) -> None:
        now = self._session.cycle.board.snapshot.time
        if now >= self._next:
            self._next = now + _EVERY
            self._shoot("", "")

    def _shoot(self, caption: str, agent: str) -> None:
        snapshot = self._session.cycle.board.snapshot
        self._shots.append(_Shot(snapshot.time, caption, _picture(self._session, snapshot, agent)))

    def write(self) -> None:
        """Takes no more pictures, and writes those it has.

        Raises:
            UsageError: The file cannot be written any more.
        """
        self._leave()
        try:
            pictures = [_captioned(shot) for shot in self._shots]
            if self._path.suffix == _SHEET or not pictures:
                _contact_sheet(pictures).save(self._path)
            else:
                pictures[0].save(self._path, save_all=True, append_images=pictures[1:], duration=100, loop=0)
        except OSError as error:
            raise UsageError(f"--record {self._path} cannot be written: {error.strerror or error}") from error


def _picture(session: Session, snapshot: Snapshot, agent: str) -> Pending[Any]:
    """Looks over a robot's shoulder at where it works; over the first one's where nobody knows whose."""
    robots = session.runtime.context.cell.robots
    robot = next((robot for robot in robots if robot.has(agent)), robots[0])
    eye, target = over_the_shoulder(robot.pose(snapshot))
    return session.simulation.picture(eye, target, width=WIDTH, height=HEIGHT)


def run_recorder(session: Session, data: Path) -> RunRecorder:
    """Makes the recorder of a run, whose record goes into a data directory.

    Args:
        session: The session, not yet running.
        data: The data directory.

    Raises:
        FileError: The record cannot be made there.
    """
    folder = data / RUNS
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise FileError(folder, f"cannot be made: {error.strerror or error}") from error
    physics = session.options.driver is None and not session.options.fake
    camera = (lambda snapshot, agent: _picture(session, snapshot, agent)) if physics else None
    return RunRecorder(
        _free(folder, Path(session.scene).stem), session.runtime, session.tasks, _about(session), camera=camera
    )


def _free(folder: Path, scene: str) -> Path:
    """Returns a file of a name that is free: date, time and scene."""
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


def _captioned(shot: _Shot) -> Image:
    from PIL import Image, ImageDraw

    image = Image.fromarray(shot.picture.result())
    text = f"{shot.time:.1f} s  {shot.caption}"
    draw = ImageDraw.Draw(image)
    draw.rectangle((0, 0, 8 + 7 * len(text), 16), fill=(0, 0, 0))
    draw.text((4, 2), text, fill=(255, 255, 255))
    return image


def _contact_sheet(pictures: list[Image]) -> Image:
    from PIL import Image

    rows = max(1, math.ceil(len(pictures) / _COLUMNS))
    sheet = Image.new("RGB", (_COLUMNS * WIDTH, rows * HEIGHT), (255, 255, 255))
    for index, picture in enumerate(pictures):
        sheet.paste(picture, ((index % _COLUMNS) * WIDTH, (index // _COLUMNS) * HEIGHT))
    return sheet
