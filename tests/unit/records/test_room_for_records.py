"""A record is bounded, outlives its process, and is never worth a run."""

from __future__ import annotations

import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from skiros_py.devices.arm import ArmState
from skiros_py.errors import FileError, UsageError
from skiros_py.ports.pending import Done
from skiros_py.ports.values import Snapshot
from skiros_py.records import Record, RecordWriter, find_record
from skiros_py.records.frames import Layout

_LIMIT = 1024 * 1024
_STATE = Snapshot(0, 0.0, {"arm": ArmState((0.0,) * 7, (0.0,) * 7, still=True)})


def _fill(writer: RecordWriter, seconds: int, seed: int = 0) -> None:
    """Writes so many seconds of a run that does not compress."""
    random = np.random.default_rng(seed)
    writer.put_meta("layout", Layout.of(_STATE).as_json())
    for second in range(seconds):
        times = second + np.arange(20) * 0.05
        writer.put_frames(times.tolist(), random.uniform(-3.0, 3.0, (20, 7)).tolist())
        if second % 10 == 0:
            writer.put_picture(second, f"at {second}", Done(random.integers(0, 255, (60, 80, 3), dtype=np.uint8)))


def test_a_record_never_outgrows_its_limit_and_says_what_it_left_out(tmp_path: Path) -> None:
    path = tmp_path / "long.record"
    writer = RecordWriter(path, limit=_LIMIT)
    _fill(writer, 5000)
    writer.close()

    assert path.stat().st_size <= _LIMIT
    assert list(tmp_path.iterdir()) == [path]
    with Record(path) as record:
        times = [frame.time for frame in record.frames()]
        assert record.forgotten["snapshots"] > 10_000
        assert times[-1] == pytest.approx(4999.95)
        assert np.allclose(np.diff(times[-100:]), 0.05), "what is latest is whole"
        assert times == sorted(times)
        assert min(times) < 2500.0, "of what is old, key snapshots are left"


def test_what_was_written_is_there_after_the_process_was_killed(tmp_path: Path) -> None:
    path = tmp_path / "killed.record"
    program = f"""
import time
from pathlib import Path
from skiros_py.records import RecordWriter
writer = RecordWriter(Path({str(path)!r}))
writer.put_meta("scene", "kitting")
writer.put_event(1.0, {{"module": "pick"}})
deadline = time.monotonic() + 20.0
while time.monotonic() < deadline and not writer._database.rows("SELECT 1 FROM events"):
    time.sleep(0.01)
print("written", flush=True)
time.sleep(60.0)
"""
    with subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "written\n"
        with Record(path) as live:
            seen_live = live.events, live.complete
        process.send_signal(signal.SIGKILL)
    with Record(path) as left:
        assert (left.events, left.complete) == seen_live == (({"time": 1.0, "module": "pick"},), False)


def test_a_disk_that_fails_ends_the_record_and_nothing_else(tmp_path: Path) -> None:
    writer = RecordWriter(tmp_path / "one.record")
    writer._database.rows("PRAGMA max_page_count = 5")  # as on a disk without room
    _fill(writer, 200)
    writer.close()

    assert "no room left" in writer.fault
    writer.put_event(1.0, {})  # is taken, and goes nowhere


def test_a_limit_without_sense_is_refused(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="room for at least"):
        RecordWriter(tmp_path / "one.record", limit=1000)


def test_a_missing_record_is_named(tmp_path: Path) -> None:
    with pytest.raises(FileError, match="there is no such record"):
        Record(tmp_path / "none.record")
    with pytest.raises(FileError, match="no record of a run in it: 'skiros run SCENE --data DIR'"):
        find_record(tmp_path)


@pytest.mark.parametrize("content", [b"", b"hello", b"SQLite format 3\0" + b"x" * 4096])
def test_what_is_no_record_is_refused(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "odd.record"
    path.write_bytes(content)

    with pytest.raises(FileError, match=r"damaged, or no record of a run|another program"):
        Record(path)


def test_a_damaged_record_is_refused_where_the_damage_is(tmp_path: Path) -> None:
    path = tmp_path / "one.record"
    writer = RecordWriter(path)
    _fill(writer, 30)
    writer._put(lambda db: db.execute("UPDATE frames SET data = x'0800ffff' WHERE id = 7"))
    writer.close()

    with Record(path) as record, pytest.raises(FileError, match="damaged"):
        list(record.frames())


def test_the_latest_record_of_a_data_directory_is_found(tmp_path: Path) -> None:
    runs = tmp_path / "runs"
    runs.mkdir()
    names = ("2026-01-02_030405_kitting", "2026-01-02_030405_kitting-2", "2025-12-31_235959_kitting")
    for name in names:
        (runs / f"{name}.record").touch()

    assert find_record(tmp_path) == find_record(runs) == runs / f"{names[1]}.record"
    assert find_record(runs / f"{names[0]}.record") == runs / f"{names[0]}.record"
