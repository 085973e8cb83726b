"""``skiros data``: backups while a server runs, checks that find damage, and going on after a loss."""

from __future__ import annotations

import hashlib
import json
import shutil
import sqlite3
import subprocess
from contextlib import closing
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest
from support import warm_python
from support.server_process import ServerProcess

from skiros_py.errors import DeviceError

from .hard import LATER, STARTER, job_of, over


def skiros(*arguments: object) -> subprocess.CompletedProcess[str]:
    return warm_python.run([*warm_python.SKIROS, *map(str, arguments)], timeout=120)


def findings(data: Path) -> list[dict[str, str]]:
    ended = skiros("data", "check", "--data", data, "--json")
    found: list[dict[str, str]] = json.loads(ended.stdout)["findings"]
    assert ended.returncode == (1 if found else 0), ended.stderr
    return found


@pytest.fixture(scope="module")
def killed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The data directory of a server that did a job, took another and was killed."""
    data = tmp_path_factory.mktemp("killed") / "cell"
    with ServerProcess("kitting", "--fake", "--pace", "max", data=data) as server, server.client() as client:
        client.http.put("/jobs/kit", json=STARTER).raise_for_status()
        assert over(client.http, "kit")["outcome"] == "succeeded"
        body = {"url": "http://127.0.0.1:9/x"}
        assert client.http.post("/webhooks", json=body).status_code in (201, 403, 422)
        client.http.put("/jobs/last", json=STARTER | LATER).raise_for_status()
        client.http.get("/audit").raise_for_status()  # its records are written a moment later
        server.kill()
    return data


@pytest.fixture
def data(killed: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(killed, tmp_path / "cell", ignore=shutil.ignore_patterns("*-shm")))


def test_after_a_kill_every_file_is_whole(data: Path) -> None:
    assert findings(data) == []


def test_a_backup_of_a_running_server_is_a_data_directory(tmp_path: Path) -> None:
    data, back = tmp_path / "cell", tmp_path / "backups" / "monday"
    with ServerProcess("kitting", "--fake", data=data) as server, server.client() as client:
        client.http.put("/jobs/kept", json=STARTER | LATER).raise_for_status()
        ended = skiros("data", "backup", back, "--data", data, "--json")
        assert ended.returncode == 0, ended.stderr
        client.http.put("/jobs/later", json=STARTER | LATER).raise_for_status()
        assert findings(data) == []
        assert client.data.check().items == []
        remote = client.data.back_up("monday")
        again = client.http.post("/data/backups", json={"name": "monday"})
        assert (again.status_code, again.json()["code"]) == (409, "NotCopied")
        assert client.http.post("/data/backups", json={"name": "../x"}).status_code == 422
        (data / "halted.json").write_text("{ no such thing")
        assert [found.file for found in client.data.check().items] == ["halted.json"]
        (data / "halted.json").unlink()
        assert server.end() == 0
    assert remote.folder == str(data / "backups" / "monday")
    assert sorted(remote.files) == sorted(
        str(f.relative_to(remote.folder)) for f in Path(remote.folder).rglob("*") if f.is_file()
    )
    assert findings(Path(remote.folder)) == []
    assert not any("backups" in name for name in remote.files)
    assert {"journal.db", "jobs.db", "access.db", "webhooks.db"} <= set(json.loads(ended.stdout)["files"])
    assert not list(back.glob("*-wal"))
    assert {file.stat().st_mode & 0o77 for file in (back, *back.rglob("*"))} == {0}
    assert findings(back) == []
    with ServerProcess("--fake", data=back) as server, server.client() as client:
        assert "outcome" in job_of(client.http, "kept")
        assert client.http.get("/jobs/later").status_code == 404


def test_a_backup_is_not_made_over_something_nor_of_damaged_files(data: Path, tmp_path: Path) -> None:
    (tmp_path / "there").mkdir()
    assert "choose a new folder" in skiros("data", "backup", tmp_path / "there", "--data", data).stderr
    (data / "jobs.db-wal").unlink()
    ended = skiros("data", "backup", tmp_path / "new", "--data", data)
    assert ended.returncode == 2
    assert "nothing was copied" in ended.stderr
    assert not (tmp_path / "new").exists()


@pytest.mark.parametrize("name", ["journal.db", "jobs.db"])
def test_a_server_starts_without_lost_records_only_when_a_person_says_so(name: str, data: Path) -> None:
    log = data / f"{name}-wal"
    log.write_bytes(log.read_bytes()[:-1] if name == "journal.db" else b"")

    for _ in range(2):
        with pytest.raises(DeviceError) as refused:
            ServerProcess("--fake", data=data)
        assert f"{name}: ends before what was acknowledged: " in str(refused.value)
        assert f"skiros data accept-loss --data {data}" in str(refused.value)
        assert "Traceback" not in str(refused.value)
    (found,) = findings(data)
    assert found["file"] == name

    ended = skiros("data", "accept-loss", "--data", data, "--json")

    assert ended.returncode == 0
    (loss,) = json.loads(ended.stdout)["losses"]
    assert (loss["file"], loss["count"]) == (name, len(loss["missing"]))
    if name == "journal.db":
        assert len(loss["missing"]) == 1
    else:
        assert {"job kit, ordered", "job last, ordered"} <= {text[21:] for text in loss["missing"]}
    assert findings(data) == []
    with ServerProcess("--fake", data=data) as server, server.client() as client:
        for job in ("kit", "last"):
            assert client.http.get(f"/jobs/{job}").status_code == (404 if name == "jobs.db" else 200)


def break_text(path: Path) -> None:
    path.write_text("{ no such thing", encoding="utf-8")


def test_damage_of_any_file_is_found_and_named(data: Path) -> None:
    (recording,) = (data / "recordings").glob("*.mcap")
    recording.write_bytes(b"?" + recording.read_bytes()[1:])
    for name in ("learned.ttl", "halted.json"):
        break_text(data / name)
    with closing(sqlite3.connect(data / "jobs.db")) as connection:
        connection.execute("UPDATE jobs SET data = json_set(data, '$.state', 'flying') WHERE id = 'last'")
        connection.commit()
    with closing(sqlite3.connect(data / "journal.db")) as connection:
        connection.execute("UPDATE changes SET data = '{' WHERE number = 1")
        connection.commit()
    (data / "webhooks.db").unlink()
    (data / "server.db").write_bytes(b"x" * 8192)

    found = {one["file"] for one in findings(data)}

    assert found == {
        "journal.db", "jobs.db", "webhooks.db", "server.db", "learned.ttl", "halted.json",
        f"recordings/{recording.name}",
    }  # fmt: skip
    said = skiros("data", "check", "--data", data).stdout
    assert "id last of the table jobs cannot be understood" in said
    assert "1 rows of the table changes cannot be read" in said


def test_what_is_no_data_directory_is_refused(tmp_path: Path) -> None:
    for verb in ("check", "accept-loss", "audit"):
        ended = skiros("data", verb, "--data", tmp_path)
        assert (ended.returncode, ended.stdout) == (2, "")
    assert list(tmp_path.iterdir()) == []


def exported(data: Path) -> list[dict[str, Any]]:
    lines = skiros("data", "audit", "--data", data).stdout.splitlines()
    return [json.loads(line) for line in lines]


def test_the_exported_audit_log_can_be_verified_by_anybody(data: Path) -> None:
    lines = skiros("data", "audit", "--data", data).stdout.splitlines()

    assert len(lines) >= 2
    assert json.loads(lines[-1])["path"].endswith("/jobs/last")
    for line, following in pairwise(lines):
        assert json.loads(following)["previous"] == hashlib.sha256(line.encode()).hexdigest()


@pytest.mark.parametrize(
    ("sql", "broken"),
    [
        ("UPDATE audit SET data = replace(data, 'kit', 'kat') WHERE number = 1", "record 1 was changed"),
        ("UPDATE audit SET data = replace(data, 'last', 'lost') WHERE number = 3", "record 3 was changed"),
        ("DELETE FROM audit WHERE number = 2", "record 2 was removed"),
        ("DELETE FROM audit WHERE number = 1", "record 1 was removed"),
        ("DELETE FROM audit WHERE number = 3", "record 3 was removed"),
    ],
)
def test_a_changed_audit_record_is_found(sql: str, broken: str, data: Path) -> None:
    assert [entry["number"] for entry in exported(data)] == [1, 2, 3]
    with closing(sqlite3.connect(data / "access.db")) as connection:
        assert connection.execute(sql).rowcount == 1
        connection.commit()

    (found,) = findings(data)

    assert found["file"] == "access.db"
    assert broken in found["fault"]
