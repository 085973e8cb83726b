"""Pictures of a run: key moments, for the recording or as a contact sheet; or an animation."""

from __future__ import annotations

import io
import math
import textwrap
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from skiros_py.errors import FileError, SkirosError, UsageError
from skiros_py.execution.monitor import ModuleEvent, Monitor, Status
from skiros_py.execution.runtime import Runtime
from skiros_py.geometry import Pose
from skiros_py.ports.values import Pending, Snapshot
from skiros_py.recording.foxglove import COMPRESSED_IMAGE, Json, Schema, compressed_image
from skiros_py.recording.recorder import Recorder, contained
from skiros_py.recording.topic import Topic

if TYPE_CHECKING:
    from numpy.typing import NDArray
    from PIL.Image import Image

    from skiros_py.recording.reader import Recording

_Point = tuple[float, float, float]
Camera = Callable[[Snapshot, str], Pending[Any]]
"""Takes a picture, RGB, of what the robot with some device does: over its shoulder."""

WIDTH, HEIGHT = 480, 360
"""Size of a picture [px]."""
_WHILE = 1.0
"""A primitive that took at least so long is worth a picture when it ends [s]."""
_WORDS = {Status.TERMINATED: "done", Status.ERROR: "failed"}
_QUALITY = 70
_SHEET, _ANIMATIONS = ".png", (".gif", ".webp")
_EVERY = 1.0
"""Time between two pictures of an animation [s]."""
_SHOWN, _SHOWN_MOMENT = 100, 1000
"""How long an animation shows one of those, and a key moment [ms]."""
_COLUMNS = 4
_LETTERS, _LINES, _LINE = 78, 3, 14
"""Most letters in a line of a caption, most lines, and the height of one [px]."""
OVERVIEW = "/camera/overview"


def _on_key_moments(monitor: Monitor, take: Callable[[str, str], None]) -> Callable[[], None]:
    """Calls a function when a picture is worth taking: a skill ends, or a primitive that took a while.

    Args:
        monitor: Events of modules.
        take: Called with a caption and the device that did it.

    Returns:
        A function that ends it.
    """
    started: dict[tuple[str, str], float] = {}

    def on_event(event: ModuleEvent) -> None:
        module = event.agent, event.module
        if event.status is Status.STARTED:
            started[module] = event.time
        is_long = event.kind == "skill" or event.time - started.get(module, event.time) >= _WHILE
        if is_long and event.status in _WORDS:
            take(" ".join(filter(None, (event.module, event.target, _WORDS[event.status]))), event.agent)

    return monitor.subscribe(on_event)


def record_pictures(camera: Camera) -> Callable[[Recorder], None]:
    """Returns a source for a recorder that adds a picture of each key moment."""

    def record(recorder: Recorder) -> None:
        captions: dict[str, list[str]] = {}

        def shoot() -> None:
            """Takes the pictures of this cycle's moments: a skill and its last primitive end in the same one."""
            snapshot = recorder.runtime.cycle.board.snapshot
            for agent, moments in captions.items():
                topic = Topic(OVERVIEW, _PICTURE, _encoder(agent, ", ".join(moments)), every=1.0)
                recorder.writer.put_pending(topic, snapshot.time, camera(snapshot, agent))
            captions.clear()

        def want(caption: str, agent: str) -> None:
            captions.setdefault(agent, []).append(caption)

        take = contained("recording source record_pictures", shoot)
        recorder.on_end(take)
        recorder.on_cycle(take)
        recorder.on_end(_on_key_moments(recorder.runtime.monitor, want))

    return record


_PICTURE = Schema(
    COMPRESSED_IMAGE.name,
    {**COMPRESSED_IMAGE.data, "properties": {**COMPRESSED_IMAGE.data["properties"], "caption": {"type": "string"}}},
)


def _encoder(agent: str, caption: str) -> Callable[[float, NDArray[Any]], Json]:
    return lambda time, image: {**compressed_image(time, f"over {agent}", webp(image), "webp"), "caption": caption}


def webp(image: NDArray[Any]) -> bytes:
    """Returns a picture, RGB, as a WebP file."""
    from PIL import Image

    buffer = io.BytesIO()
    Image.fromarray(image).save(buffer, "WEBP", quality=_QUALITY, method=2)
    return buffer.getvalue()


def over_the_shoulder(robot: Pose) -> tuple[_Point, _Point]:
    """Returns where an observer behind a robot is, and where they look [m]: at where it works."""
    x, y, _ = robot.position
    eye = robot.apply(np.array([-0.9, -1.5, 1.7]))
    yaw = robot.yaw
    return (float(eye[0]), float(eye[1]), float(eye[2])), (x + 0.5 * math.cos(yaw), y + 0.5 * math.sin(yaw), 0.5)


def from_above(centre: _Point, distance: float) -> tuple[_Point, _Point]:
    """Returns where an observer is who looks down at a point from a distance, and that point [m]."""
    x, y, z = centre
    return (x - 0.46 * distance, y - 0.69 * distance, z + 0.56 * distance), centre


# ---------------------------------------------------------------------- contact sheet and animation


def check_pictures(path: Path, option: str) -> None:
    """Checks the file for pictures before anything starts.

    Args:
        path: The file.
        option: The option that names it.

    Raises:
        UsageError: It cannot be written, or is of an unknown kind.
    """
    if path.suffix not in (_SHEET, *_ANIMATIONS):
        raise UsageError(f"{option} {path}: use .png for a contact sheet, .gif or .webp for an animation")
    new = not path.exists()
    try:
        with path.open("ab"):
            pass
        if new:
            path.unlink()
    except OSError as error:
        raise UsageError(f"{option} {path} cannot be written: {error.strerror}") from error


@dataclass(frozen=True, slots=True)
class _Shot:
    time: float
    agent: str
    caption: str
    picture: Pending[Any]


class RunPictures:
    """Takes pictures of a run: for a contact sheet when something that took a while ends, for an animation regularly.

    Args:
        runtime: What runs modules on the cell, not yet running.
        camera: Takes a picture.
        path: The file to be written; its suffix says which of the two is wanted.
    """

    def __init__(self, runtime: Runtime, camera: Camera, path: Path) -> None:
        self._board = runtime.cycle.board
        self._camera = camera
        self._path = path
        self._shots: list[_Shot] = []
        self._next = 0.0
        self._doing = ""
        name = f"--record {path}"
        if path.suffix == _SHEET:
            self._leave = [_on_key_moments(runtime.monitor, contained(name, self._shoot))]
        else:
            cycle = runtime.cycle.observe(contained(name, self._on_cycle))
            self._leave = [cycle, runtime.monitor.subscribe(self._on_event)]

    def _on_event(self, event: ModuleEvent) -> None:
        if event.kind == "skill" and event.status is Status.STARTED:
            self._doing = f"{event.module} {event.target}"

    def _on_cycle(self) -> None:
        now = self._board.snapshot.time
        if now >= self._next:
            self._next = now + _EVERY
            self._shoot(self._doing, "")

    def _shoot(self, caption: str, agent: str) -> None:
        """Takes a picture; a skill and its last primitive, which end in one cycle, share one."""
        snapshot = self._board.snapshot
        last = self._shots[-1] if self._shots else None
        if last is not None and (last.time, last.agent) == (snapshot.time, agent):
            self._shots[-1] = replace(last, caption=f"{last.caption}, {caption}")
        else:
            self._shots.append(_Shot(snapshot.time, agent, caption, self._camera(snapshot, agent)))

    def write(self) -> None:
        """Takes no more pictures, and writes those it has.

        Raises:
            UsageError: The file cannot be written any more, or a picture could not be rendered.
        """
        for leave in self._leave:
            leave()
        try:
            pictures = [captioned(s.picture.result(), f"{s.time:.1f} s  {s.caption}") for s in self._shots]
            write_pictures(self._path, pictures, _SHOWN)
        except (OSError, SkirosError) as error:
            raise UsageError(f"--record {self._path} cannot be written: {error}") from error


def write_recorded_pictures(recording: Recording, path: Path) -> None:
    """Writes the pictures of a recording as a contact sheet or an animation.

    Raises:
        FileError: There are none in it, it is damaged, or the file cannot be written.
    """
    from PIL import Image

    try:
        pictures = [
            captioned(np.asarray(Image.open(io.BytesIO(one.data)).convert("RGB")), f"{one.time:.1f} s  {one.caption}")
            for one in recording.pictures()
        ]
    except OSError as error:
        raise FileError(recording.path, f"the recording is damaged: {error}") from error
    if not pictures:
        raise FileError(recording.path, "there are no pictures in it: they are taken of runs in physics")
    try:
        write_pictures(path, pictures, _SHOWN_MOMENT)
    except OSError as error:
        raise FileError(path, f"cannot be written: {error.strerror or error}") from error


def write_pictures(path: Path, pictures: Sequence[Image], shown: int) -> None:
    """Writes a contact sheet, or an animation that shows each picture for some time [ms], as the suffix says."""
    if path.suffix == _SHEET or not pictures:
        contact_sheet(pictures).save(path)
    else:
        pictures[0].save(path, save_all=True, append_images=pictures[1:], duration=shown, loop=0)


def captioned(picture: NDArray[Any], text: str) -> Image:
    """Returns a picture, RGB, with a text of at most three lines at its top."""
    from PIL import Image, ImageDraw

    image = Image.fromarray(picture)
    draw = ImageDraw.Draw(image)
    for number, line in enumerate(textwrap.wrap(text, _LETTERS, max_lines=_LINES)):
        top = _LINE * number
        draw.rectangle((0, top, 8 + draw.textlength(line), top + _LINE), fill=(0, 0, 0))
        draw.text((4, top + 2), line, fill=(255, 255, 255))
    return image


def contact_sheet(pictures: Sequence[Image]) -> Image:
    """Returns pictures of the size of this module in rows of four."""
    from PIL import Image

    rows = max(1, math.ceil(len(pictures) / _COLUMNS))
    sheet = Image.new("RGB", (_COLUMNS * WIDTH, rows * HEIGHT), (255, 255, 255))
    for index, picture in enumerate(pictures):
        sheet.paste(picture, ((index % _COLUMNS) * WIDTH, (index // _COLUMNS) * HEIGHT))
    return sheet
