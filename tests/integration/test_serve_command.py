"""``skiros serve`` as people start and end it."""

from __future__ import annotations

import json
import os
import signal
import socket
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import closing
from pathlib import Path

import httpx2
import pytest
from support.server_process import ServerProcess

from skiros_py.api.jobs import JobOrder
from skiros_py.cli.job_files import kept_jobs
from skiros_py.cli.main import main
from skiros_py.cli.serve import rollback_first_start
from skiros_py.errors import UsageError
from skiros_py.server.access.keys import KeyStore
from skiros_py.server.access.roles import Role

STOPS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
PATIENCE = 60.0


@pytest.fixture(autouse=True)
def _process() -> Iterator[None]:
    """The commands are for processes of their own: what they change of this one is put back."""
    handlers, switching = {number: signal.getsignal(number) for number in STOPS}, sys.getswitchinterval()
    yield
    sys.setswitchinterval(switching)
    for number, handler in handlers.items():
        signal.signal(number, handler)


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ServerProcess]:
    data = tmp_path_factory.mktemp("station")
    with ServerProcess("kitting", "--fake", "--auth", "keys", "--log", "json", data=data) as server:
        yield server


class Refusals:
    """Runs commands that are refused."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]) -> None:
        self._monkeypatch, self._capfd = monkeypatch, capfd

    def told(self, *arguments: str) -> tuple[str, str]:
        """Returns what a command says on stdout and stderr; it ends with status 2."""
        self._monkeypatch.setattr("sys.argv", ["skiros", *arguments])
        with pytest.raises(SystemExit) as ended:
            main()
        out, err = self._capfd.readouterr()
        assert ended.value.code == 2
        assert "Traceback" not in err
        return out, err


@pytest.fixture
def refusals(monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]) -> Refusals:
    return Refusals(monkeypatch, capfd)


def until(reached: Callable[[], object]) -> None:
    end = time.monotonic() + PATIENCE
    while not reached():
        assert time.monotonic() < end
        time.sleep(0.02)


def children(pid: int) -> set[int]:
    """Returns the processes that a process has started, and those that they have."""
    found: set[int] = set()
    for file in Path(f"/proc/{pid}/task").glob("*/children"):
        for child in map(int, file.read_text(encoding="ascii").split()):
            found |= {child, *children(child)}
    return found


def lives(pid: int) -> bool:
    try:
        return Path(f"/proc/{pid}/stat").read_text(encoding="ascii").rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


# ---------------------------------------------------------------- while it runs


def test_a_second_server_of_a_directory_gets_the_address_of_the_first(
    server: ServerProcess, refusals: Refusals
) -> None:
    out, err = refusals.told("serve", "--data", str(server.data), "--fake", "--port", "0", "--json")

    assert json.loads(out)["status"] == 2
    assert f"process {server.pid}" in err
    assert server.url in err


def test_a_run_on_a_served_directory_is_refused_with_the_address_of_the_server(
    server: ServerProcess, refusals: Refusals
) -> None:
    _, err = refusals.told("run", "kitting", "--fake", "--data", str(server.data))

    assert f"which serves it at {server.url}" in err


def test_the_user_who_started_the_server_needs_no_key(server: ServerProcess) -> None:
    assert httpx2.get(f"{server.url}/api/v1/session").status_code == 401
    with server.client() as client:
        assert client.http.get("/session").status_code == 200


def test_logs_are_one_json_object_per_line_on_request(server: ServerProcess) -> None:
    with server.client() as client:
        client.station.stop("a test")

    until(lambda: "a test" in server.said)
    lines = [json.loads(line) for line in server.said.splitlines() if line.startswith("{")]
    assert any("a test" in line["event"] for line in lines)


# ---------------------------------------------------------------- refused before anything is opened


def test_a_port_in_use_is_refused_before_the_world_is_opened(tmp_path: Path, refusals: Refusals) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = str(taken.getsockname()[1])
        _, err = refusals.told("serve", "kitting", "--fake", "--data", str(tmp_path / "data"), "--port", port)

    assert f"cannot listen at 127.0.0.1:{port}" in err
    assert not (tmp_path / "data").exists()


def test_without_keys_only_this_machine_is_served(tmp_path: Path, refusals: Refusals) -> None:
    everywhere = ("--host", "0.0.0.0", "--port", "0")
    _, err = refusals.told("serve", "kitting", "--fake", "--data", str(tmp_path), *everywhere)

    assert "skiros key create" in err


def test_a_new_directory_needs_a_scene(tmp_path: Path, refusals: Refusals) -> None:
    _, err = refusals.told("serve", "--data", str(tmp_path / "data"), "--fake", "--port", "0")

    assert "say with which scene it begins" in err
    assert not (tmp_path / "data").exists()


@pytest.mark.parametrize(
    "mistake",
    [("kitting", "--robot", "robot_9"), ("kitting", "--planner", "nope"), ("nope",), ("kitting", "--host", "0.0.0.0")],
)
def test_a_refused_first_start_leaves_nothing_behind(
    tmp_path: Path, refusals: Refusals, mistake: tuple[str, ...]
) -> None:
    _, err = refusals.told("serve", *mistake, "--fake", "--data", str(tmp_path / "plant" / "cell"), "--port", "0")

    assert mistake[-1] in err.rpartition("skiros: ")[2]
    assert not (tmp_path / "plant").exists()


def test_after_a_refused_first_start_the_next_one_may_use_another_scene(tmp_path: Path, refusals: Refusals) -> None:
    (tmp_path / "learned.ttl").write_bytes(b"")
    refusals.told("serve", "kitting", "--robot", "robot_9", "--fake", "--data", str(tmp_path), "--port", "0")

    assert not (tmp_path / "journal.db").exists()
    assert (tmp_path / "learned.ttl").exists()


def test_a_key_created_during_a_refused_first_start_is_kept(tmp_path: Path) -> None:
    data = tmp_path / "new"
    with pytest.raises(UsageError, match="refused"):
        _refused_after_a_key(data)

    with closing(KeyStore(data)) as keys:
        assert [key.name for key in keys.all()] == ["anna"]


def _refused_after_a_key(data: Path) -> None:
    with rollback_first_start(data):
        data.mkdir()
        with closing(KeyStore(data)) as keys:
            keys.create("anna", Role.ADMIN, None)
        raise UsageError("refused")


@pytest.mark.parametrize(("name", "why"), [("file", "is not a folder"), ("file/x", "cannot be made")])
def test_a_data_directory_that_cannot_be_created_is_named(
    tmp_path: Path, refusals: Refusals, name: str, why: str
) -> None:
    (tmp_path / "file").write_bytes(b"")
    _, err = refusals.told("serve", "kitting", "--fake", "--data", str(tmp_path / name), "--port", "0")

    assert f"{tmp_path / name}: {why}" in err


@pytest.mark.parametrize("option", ["--allow-host", "--allow-origin", "--webhook-host"])
def test_an_option_that_can_never_match_is_refused_before_the_world_is_opened(
    tmp_path: Path, refusals: Refusals, option: str
) -> None:
    data = str(tmp_path / "data")
    _, err = refusals.told("serve", "kitting", "--fake", "--data", data, "--port", "0", option, "http://x/y")

    assert f"skiros: {option}: nothing can ever come as 'http://x/y'" in err


# ---------------------------------------------------------------- the end


def test_sigterm_and_sigint_end_the_server_cleanly_and_the_next_start_needs_no_scene(tmp_path: Path) -> None:
    said: list[str] = []
    for number, scene in zip(STOPS, (["kitting"], [], ["kitting_two"]), strict=True):
        with ServerProcess(*scene, "--fake", data=tmp_path) as server:
            assert httpx2.get(f"{server.url}/healthz").status_code == 200
            assert server.end(number) == 0
        said.append(server.said)
        assert not (tmp_path / "server.json").exists()
        assert "Traceback" not in server.said
    assert f"skiros key create NAME --role admin --data {tmp_path}'" in said[0]
    assert ["was not loaded" in one for one in said] == [False, False, True]
    assert "lives kitting: kitting_two was not loaded" in said[2]


def test_a_second_ctrl_c_ends_the_server_at_once(tmp_path: Path) -> None:
    with ServerProcess("kitting", "--fake", data=tmp_path) as server:
        address = httpx2.URL(server.url)
        with socket.create_connection((address.host, address.port)) as unfinished:  # the end waits for this request
            unfinished.sendall(b"POST /api/v1/jobs HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Length: 9\r\n\r\n{")
            assert httpx2.get(f"{server.url}/healthz").status_code == 200
            os.kill(server.pid, signal.SIGINT)
            until(lambda: not listens(address))
            assert server.end(signal.SIGINT) == 130


def listens(address: httpx2.URL) -> bool:
    try:
        socket.create_connection((address.host, address.port)).close()
    except OSError:
        return False
    return True


def test_sigterm_during_a_job_holds_it_for_a_person(tmp_path: Path) -> None:
    with ServerProcess("kitting", "--pace", "max", data=tmp_path) as server, server.client() as client:
        client.jobs.put("cut", JobOrder(goal="InKit(Starter, kit_1)"))
        client.jobs.wait("cut", until=lambda job: job.detail == "running", timeout=PATIENCE)
        client.close()
        started = children(server.pid)
        assert server.end(signal.SIGTERM) == 0  # the server sees itself that it comes to its end within 9 s
    with kept_jobs(tmp_path) as jobs:
        job = jobs.get("cut")

    assert (job.state.text, job.state.substates) == ("Interrupted", ("Held",))
    until(lambda: not any(map(lives, started)))
    assert "Traceback" not in server.said
