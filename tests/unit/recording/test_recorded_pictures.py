"""The pictures of a recording become a contact sheet or an animation."""

from __future__ import annotations

import base64
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image, ImageSequence

from skiros_py.errors import FileError
from skiros_py.execution.monitor import ModuleEvent, Status
from skiros_py.ports.values import Done, Snapshot
from skiros_py.recording import Recording, RecordingWriter, Schema, Topic
from skiros_py.recording.pictures import HEIGHT, OVERVIEW, WIDTH, RunPictures, webp, write_recorded_pictures
from skiros_py.testing import Bench, tiny_world

_PICTURES = Topic(OVERVIEW, Schema("any", {"type": "object"}))
_BRIGHTNESS = (60, 120, 180, 220, 250)


def recorded(path: Path, *pictures: bytes) -> Recording:
    writer = RecordingWriter(path)
    for number, data in enumerate(pictures):
        caption = {"caption": f"pick part_{number} done", "data": base64.b64encode(data).decode()}
        writer.put(_PICTURES, float(number), caption)
    writer.close()
    return Recording(path)


@pytest.fixture
def recording(tmp_path: Path) -> Iterator[Recording]:
    shots = (np.full((HEIGHT, WIDTH, 3), grey, np.uint8) for grey in _BRIGHTNESS)
    with recorded(tmp_path / "run.mcap", *map(webp, shots)) as recording:
        yield recording


def test_a_contact_sheet_has_every_key_moment_in_rows_of_four_with_its_caption(
    recording: Recording, tmp_path: Path
) -> None:
    write_recorded_pictures(recording, tmp_path / "sheet.png")
    sheet = np.asarray(Image.open(tmp_path / "sheet.png"), int)

    assert sheet.shape == (2 * HEIGHT, 4 * WIDTH, 3)
    middles = [sheet[row * HEIGHT + 200, column * WIDTH + 200, 0] for row in (0, 1) for column in range(4)]
    assert middles[:5] == pytest.approx(_BRIGHTNESS, abs=2)
    assert middles[5:] == [255, 255, 255]
    assert (sheet[HEIGHT + 2 : HEIGHT + 14, 4:100] > 250).any()  # white letters
    assert (sheet[HEIGHT + 1, :100] < 5).all()  # on black


@pytest.mark.parametrize("name", ["run.gif", "run.webp"])
def test_an_animation_shows_the_key_moments_one_after_the_other(
    recording: Recording, tmp_path: Path, name: str
) -> None:
    write_recorded_pictures(recording, tmp_path / name)

    with Image.open(tmp_path / name) as film:
        frames = ImageSequence.Iterator(film)
        shown = [np.asarray(frame.convert("RGB"), int)[200, 200, 0] for frame in frames]
    assert shown == pytest.approx(_BRIGHTNESS, abs=4)


def test_a_skill_and_its_last_primitive_share_a_picture(tmp_path: Path) -> None:
    taken = []

    def camera(_snapshot: Snapshot, agent: str) -> Done[NDArray[np.uint8]]:
        taken.append(agent)
        return Done(np.full((HEIGHT, WIDTH, 3), 99, np.uint8))

    with Bench(tiny_world()) as bench:
        pictures = RunPictures(bench.runtime, camera, tmp_path / "run.png")
        for kind, agent in (("primitive", "arm_1"), ("skill", "arm_1"), ("skill", "arm_2")):
            for time, status in ((0.0, Status.STARTED), (2.0, Status.TERMINATED)):
                bench.runtime.monitor.publish(ModuleEvent(time, kind, f"{kind}_1", status, 0, "", agent=agent))
        pictures.write()

    assert taken == ["arm_1", "arm_2"]


def test_without_pictures_or_with_damaged_ones_it_is_said_what_is_wrong(tmp_path: Path) -> None:
    with recorded(tmp_path / "none.mcap") as none, pytest.raises(FileError, match="runs in physics"):
        write_recorded_pictures(none, tmp_path / "run.png")
    with recorded(tmp_path / "bad.mcap", b"nothing") as bad, pytest.raises(FileError, match="damaged"):
        write_recorded_pictures(bad, tmp_path / "run.png")
    assert not (tmp_path / "run.png").exists()
