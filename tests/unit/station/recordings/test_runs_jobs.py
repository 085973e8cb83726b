"""The folder with the recordings of jobs stays small."""

from __future__ import annotations

from pathlib import Path

import pytest

from skiros_py.recording import RecordingWriter
from skiros_py.station.recordings.runs import JobRecordings
from skiros_py.tasks.jobs.manager import JobManager


def no_jobs() -> JobManager:
    raise AssertionError("no job is asked for")


def filled(recordings: JobRecordings, count: int) -> JobRecordings:
    recordings._file(1).parent.mkdir()
    for number in range(1, count + 1):
        recordings._file(number).write_bytes(bytes(100))
    return recordings


def kept(folder: Path) -> list[int]:
    return sorted(int(file.stem) for file in folder.iterdir())


@pytest.mark.parametrize("limits", [{"most": 4}, {"room": 350}])
def test_the_oldest_recordings_are_deleted_beyond_the_limits_of_number_and_size(
    tmp_path: Path, limits: dict[str, int]
) -> None:
    filled(JobRecordings(tmp_path / "recordings", no_jobs, **limits), 12)._make_room()
    assert kept(tmp_path / "recordings") == [10, 11, 12]


def test_a_recording_in_progress_is_not_deleted(tmp_path: Path) -> None:
    recordings = filled(JobRecordings(tmp_path / "recordings", no_jobs, most=3), 5)
    recordings._file(1).unlink()
    writer = recordings._writers[1] = RecordingWriter(recordings._file(1))
    recordings._make_room()
    assert kept(tmp_path / "recordings") == [1, 5]
    writer.end(discard=True)
    recordings.close()
    assert kept(tmp_path / "recordings") == [5]


def test_deleting_a_missing_recording_has_no_effect(tmp_path: Path) -> None:
    recordings = JobRecordings(tmp_path / "recordings", no_jobs)
    recordings._delete(recordings._file(7))
    assert not (tmp_path / "recordings").exists()
