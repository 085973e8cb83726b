"""A run in physics leaves a recording with pictures, and is the same run with and without one."""

from __future__ import annotations

import io
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from skiros_py.recording import Recording, find_recording
from skiros_py.station.recordings.runs import run_recorder
from skiros_py.station.session import Session


@pytest.mark.physics
def test_a_recorded_drive_has_pictures_and_the_path_and_the_same_digest(
    open_session: Callable[..., Session], tmp_path: Path
) -> None:
    goal = "RobotAtLocation(robot_1, pallet_b)"
    plain = open_session(goal=goal).run()
    session = open_session(goal=goal)
    with run_recorder(session, tmp_path) as recorder:
        report = session.run()
        recorder.conclude(report)

    with Recording(find_recording(tmp_path)) as record:
        bases = [frame.devices["base_1"]["pose"]["position"] for frame in record.frames()]
        pictures = list(record.pictures())
        digest = record.meta["digest"]
    assert report.digest == plain.digest == digest
    assert np.hypot(*np.subtract(bases[-1][:2], bases[0][:2])) > 1.0
    assert max(np.hypot(*np.subtract(a[:2], b[:2])) for a, b in pairwise(bases)) < 0.1
    assert [picture.caption for picture in pictures][-1].endswith("drive pallet_b done")
    assert Image.open(io.BytesIO(pictures[-1].data)).size == (480, 360)
