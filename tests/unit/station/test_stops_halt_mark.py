"""A stop that outlives the server."""

from __future__ import annotations

import time
from pathlib import Path

import pytest

from skiros_py.station.stops import Halt, HaltMark

HALT = Halt("a person is in the cell", "anna", 1_700_000_000.5)


def settled(mark: HaltMark) -> None:
    mark._settle()


def test_a_stored_halt_is_read_after_a_restart(tmp_path: Path) -> None:
    mark = HaltMark(tmp_path / "halted.json")
    mark.keep(HALT)
    settled(mark)
    assert HaltMark(tmp_path / "halted.json").read() == HALT


def test_a_reset_deletes_a_halt_mark_that_is_still_being_written(tmp_path: Path) -> None:
    mark = HaltMark(tmp_path / "halted.json")
    for _ in range(20):
        mark.keep(HALT)
        mark.forget()
    settled(mark)
    assert HaltMark(tmp_path / "halted.json").read() is None
    assert list(tmp_path.iterdir()) == []


def test_a_damaged_halt_mark_counts_as_a_stop(tmp_path: Path) -> None:
    (tmp_path / "halted.json").write_text("{")
    read = HaltMark(tmp_path / "halted.json").read()
    assert read is not None
    assert "everything was stopped" in read.why


def test_a_reset_deletes_a_halt_mark_read_from_the_disk(tmp_path: Path) -> None:
    first = HaltMark(tmp_path / "halted.json")
    first.keep(HALT)
    settled(first)
    second = HaltMark(tmp_path / "halted.json")
    second.read()
    second.forget()
    assert HaltMark(tmp_path / "halted.json").read() is None


def test_a_stop_that_cannot_be_stored_is_stored_when_the_disk_takes_it_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("skiros_py.station.stops._AGAIN", 0.01)
    mark = HaltMark(tmp_path / "later" / "halted.json")
    mark.keep(HALT)
    time.sleep(0.05)

    (tmp_path / "later").mkdir()

    deadline = time.monotonic() + 10.0
    while HaltMark(tmp_path / "later" / "halted.json").read() is None and time.monotonic() < deadline:
        time.sleep(0.01)
    assert HaltMark(tmp_path / "later" / "halted.json").read() == HALT


def test_a_stop_that_cannot_be_stored_still_takes_effect(tmp_path: Path) -> None:
    mark = HaltMark(tmp_path / "nowhere" / "halted.json")
    mark.keep(HALT)
    settled(mark)
    assert not (tmp_path / "nowhere").exists()
    mark.forget()
