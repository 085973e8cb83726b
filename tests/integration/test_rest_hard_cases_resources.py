"""Case 20: nothing leaks, old files are read, and a server ends in good order whatever it does."""

from __future__ import annotations

import json
import signal
import sqlite3
import threading
from collections.abc import Iterator
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from typing import Any

import httpx2
import psutil
import pytest
from support.server_process import ServerProcess
from support.serving import Served, serving

from skiros_py.errors import FileError
from skiros_py.server.settings import ServerSettings

from .hard import ANYHOW, HOLDS, LATER, STARTER, api_of, job_of, moves, over, until


@pytest.fixture(scope="module")
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    with serving("kitting", tmp_path_factory.mktemp("data")) as served:
        yield served


@pytest.fixture(scope="module")
def api(served: Served) -> Iterator[httpx2.Client]:
    with api_of(served) as api:
        yield api


def test_many_requests_and_closed_streams_leave_no_open_file_and_no_thread_behind(
    served: Served, api: httpx2.Client
) -> None:
    def ask(many: int) -> None:
        for number in range(many):
            assert api.get("/jobs", params={"limit": 1}).status_code == 200
            if number % 10 == 0:
                with api_of(served) as another:
                    assert another.get("/session").status_code == 200
            if number % 5 == 0:
                with api.sse("/events") as source:
                    next(iter(source))

    ask(50)  # what is made once is made
    until(lambda: served.services.streams.open == 0)
    process = psutil.Process()
    files, threads = process.num_fds(), threading.active_count()
    ask(1000)
    until(lambda: served.services.streams.open == 0)
    until(lambda: process.num_fds() <= files + 3)
    assert threading.active_count() <= threads + 5


def test_edits_and_jobs_use_little_disk_space_and_the_event_log_is_bounded(tmp_path: Path) -> None:
    left = []
    for _ in range(2):
        with serving("kitting", tmp_path) as served, api_of(served) as api:
            for number in range(300):
                api.patch("/elements/rack_1", json={"label": f"rack {number}"}, headers=ANYHOW).raise_for_status()
                api.put("/jobs/again", json={**HOLDS, **LATER}).raise_for_status()
                api.delete("/jobs/again").raise_for_status()
            assert len(served.services.station.events.since(0, 100_000)) <= served.services.settings.kept_events
        # What is left when it ends: while it runs, a write-ahead log keeps the size that it once had.
        left.append(sum(file.stat().st_size for file in tmp_path.glob("*.db*")))
    per_round = (left[1] - left[0]) / 300
    assert per_round < 20_000, f"{per_round:.0f} bytes for an edit and a job"


# ------------------------------------------------------------------ processes


def test_sigterm_during_a_job_with_open_streams_ends_cleanly_and_the_job_is_held(
    tmp_path: Path,
) -> None:
    with ServerProcess("kitting", "--fake", "--pace", "3", data=tmp_path) as server, server.client() as client:
        api = client.http
        api.put("/jobs/kit", json=STARTER).raise_for_status()
        until(lambda: moves(api, "kit"))
        with api.sse("/events") as source:
            next(iter(source))
            started = psutil.Process(server.pid).children(recursive=True)
            assert server.end(signal.SIGTERM) == 0
        until(lambda: not any(child.is_running() for child in started))
    assert "Traceback" not in server.said
    with ServerProcess("--fake", data=tmp_path) as server, server.client() as client:
        job = job_of(client.http, "kit")
        assert job["state"]["substates"] == ["Held"]
        client.http.post("/jobs/kit/abort").raise_for_status()
        assert over(client.http, "kit")["outcome"] == "aborted"


def test_the_server_upgrades_an_old_job_file_in_which_an_unreadable_job_is_named_and_hides_no_other(
    tmp_path: Path,
) -> None:
    write_old_jobs(tmp_path / "jobs.db")
    with closing(sqlite3.connect(tmp_path / "jobs.db")) as file, file:
        file.execute("INSERT INTO jobs VALUES ('torn', 3, '{')")
    with serving("kitting", tmp_path) as served, api_of(served) as api:
        assert [job["id"] for job in api.get("/jobs").raise_for_status().json()["items"]] == ["cut", "waits"]
        assert job_of(api, "waits")["state"]["text"] == "AllowedToStart"
        assert job_of(api, "cut")["state"]["substates"] == ["Held"]
        (alarm,) = [one for one in api.get("/alarms").json()["items"] if one["source"] == "job torn"]
        assert "job torn cannot be read" in alarm["text"]
        for refused in (api.get("/jobs/torn"), api.put("/jobs/torn", json=HOLDS)):
            assert refused.status_code == 503
            assert "job torn cannot be read" in refused.json()["detail"]
        assert api.put("/jobs/new", json=HOLDS).json()["number"] == 6
    with closing(sqlite3.connect(tmp_path / "jobs.db")) as file:
        assert file.execute("SELECT data FROM jobs WHERE id = 'torn'").fetchall() == [("{",)]


def test_damaged_records_of_traces_audit_log_documents_and_webhooks_hide_no_others_and_raise_alarms(
    tmp_path: Path,
) -> None:
    write_old_jobs(tmp_path / "jobs.db")
    begun = json.dumps({"time": 0.5, "what": "begun", "text": "begun", "data": {}})
    with closing(sqlite3.connect(tmp_path / "jobs.db")) as file, file:
        file.executemany("INSERT INTO trace VALUES ('cut', ?)", [("{",), (begun,)])
    settings = replace(ServerSettings(), webhook_hosts=("127.0.0.1",))
    with serving("kitting", tmp_path, settings=settings) as served, api_of(served) as api:
        for name in ("a", "b"):
            new = {"data": {"steps": [{"skill": "drive", "arguments": {}}]}}
            api.put(f"/documents/sequence/{name}", json=new, headers={"If-None-Match": "*"}).raise_for_status()
        hook = api.post("/webhooks", json={"url": "http://127.0.0.1:9/"}).raise_for_status().json()["webhook"]["id"]
        assert len(api.get("/audit").json()["items"]) == 3
        for name, change in (
            ("access.db", "UPDATE audit SET data = '{' WHERE number = 2"),
            ("server.db", "UPDATE documents SET data = '{' WHERE name = 'a'"),
            ("webhooks.db", "UPDATE subscriptions SET data = '{'"),
        ):
            with closing(sqlite3.connect(tmp_path / name)) as file, file:
                file.execute(change)

        def items(path: str) -> list[dict[str, Any]]:
            return api.get(path).raise_for_status().json()["items"]

        assert [entry["text"] for entry in items("/jobs/cut/trace")] == ["begun"]
        assert [record["number"] for record in items("/audit")] == [3, 1]
        assert [one["id"] for one in items("/documents/sequence")] == ["b"]
        assert items("/webhooks") == []
        named = {"entry 1 of the trace of job cut", "record 2 of the audit log", f"webhook {hook}"}
        until(lambda: named < {alarm["source"] for alarm in items("/alarms") if alarm["kind"] == "record"})


def test_the_server_leaves_a_job_file_of_a_later_version_alone(tmp_path: Path) -> None:
    with closing(sqlite3.connect(tmp_path / "jobs.db")) as file:
        file.executescript(OLD_JOBS.replace("user_version = 1", "user_version = 999"))
    before = (tmp_path / "jobs.db").read_bytes()
    with pytest.raises(FileError, match="has tables of version 999"), serving("kitting", tmp_path):
        pass
    assert (tmp_path / "jobs.db").read_bytes() == before


OLD_JOBS = """
CREATE TABLE jobs (id TEXT PRIMARY KEY, number INTEGER NOT NULL UNIQUE, data TEXT NOT NULL) WITHOUT ROWID;
CREATE TABLE transitions (job TEXT NOT NULL, data TEXT NOT NULL);
CREATE INDEX transitions_by_job ON transitions (job);
CREATE TABLE intents (job TEXT NOT NULL, number INTEGER NOT NULL, data TEXT NOT NULL, PRIMARY KEY (job, number))
    WITHOUT ROWID;
CREATE TABLE trace (job TEXT NOT NULL, data TEXT NOT NULL);
CREATE INDEX trace_by_job ON trace (job);
CREATE TABLE numbers (last INTEGER NOT NULL);
INSERT INTO numbers VALUES (5);
PRAGMA application_id = 1936419439;
PRAGMA user_version = 1;
"""
"""The tables of version 1."""


def write_old_jobs(path: Path) -> None:
    """Writes a file as version 1 left it: one job that was cut off, one that waits for its gate."""
    policy = {"rest": True, "ask": False, "attempts": 3, "partial": False}
    for_all = {"detail": "", "choices": [], "question": None, "outcome": None, "actuals": [], "reasons": [], "plan": []}
    with closing(sqlite3.connect(path)) as file:
        file.executescript(OLD_JOBS)
        for number, (id_, state) in enumerate((("cut", 3), ("waits", 2)), start=4):
            order = {"id": id_, "goal": ["InKit(Starter, kit_1)"], "description": "", "priority": 0, "deadline": None}
            order |= {"not_before": 4e9, "expires": False, "policy": policy}
            times = {"ordered": 1.7e9, "started": 1.7e9 if state == 3 else None, "ended": None}
            job = {"order": order, "number": number, "state": state, **for_all, "attempts": 1, "version": 4, **times}
            file.execute("INSERT INTO jobs VALUES (?, ?, ?)", (id_, number, json.dumps(job)))
        file.commit()
