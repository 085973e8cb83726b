"""Pictures of a run from outside: a contact sheet of the key moments, or an animation."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from skiros_py.errors import UsageError
from skiros_py.execution.monitor import ModuleEvent, Status
from skiros_py.robot.pending import Pending

if TYPE_CHECKING:
    from PIL.Image import Image

    from skiros_py.runtime import Session

__all__ = ["Recorder", "check_recording"]

_SHEET, _ANIMATIONS = ".png", (".gif", ".webp")
_WIDTH, _HEIGHT = 480, 360
_EVERY = 1.0
"""Time between two pictures of an animation [s]."""
_WHILE = 1.0
"""A primitive that took at least so long is worth a picture when it ends [s]."""
_COLUMNS = 4
_WORDS = {Status.TERMINATED: "done", Status.ERROR: "failed"}


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


class Recorder:
    """Takes pictures: for a contact sheet when something that took a while ends, for an animation regularly.

    Args:
        session: The session, not yet running.
        path: Where the recording will go; its ending says which of the two is wanted.
    """

    def __init__(self, session: Session, path: Path) -> None:
        self._session = session
        self._path = path
        self._shots: list[_Shot] = []
        self._next = 0.0
        self._started: dict[str, float] = {}
        if path.suffix == _SHEET:
            session.monitor.subscribe(self._on_event)
        else:
            session.cycle.observe(self._on_cycle)

    def _on_event(self, event: ModuleEvent) -> None:
        if event.status is Status.STARTED:
            self._started[event.module] = event.time
        telling = event.kind == "skill" or event.time - self._started.get(event.module, event.time) >= _WHILE
        if telling and event.status in _WORDS:
            self._shots.append(self._shoot(f"{event.module} {event.target} {_WORDS[event.status]}"))

    def _on_cycle(self) -> None:
        now = self._session.cycle.board.snapshot.time
        if now >= self._next:
            self._next = now + _EVERY
            self._shots.append(self._shoot(""))

    def _shoot(self, caption: str) -> _Shot:
        """Looks over the robot's shoulder at where it works."""
        board = self._session.cycle.board.snapshot
        base = next(iter(board.bases.values())).pose
        x, y, _ = base.position
        eye = base.apply(_vector(-0.9, -1.5, 1.7))
        picture = self._session.simulation.picture(
            (float(eye[0]), float(eye[1]), float(eye[2])),
            (x + 0.5 * math.cos(base.yaw), y + 0.5 * math.sin(base.yaw), 0.5),
            width=_WIDTH,
            height=_HEIGHT,
        )
        return _Shot(board.time, caption, picture)

    def write(self) -> None:
        """Writes what was recorded.

        Raises:
            UsageError: The file cannot be written any more.
        """
        try:
            pictures = [_captioned(shot) for shot in self._shots]
            if self._path.suffix == _SHEET or not pictures:
                _contact_sheet(pictures).save(self._path)
            else:
                pictures[0].save(self._path, save_all=True, append_images=pictures[1:], duration=100, loop=0)
        except OSError as error:
            raise UsageError(f"--record {self._path} cannot be written: {error.strerror or error}") from error


def _vector(x: float, y: float, z: float) -> Any:
    import numpy as np

    return np.array([x, y, z])


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
    sheet = Image.new("RGB", (_COLUMNS * _WIDTH, rows * _HEIGHT), (255, 255, 255))
    for index, picture in enumerate(pictures):
        sheet.paste(picture, ((index % _COLUMNS) * _WIDTH, (index // _COLUMNS) * _HEIGHT))
    return sheet
