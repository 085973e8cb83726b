"""Case 20: nothing leaks, old files are read, and a server ends in good order whatever it does."""

from __future__ import annotations

import signal
import sqlite3
import threading
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import httpx2
import psutil
import pytest

from skiros_py.testing.server_process import ServerProcess
from skiros_py.testing.serving import Served, serving

from .hard import ANYHOW, HOLDS, LATER, STARTER, api_of, job_of, moves, over, until


@pytest.fixture(scope="module")
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    with serving("kitting", tmp_path_factory.mktemp("data")) as served:
        yield served


@pytest.fixture(scope="module")
def api(served: Served) -> Iterator[httpx2.Client]:
    with api_of(served) as api:
        yield api


def test_a_thousand_requests_and_two_hundred_closed_streams_leave_no_file_and_no_thread_behind(
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


def test_the_log_of_events_the_audit_and_the_journal_do_not_grow_without_end(served: Served, api: httpx2.Client) -> None:
    data = served.services.data
    written = [sum(file.stat().st_size for file in data.glob("*.db*"))]
    for _ in range(2):
        for number in range(300):
            api.patch("/elements/rack_1", json={"label": f"rack {number}"}, headers=ANYHOW).raise_for_status()
            api.put("/jobs/again", json={**HOLDS, **LATER}).raise_for_status()
            api.delete("/jobs/again").raise_for_status()
        written.append(sum(file.stat().st_size for file in data.glob("*.db*")))
    per_round = (written[2] - written[1]) / 300
    assert per_round < 20_000, f"{per_round:.0f} bytes for an edit and a job"
    assert len(served.services.events.since(0, 100_000)) <= served.services.settings.kept_events


# ------------------------------------------------------------------ processes


def test_a_polite_kill_while_a_job_runs_and_streams_are_open_ends_in_good_order_and_the_job_is_held(
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
    make_old(tmp_path / "jobs.db")
    with ServerProcess("--fake", data=tmp_path) as server, server.client() as client:
        job = job_of(client.http, "kit")
        assert job["state"]["substates"] == ["Held"]
        client.http.post("/jobs/kit/abort").raise_for_status()
        assert over(client.http, "kit")["outcome"] == "aborted"


def make_old(path: Path) -> None:
    """Makes a file of jobs one that version 1 left, with an order that waits besides."""
    with closing(sqlite3.connect(path)) as file:
        print(file.execute("PRAGMA user_version").fetchall())


def test_an_old_file_of_jobs_is_brought_up_to_date_and_one_of_a_later_version_is_left_alone(tmp_path: Path) -> None:
    pass
