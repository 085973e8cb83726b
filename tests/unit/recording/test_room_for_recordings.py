"""A recording is bounded, outlives its process, and never disturbs a run."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from mcap.exceptions import McapError
from mcap.reader import make_reader

from skiros_py.errors import FileError, UsageError
from skiros_py.ports.values import Done
from skiros_py.recording import Recording, RecordingWriter, Schema, Topic, find_recording
from skiros_py.recording.writer import export

_LIMIT = 1024 * 1024
_ANY = Schema("any", {"type": "object"})
_ARM = Topic("/devices/arm", _ANY, every=1.0)
_RUNS = Topic("/runs", _ANY)
_PICTURE = Topic("/camera/overview", _ANY, lambda _time, image: {"data": image.tobytes().hex()}, every=1.0)


def _fill(writer: RecordingWriter, seconds: int, seed: int = 0) -> None:
    """Writes so many seconds of a run that hardly compresses."""
    random = np.random.default_rng(seed)
    for second in range(seconds):
        for at in second + np.arange(20) * 0.05:
            writer.put(_ARM, float(at), {"positions": random.uniform(-3.0, 3.0, 7).tolist()})
        if second % 10 == 0:
            image = random.integers(0, 255, (60, 80), dtype=np.uint8)
            writer.put_pending(_PICTURE, second, Done(image))
            writer.put(_RUNS, second, {"kind": "skill", "module": "pick"})
        while writer._queue.qsize() > 1000:
            time.sleep(0.001)


def test_a_recording_never_exceeds_its_limit_and_lists_what_was_left_out(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("skiros_py.recording.writer._FLUSH", 0.02)
    path = tmp_path / "long.mcap"
    writer = RecordingWriter(path, limit=_LIMIT)
    _fill(writer, 1000)
    writer.close()

    assert writer.fault == ""
    assert path.stat().st_size <= _LIMIT
    assert list(tmp_path.iterdir()) == [path]
    with Recording(path) as recording:
        times = [frame.time for frame in recording.frames()]
        events = recording.events
        left_out = recording.left_out
    assert left_out["/devices/arm"] > 5_000
    assert times[-1] == pytest.approx(999.95)
    assert np.allclose(np.diff(times[-100:]), 0.05), "what is latest is whole"
    assert times == sorted(times)
    assert min(times) < 500.0, "of what is old, key states are left"
    assert len(events) + left_out.get("/runs", 0) == 100


def test_written_data_is_kept_when_the_process_is_killed(tmp_path: Path) -> None:
    path = tmp_path / "killed.mcap"
    program = f"""
import time
from pathlib import Path
from skiros_py.recording import RecordingWriter, Schema, Topic
writer = RecordingWriter(Path({str(path)!r}))
writer.put_metadata("run", {{"scene": "kitting"}})
writer.attach("scene.ttl", "text/turtle", b"a b c .")
runs = Topic("/runs", Schema("run", {{"type": "object"}}))
for number in range(100):
    writer.put(runs, float(number), {{"kind": "skill", "module": "pick"}})
    time.sleep(0.03)
print("written", flush=True)
time.sleep(60.0)
"""
    with subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "written\n"
        with Recording(path) as live:
            seen_live = live.events, live.complete
        process.send_signal(signal.SIGKILL)
    with path.open("rb") as file, pytest.raises(McapError):
        make_reader(file).get_summary()  # there is no index
    with Recording(path) as left:
        assert len(left.events) >= 40
        assert (left.events, left.complete) == seen_live
        assert left.meta == {"scene": "kitting"}
        assert [one.data for one in left.attachments()] == [b"a b c ."]
        export(left, tmp_path / "whole.mcap")
    with (tmp_path / "whole.mcap").open("rb") as file:
        whole = [json.loads(message.data) for _, _, message in make_reader(file, validate_crcs=True).iter_messages()]
    assert whole == list(seen_live[0])


@pytest.mark.parametrize("cut", [1, 20, 100, 1000])
def test_a_truncated_file_is_read_up_to_the_cut(tmp_path: Path, cut: int) -> None:
    path = tmp_path / "one.mcap"
    writer = RecordingWriter(path)
    for number in range(50):
        writer.put(_RUNS, number, {"kind": "skill", "number": number})
        writer.defer(lambda _write: writer._file.flush())
    writer.close()
    path.write_bytes(path.read_bytes()[:-cut])

    with Recording(path) as recording:
        numbers = [event["number"] for event in recording.events]
    assert numbers == list(range(len(numbers)))


def test_messages_are_found_by_time_without_reading_the_others(tmp_path: Path) -> None:
    path = tmp_path / "one.mcap"
    writer = RecordingWriter(path)
    for number in range(100):
        writer.put(_RUNS, number, {"kind": "skill", "number": number})
        if number % 10 == 9:
            writer.defer(lambda _write: writer._file.flush())
    writer.close()

    with Recording(path) as recording:
        chunks = len(recording._reader.chunks)
        found = [(time, one["number"]) for _, time, one in recording.messages("/runs", start=42.0, end=44.0)]
    assert found == [(42.0, 42), (43.0, 43), (44.0, 44)]
    assert chunks == 10


def test_a_failing_disk_ends_only_the_recording(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("skiros_py.recording.writer._McapFile.flush", full)
    writer = RecordingWriter(tmp_path / "one.mcap")
    _fill(writer, 10)
    writer.close()

    assert "No space left" in writer.fault
    writer.put(_RUNS, 1.0, {})  # is taken, and goes nowhere


def test_an_encoder_that_raises_ends_only_its_topic(tmp_path: Path) -> None:
    path = tmp_path / "one.mcap"
    writer = RecordingWriter(path)
    broken = Topic("/temperature", _ANY, lambda _time, value: {"celsius": 1.0 / value})
    for value in (1.0, 0.0, 2.0):
        writer.put(broken, value, value)
        writer.put(_RUNS, value, {"kind": "skill", "module": "pick"})
    writer.close()

    with Recording(path) as recording:
        assert recording.topics == {"/temperature": 1, "/runs": 3}
        assert [record.metadata for record in recording.metadata() if record.name == "switched off"] == [
            {"/temperature": '"ZeroDivisionError: float division by zero"'}
        ]


def test_an_invalid_limit_is_refused(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="room for at least"):
        RecordingWriter(tmp_path / "one.mcap", limit=1000)


def test_a_missing_recording_is_named(tmp_path: Path) -> None:
    with pytest.raises(FileError, match="there is no such recording"):
        Recording(tmp_path / "none.mcap")
    with pytest.raises(FileError, match="no recording of a run in it: 'skiros run SCENE --data DIR'"):
        find_recording(tmp_path)


@pytest.mark.parametrize("content", [b"", b"hello", b"SQLite format 3\0" + b"x" * 4096])
def test_a_file_that_is_no_recording_is_refused(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "odd.mcap"
    path.write_bytes(content)

    with pytest.raises(FileError, match="damaged, or no recording of a run"):
        Recording(path)


def test_a_damaged_recording_is_refused_with_the_place_of_the_damage(tmp_path: Path) -> None:
    path = tmp_path / "one.mcap"
    writer = RecordingWriter(path)
    _fill(writer, 30)
    writer.close()
    data = bytearray(path.read_bytes())
    data[len(data) // 3] ^= 255
    path.write_bytes(data)

    with Recording(path) as recording, pytest.raises(FileError, match="damaged"):
        list(recording.frames())


def test_the_latest_recording_of_a_data_directory_is_found(tmp_path: Path) -> None:
    runs = tmp_path / "runs"
    runs.mkdir()
    names = ("2026-01-02_030405_kitting", "2026-01-02_030405_kitting-2", "2025-12-31_235959_kitting")
    for name in names:
        (runs / f"{name}.mcap").touch()

    assert find_recording(tmp_path) == find_recording(runs) == runs / f"{names[1]}.mcap"
    assert find_recording(runs / f"{names[0]}.mcap") == runs / f"{names[0]}.mcap"


def test_the_recording_of_the_latest_job_of_a_server_is_found(tmp_path: Path) -> None:
    jobs = tmp_path / "recordings"
    jobs.mkdir()
    for name in ("000000009", "000000010"):
        (jobs / f"{name}.mcap").touch()

    assert find_recording(tmp_path) == jobs / "000000010.mcap"
