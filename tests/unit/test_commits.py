"""A database whose end was lost is not opened unless a person says so; real files are damaged."""

from __future__ import annotations

import os
import shutil
import signal
import sqlite3
import subprocess
import sys
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from skiros_py import commits
from skiros_py.commits import Loss, LostCommits
from skiros_py.database import COUNTED, Database, Schema
from skiros_py.database_file import accept_loss, back_up, find_loss
from skiros_py.errors import FileError

_SCHEMA = Schema("a list for tests", 0x74657374, ("CREATE TABLE things (name TEXT);", COUNTED))
_NUMBER = 12


def write(path: Path, *, many: int = _NUMBER, first: int = 1, durable: bool = False) -> None:
    """Writes some records in a process that is killed afterwards: they stay in the log."""
    code = f"""
import os, signal, sys
from pathlib import Path
from skiros_py.database import Database
sys.path.insert(0, {str(Path(__file__).parent)!r})
from test_commits import _SCHEMA
database = Database(Path({str(path)!r}), _SCHEMA, durable={durable})
for number in range({first}, {first + many}):
    with database.transaction(f"thing {{number}}") as connection:
        connection.execute("INSERT INTO things VALUES (?)", (f"thing {{number}}",))
os.kill(os.getpid(), signal.SIGKILL)
"""
    ended = subprocess.run([sys.executable, "-c", code], check=False, capture_output=True, text=True)
    assert ended.returncode == -signal.SIGKILL, ended.stderr


@pytest.fixture(scope="module")
def killed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder as a killed process leaves it."""
    folder = tmp_path_factory.mktemp("killed")
    write(folder / "things.db")
    return folder


@pytest.fixture
def path(killed: Path, tmp_path: Path) -> Path:
    """A copy of it."""
    return copied(killed, tmp_path / "data") / "things.db"


def copied(folder: Path, to: Path) -> Path:
    shutil.rmtree(to, ignore_errors=True)
    shutil.copytree(folder, to, ignore=shutil.ignore_patterns("*-shm"))
    return to


def things(path: Path) -> list[str]:
    with closing(Database(path, _SCHEMA)) as database:
        return [name for (name,) in database.rows("SELECT name FROM things ORDER BY rowid")]


def log_of(path: Path) -> Path:
    return path.with_name(f"{path.name}-wal")


def notes_of(path: Path) -> Path:
    return path.with_name(f"{path.name}{commits.ENDING}")


def refused(path: Path) -> Loss:
    """Checks that the file is not opened, and that nothing in the folder is changed by the attempt."""

    def content() -> dict[str, bytes]:
        read = {file.name: file.read_bytes() for file in path.parent.iterdir()}
        return {name: data for name, data in read.items() if data and not name.endswith("-shm")}

    before = content()
    for _ in range(2):
        with pytest.raises(LostCommits) as caught:
            things(path)
    assert content() == before
    assert f"skiros data accept-loss --data {path.parent}" in str(caught.value)
    return caught.value.loss


ALL = [f"thing {number}" for number in range(1, _NUMBER + 1)]


def test_after_a_plain_kill_everything_is_there_and_nothing_is_said(
    path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    assert things(path) == ALL
    assert things(path) == ALL
    assert not caplog.records


def test_a_kill_between_a_commit_and_its_note_loses_nothing(path: Path) -> None:
    notes = bytearray(notes_of(path).read_bytes())
    last = f"{_NUMBER} ".encode()
    at = next(at for at in range(256, len(notes), 256) if notes[at:].startswith(last))
    notes[at : at + 256] = bytes(256)
    notes_of(path).write_bytes(notes)

    assert things(path) == ALL


def flip(data: bytes, where: float) -> bytes:
    bit = int(where * 8 * len(data))
    changed = bytearray(data)
    changed[bit // 8] ^= 1 << bit % 8
    return bytes(changed)


DAMAGES: dict[str, Callable[[bytes, float], bytes | None]] = {
    "a flipped bit": flip,
    "cut off": lambda data, where: data[: int(where * len(data))],
    "garbage": lambda data, where: data[: int(where * len(data))] + os.urandom(len(data) - int(where * len(data))),
    "zeros": lambda data, where: data[: int(where * len(data))].ljust(len(data), b"\0"),
    "deleted": lambda _data, _where: None,
}


@settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    kind=st.sampled_from(sorted(DAMAGES)),
    where=st.floats(0, 1, exclude_max=True),
    of=st.sampled_from([log_of, notes_of]),
)
def test_no_damage_of_log_or_notes_loses_a_record_silently(
    kind: str, where: float, of: Callable[[Path], Path], killed: Path, tmp_path: Path
) -> None:
    path = copied(killed, tmp_path / "data") / "things.db"
    damaged = DAMAGES[kind](of(path).read_bytes(), where)
    of(path).unlink()
    if damaged is not None:
        of(path).write_bytes(damaged)

    loss = find_loss(path)
    if loss is None:
        assert things(path) == ALL
        return
    missing = [one.what for one in loss.commits]
    assert refused(path) == loss
    accept_loss(path)
    left = things(path)
    assert left == ALL[: len(left)]
    if of is notes_of:  # the records are there, but nobody knows that
        assert (kind, missing, left) == ("deleted", [], ALL)
        assert loss.unknown
    else:
        assert missing == ALL[len(left) :] != []


@pytest.mark.parametrize("left", [0, 1, 5, _NUMBER - 1])
def test_a_log_that_was_cut_off_is_noticed_with_the_lost_records(left: int, path: Path) -> None:
    with closing(sqlite3.connect(f"file:{path}?mode=ro", uri=True)) as connection:
        frames = len(log_of(path).read_bytes()) // 4120
        assert connection.execute("SELECT count(*) FROM things").fetchone() == (_NUMBER,)
    per_commit = frames // (_NUMBER + 1)
    os.truncate(log_of(path), log_of(path).stat().st_size - (_NUMBER - left) * per_commit * 4120)

    loss = refused(path)

    lost = [one.what for one in loss.commits]
    assert lost == ALL[_NUMBER - len(lost) :]
    assert loss.count == len(lost) > 0
    assert not loss.power_cut
    assert all(one in str(loss) for one in lost)


def test_what_was_given_up_is_said_once_and_new_records_follow(path: Path) -> None:
    damaged = flip(log_of(path).read_bytes(), 0.999)
    log_of(path).write_bytes(damaged)
    refused(path)

    loss = accept_loss(path)

    assert loss is not None
    assert [one.what for one in loss.commits] == ALL[-1:]
    assert path.with_name("things.db-wal.kept").read_bytes() == damaged
    assert things(path) == ALL[:-1]
    assert accept_loss(path) is None
    write(path, many=2, first=50)
    assert things(path) == [*ALL[:-1], "thing 50", "thing 51"]


def test_more_lost_records_than_are_noted_are_counted(tmp_path: Path) -> None:
    path = tmp_path / "things.db"
    write(path, many=700)
    log_of(path).unlink()

    loss = refused(path)

    assert loss.count == 700
    assert loss.commits[-1].what == "thing 700"
    assert f"{700 - len(loss.commits)} earlier ones" in str(loss)


def test_an_old_copy_put_in_the_place_of_the_file_is_noticed(path: Path, tmp_path: Path) -> None:
    back = tmp_path / "backup"
    back.mkdir()
    back_up([path], back)
    write(path, many=3, first=100)
    things(path)  # the log is worked into the file
    assert not log_of(path).exists()
    shutil.copy(back / path.name, path)

    assert [one.what for one in refused(path).commits] == ["thing 100", "thing 101", "thing 102"]


def test_an_old_copy_beside_the_log_of_a_later_file_is_refused(path: Path, tmp_path: Path) -> None:
    back = tmp_path / "backup"
    back.mkdir()
    back_up([path], back)
    write(path, many=3, first=100)
    things(path)
    write(path, many=3, first=200)
    shutil.copy(back / path.name, path)

    with pytest.raises(FileError, match=r"older than its log things\.db-wal"):
        things(path)
    log_of(path).unlink()
    assert len(refused(path).commits) == 6


def test_a_backup_is_complete_by_itself_while_the_file_is_written(tmp_path: Path) -> None:
    back = tmp_path / "backup"
    back.mkdir()
    with closing(Database(tmp_path / "things.db", _SCHEMA)) as database:
        for number in range(1, 6):
            with database.transaction(f"thing {number}") as connection:
                connection.execute("INSERT INTO things VALUES (?)", (f"thing {number}",))
        back_up([database.path], back)
        with database.transaction("later") as connection:
            connection.execute("INSERT INTO things VALUES ('later')")

    assert sorted(file.name for file in back.iterdir()) == ["things.db", "things.db-commits"]
    assert {file.stat().st_mode & 0o777 for file in back.iterdir()} == {0o600}
    assert things(back / "things.db") == ALL[:5]


def test_a_missing_file_beside_its_notes_is_not_made_anew(path: Path) -> None:
    path.unlink()
    log_of(path).unlink()

    with pytest.raises(FileError, match=r"the file is missing, but things\.db-commits exists"):
        things(path)


# ---------------------------------------------------------------- power cuts


def restarted(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Lets the machine look as if it had been started again."""
    other = tmp_path / "boot_id"
    other.write_text("another start", encoding="ascii")
    monkeypatch.setattr(commits, "_BOOT", other)


def without_syncs(path: Path) -> None:
    """Takes from the notes that anything was on the disk: as if the power had failed at once."""
    content = bytearray(notes_of(path).read_bytes())
    head = commits.read(path)
    assert head is not None
    assert head[0] is not None
    content[:256] = commits._encoded(commits.Commit(0, head[0].wall, head[0].what))
    notes_of(path).write_bytes(content)


def test_after_a_power_cut_it_goes_on_and_says_what_may_be_missing(
    path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    without_syncs(path)
    log_of(path).write_bytes(log_of(path).read_bytes()[:-1])
    restarted(monkeypatch, tmp_path)

    assert things(path) == ALL[:-1]

    said = [record.getMessage() for record in caplog.records]
    assert "thing 12" in said[1]
    assert said[2:] == ["things.db: the machine went down before they were on the disk"]
    caplog.clear()
    assert things(path) == ALL[:-1]
    assert not caplog.records


def test_a_power_cut_does_not_excuse_the_loss_of_synced_records(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "things.db"
    write(path, durable=True)
    log_of(path).write_bytes(log_of(path).read_bytes()[:-1])
    restarted(monkeypatch, tmp_path)

    assert [one.what for one in refused(path).commits] == ALL[-1:]


def test_what_was_read_after_a_restart_is_not_lost_to_the_power_cut_before(
    path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    without_syncs(path)
    restarted(monkeypatch, tmp_path)
    assert things(path) == ALL
    write(path, many=1, first=50)  # in the real start of the machine, which is another one again
    monkeypatch.undo()
    log_of(path).unlink()

    assert [one.what for one in refused(path).commits] == ["thing 50"]


def test_a_file_in_use_is_looked_at_without_disturbing_it(tmp_path: Path) -> None:
    with closing(Database(tmp_path / "things.db", _SCHEMA)) as database:
        for number in range(200):
            with database.transaction(f"thing {number}") as connection:
                connection.execute("INSERT INTO things VALUES ('x')")
            assert find_loss(database.path, _SCHEMA.check) is None
        assert database.rows("SELECT count(*) FROM things") == [(200,)]


def test_a_kill_in_the_first_start_does_not_keep_the_next_one_from_starting(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    replace = Path.replace

    def killed_before_the_last(file: Path, to: Path) -> Path:
        if file.name == "things.db.new":
            raise KeyboardInterrupt
        return replace(file, to)

    with monkeypatch.context() as patched:
        patched.setattr(Path, "replace", killed_before_the_last)
        with pytest.raises(KeyboardInterrupt):
            Database(tmp_path / "things.db", _SCHEMA)

    Database(tmp_path / "things.db", _SCHEMA).close()


@pytest.mark.parametrize("cut", [None, 0.1, 0.5, 0.9], ids=["no checkpoint", "begun", "half", "nearly done"])
def test_a_kill_after_unused_space_was_freed_is_no_loss(tmp_path: Path, cut: float | None) -> None:
    schema = Schema(
        "a list for tests", 0x74657374, ("CREATE TABLE other (x); CREATE TABLE things (name TEXT);", COUNTED)
    )
    path, killed = tmp_path / "things.db", tmp_path / "killed"
    with closing(Database(path, schema, durable=True)) as database:
        for number in range(200):
            with database.transaction("a thing") as connection:
                connection.execute("INSERT INTO things VALUES (?)", (f"{number} {'x' * 300}",))
        with database.transaction("fewer things") as connection:
            connection.execute("DELETE FROM things WHERE rowid % 2")
    with closing(Database(path, schema, durable=True)) as database:
        with database.transaction("one less") as connection:
            connection.execute("DELETE FROM things WHERE rowid = 2")
        database._connection.execute("VACUUM")  # type: ignore[union-attr]
        before = path.read_bytes()
        killed.mkdir()
        for file in tmp_path.glob("things.db*"):
            shutil.copy(file, killed / file.name)
    if cut is not None:
        after = path.read_bytes()
        written = 4096 * round(cut * len(after) / 4096)
        (killed / "things.db").write_bytes(after[:written] + before[written:])

    with closing(Database(killed / "things.db", schema)) as database:
        assert database.rows("SELECT count(*) FROM things") == [(99,)]


def test_a_note_of_many_writes_says_how_many_it_does_not_name() -> None:
    few = commits.listed(["job a, ordered", "", "job b, ordered"])
    many = commits.listed([f"job {number:040}, ordered" for number in range(16)])

    assert few == "job a, ordered, job b, ordered"
    assert many.startswith("16 writes: job 0")
    assert many.endswith("more")
    assert len(many) < 250
