"""``skiros serve`` as people start and end it."""

from __future__ import annotations

import json
import os
import signal
import socket
import subprocess
import sys
from pathlib import Path

import httpx2
import pytest

from skiros_py.client import Client
from skiros_py.errors import FileError
from skiros_py.testing.server_process import ServerProcess


def skiros(*arguments: str, **environment: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "skiros_py.cli", *arguments]
    return subprocess.run(
        command, capture_output=True, text=True, check=False, timeout=60, env={**os.environ, **environment}
    )


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT, signal.SIGHUP])
def test_a_polite_kill_ends_it_in_good_order(number: int, tmp_path: Path) -> None:
    with ServerProcess("kitting", "--fake", data=tmp_path) as server:
        assert httpx2.get(f"{server.url}/healthz").status_code == 200
        assert server.end(number) == 0
    assert not (tmp_path / "server.json").exists()
    assert "Traceback" not in server.said


def test_a_second_server_of_a_directory_is_told_where_the_first_one_is(tmp_path: Path) -> None:
    with ServerProcess("kitting", "--fake", data=tmp_path) as server:
        second = skiros("serve", "--data", str(tmp_path), "--fake", "--port", "0", "--json")
    assert second.returncode == json.loads(second.stdout)["status"] == 2
    assert f"process {server.pid}" in second.stderr
    assert server.url in second.stderr
    assert "Traceback" not in second.stderr


def test_a_run_on_its_directory_is_told_where_the_server_is(tmp_path: Path) -> None:
    with ServerProcess("kitting", "--fake", data=tmp_path) as server:
        run = skiros("run", "kitting", "--fake", "--data", str(tmp_path))
    assert run.returncode == 2
    assert f"which serves it at {server.url}" in run.stderr


def test_a_port_that_somebody_has_is_refused_before_anything_is_opened(tmp_path: Path) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = str(taken.getsockname()[1])
        refused = skiros("serve", "kitting", "--fake", "--data", str(tmp_path / "data"), "--port", port)
    assert refused.returncode == 2
    assert f"cannot listen at 127.0.0.1:{port}" in refused.stderr
    assert not (tmp_path / "data").exists()


def test_without_keys_only_this_machine_is_served(tmp_path: Path) -> None:
    refused = skiros("serve", "kitting", "--fake", "--data", str(tmp_path), "--host", "0.0.0.0", "--port", "0")
    assert refused.returncode == 2
    assert "skiros key create" in refused.stderr


def test_a_new_directory_needs_a_scene(tmp_path: Path) -> None:
    refused = skiros("serve", "--data", str(tmp_path / "data"), "--fake", "--port", "0")
    assert refused.returncode == 2
    assert "say with which scene it begins" in refused.stderr
    assert not (tmp_path / "data").exists()


def test_the_scene_can_be_left_out_once_a_world_lives_there(tmp_path: Path) -> None:
    with ServerProcess("kitting", "--fake", data=tmp_path) as server:
        server.end()
    with ServerProcess("--fake", data=tmp_path) as server:
        assert server.end() == 0


def test_its_user_needs_no_key_and_nobody_finds_what_was_killed(tmp_path: Path) -> None:
    with ServerProcess("kitting", "--fake", "--auth", "keys", data=tmp_path) as server:
        path = "/api/v1/session"
        assert httpx2.get(server.url + path).status_code == 401
        with server.client() as client:
            assert client.http.get("/session").status_code == 200
        server.kill()
    assert (tmp_path / "server.json").exists()
    with pytest.raises(FileError, match="no server runs on this data directory"):
        Client.of_data(tmp_path)


def test_logs_are_one_object_a_line_where_that_is_asked_for(tmp_path: Path) -> None:
    with ServerProcess("kitting", "--fake", "--log", "json", data=tmp_path) as server:
        httpx2.post(f"{server.url}/api/v1/stop", json={"reason": "a test"})
        server.end()
    lines = [line for line in server.said.splitlines() if line.startswith("{")]
    assert all(isinstance(json.loads(line), dict) for line in lines)
