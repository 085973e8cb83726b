"""A data directory and its files can be used by their owner only, from the first byte."""

from __future__ import annotations

import logging
import os
import sqlite3
from collections.abc import Iterator
from pathlib import Path

import pytest

from skiros_py.database import Database
from skiros_py.testing import tiny_ontology
from skiros_py.world.journal.data_directory import DataDirectory, make_folder
from skiros_py.world.journal.records import SCHEMA


@pytest.fixture(autouse=True)
def _generous() -> Iterator[None]:
    """Runs the tests under a umask that allows everything."""
    before = os.umask(0)
    yield
    os.umask(before)


def readable(folder: Path) -> list[str]:
    """Returns the names of what other users may use."""
    return sorted(file.name for file in (folder, *folder.rglob("*")) if file.stat().st_mode & 0o077)


def test_a_new_data_directory_is_private_with_its_log_and_learned_file(tmp_path: Path) -> None:
    data = tmp_path / "new" / "cell"
    with DataDirectory.open(data, tiny_ontology()) as opened:
        with opened.world.transaction("test", "teaches") as tx:
            tx.add("tiny:Ball", "grey ball", properties={"sk:mass": 0.25}, learned=True)
        assert {"journal.db", "journal.db-wal", "learned.ttl", "lock"} <= {file.name for file in data.iterdir()}
        assert readable(data) == []


def test_a_database_is_private_before_anything_is_written_to_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    modes: list[int] = []
    connect = sqlite3.connect

    def look(path: str | Path, **options: object) -> sqlite3.Connection:
        modes.extend(one.stat().st_mode & 0o777 for one in tmp_path.iterdir())
        return connect(path, **options)  # type: ignore[call-overload,no-any-return]

    monkeypatch.setattr(sqlite3, "connect", look)
    Database(tmp_path / "journal.db", SCHEMA).close()

    assert len(modes) > 5
    assert set(modes) == {0o600}


def test_the_permissions_of_an_old_data_directory_are_taken_from_others(tmp_path: Path) -> None:
    data = tmp_path / "cell"
    DataDirectory.open(data, tiny_ontology()).close()
    (data / "recordings").mkdir(0o755)
    for file in (data, *data.rglob("*")):
        file.chmod(0o777 if file.is_dir() else 0o644)

    with DataDirectory.open(data, tiny_ontology()):
        assert readable(data) == []


def test_a_folder_with_other_files_keeps_its_permissions_and_that_is_said(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    (tmp_path / "program.sh").touch(0o755)
    tmp_path.chmod(0o755)
    with caplog.at_level(logging.WARNING):
        make_folder(tmp_path)

    assert readable(tmp_path) == sorted([tmp_path.name, "program.sh"])
    assert "others may look in" in caplog.text


def test_copies_of_an_edited_learned_file_are_bounded_and_the_oldest_go(tmp_path: Path) -> None:
    with DataDirectory.open(tmp_path, tiny_ontology()) as opened, opened.world.transaction("test", "teaches") as tx:
        tx.add("tiny:Ball", "grey ball", properties={"sk:mass": 0.25}, learned=True)
    for number in range(13):
        (tmp_path / "learned.ttl").write_text(f"# edited {number}\n", encoding="utf-8")
        DataDirectory.open(tmp_path, tiny_ontology()).close()

    kept = {file.name: file.read_text(encoding="utf-8") for file in tmp_path.glob("learned.ttl.kept-*")}
    assert kept == {f"learned.ttl.kept-{number + 1}": f"# edited {number}\n" for number in range(3, 13)}
