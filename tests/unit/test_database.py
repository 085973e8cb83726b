"""One SQLite file, and those who use it at the same time."""

import sqlite3
import threading
import time
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest

from skiros_py.database import COUNTED, Database, Schema
from skiros_py.errors import DiskFault, WorldError

_SCHEMA = Schema("a list for tests", 0x74657374, ("CREATE TABLE things (name TEXT);", COUNTED))


@pytest.fixture
def database(tmp_path: Path) -> Iterator[Database]:
    made = Database(tmp_path / "things.db", _SCHEMA, lookups=True)
    yield made
    made.close()


def _add(database: Database, name: str) -> None:
    with database.transaction() as connection:
        connection.execute("INSERT INTO things VALUES (?)", (name,))


def test_a_reader_sees_only_committed_data(database: Database) -> None:
    _add(database, "first")
    with database.transaction() as connection:
        connection.execute("INSERT INTO things VALUES ('second')")
        assert database.looked_up("SELECT name FROM things") == [("first",)]
    assert database.looked_up("SELECT name FROM things") == [("first",), ("second",)]


def test_a_reader_cannot_write(database: Database) -> None:
    with pytest.raises(Exception, match="the file cannot be written"):
        database.looked_up("INSERT INTO things VALUES ('x')")


def test_a_long_read_does_not_block_writers(database: Database) -> None:
    for number in range(300):
        _add(database, str(number))
    looking = threading.Thread(
        target=database.looked_up, args=("SELECT count(*) FROM things a, things b, things c WHERE a.name < b.name",)
    )
    looking.start()
    _add(database, "meanwhile")
    meanwhile = looking.is_alive()
    looking.join()
    assert meanwhile


def test_the_log_is_worked_into_the_file_while_it_is_open(database: Database) -> None:
    before = database.path.stat().st_size
    for _ in range(200):
        _add(database, "x" * 100_000)
    deadline = time.monotonic() + 20.0
    while database.path.stat().st_size < before + 200 * 100_000:
        assert time.monotonic() < deadline, "it stays in the log"
        time.sleep(0.05)
    assert len(database.rows("SELECT name FROM things")) == 200


def test_what_is_committed_is_there_for_who_opens_the_file_after_a_crash(database: Database, tmp_path: Path) -> None:
    _add(database, "kept")
    copy = tmp_path / "copy.db"
    for ending in ("", "-wal"):
        (tmp_path / f"copy.db{ending}").write_bytes((tmp_path / f"things.db{ending}").read_bytes())
    connection = sqlite3.connect(copy)
    assert connection.execute("SELECT name FROM things").fetchall() == [("kept",)]
    connection.close()


def test_what_is_closed_is_neither_read_nor_written(database: Database) -> None:
    database.close()
    database.close()
    with pytest.raises(WorldError, match="closed"):
        _add(database, "late")
    with pytest.raises(WorldError, match="closed"):
        database.looked_up("SELECT name FROM things")


def test_a_part_of_a_transaction_that_raises_is_taken_back_alone(database: Database) -> None:
    def fail() -> None:
        with database.transaction("part") as connection:
            connection.execute("INSERT INTO things VALUES ('second')")
            raise ValueError("no")

    with database.transaction("outer"):
        _add(database, "first")
        with pytest.raises(ValueError, match="no"):
            fail()
        _add(database, "third")

    assert database.rows("SELECT name FROM things") == [("first",), ("third",)]


def test_a_sync_after_a_failed_one_does_not_succeed_while_a_reader_holds_the_log(tmp_path: Path) -> None:
    with closing(Database(tmp_path / "things.db", _SCHEMA)) as database:
        _add(database, "first")
        database._unsafe = True  # as a failed fsync leaves it
        with closing(sqlite3.connect(tmp_path / "things.db", isolation_level=None)) as reader:
            reader.execute("BEGIN")
            reader.execute("SELECT * FROM things").fetchall()
            _add(database, "second")
            with pytest.raises(DiskFault):
                database.sync()
        database.sync()
        assert database.fault is None
