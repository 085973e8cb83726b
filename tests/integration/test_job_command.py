"""``skiros job`` against a server that was started as people start it."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest
from support import warm_python
from support.server_process import ServerProcess

from skiros_py.client import Client
from skiros_py.errors import FileError

STARTER = "InKit(Starter, kit_1)"


def skiros(*arguments: str) -> subprocess.CompletedProcess[str]:
    return warm_python.run([*warm_python.SKIROS, *arguments], timeout=120)


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ServerProcess]:
    data = tmp_path_factory.mktemp("station")
    with ServerProcess("kitting", "--fake", "--pace", "max", data=data) as server:
        yield server


def job(server: ServerProcess, *arguments: str) -> subprocess.CompletedProcess[str]:
    return skiros("job", *arguments, "--data", str(server.data))


def test_watching_a_job_exits_with_the_status_of_its_outcome(server: ServerProcess) -> None:
    done = job(server, "submit", STARTER, "--id", "watched", "--watch", "--json")

    told = json.loads(done.stdout)
    assert (done.returncode, told["outcome"]) == (0, "succeeded")
    assert [part["element"] for part in told["materials"]] == ["starter_1"]
    assert "place starter_1" in done.stderr


def test_a_job_without_a_plan_exits_with_status_three(server: ServerProcess) -> None:
    done = job(server, "submit", "ObjectAtLocation(starter_1, pallet_b)", "--watch")

    assert done.returncode == 3
    assert "pallet_b is not a Compartment" in done.stdout


def test_a_long_list_of_jobs_goes_on_where_it_ended(server: ServerProcess) -> None:
    for name in ("page-1", "page-2"):
        assert job(server, "submit", STARTER, "--id", name, "--hold").returncode == 0

    first = json.loads(job(server, "list", "--limit", "1", "--state", "NotAllowedToStart", "--json").stdout)
    second = json.loads(job(server, "list", "--state", "NotAllowedToStart", "--cursor", first["next"], "--json").stdout)

    assert [one["id"] for one in first["items"] + second["items"]] == ["page-1", "page-2"]
    for name in ("page-1", "page-2"):
        assert job(server, "cancel", name).returncode == 0


def test_a_job_that_may_not_start_yet_accepts_commands_until_it_is_removed(server: ServerProcess) -> None:
    assert job(server, "submit", STARTER, "--id", "held", "--hold").returncode == 0
    assert "NotAllowedToStart" in job(server, "show", "held").stdout
    assert job(server, "cancel", "held", "--json").stdout.startswith('{"id": "held", "removed": true')

    gone = job(server, "show", "held")
    assert gone.returncode == 2
    assert "unknown job 'held'" in gone.stderr


def test_a_goal_that_does_not_parse_is_shown_with_the_place_of_the_error(server: ServerProcess) -> None:
    refused = job(server, "submit", "InKit(Starter", "--json")

    assert refused.returncode == json.loads(refused.stdout)["status"] == 2
    assert "column 14" in refused.stderr


def test_a_preview_does_not_move_the_robot(server: ServerProcess) -> None:
    before = len(json.loads(job(server, "list", "--json").stdout)["items"])
    shown = job(server, "preview", "InKit(Alternator, kit_1)", "--json")

    assert [step["skill"] for step in json.loads(shown.stdout)["steps"]] == ["drive", "pick", "drive", "place"]
    assert len(json.loads(job(server, "list", "--json").stdout)["items"]) == before


@pytest.mark.parametrize(
    ("arguments", "what"),
    [
        ((), "either GOALs or --template"),
        ((STARTER, "--template", "fill kit"), "either GOALs or --template"),
        (("--template", "t", "--param", "kit"), "--param takes NAME=VALUE"),
        ((STARTER, "--deadline", "tomorrow"), "is no time such as"),
        ((STARTER, "--id", "x" * 300), "id: "),
    ],
)
def test_a_wrong_order_is_refused_in_one_line(server: ServerProcess, arguments: tuple[str, ...], what: str) -> None:
    refused = job(server, "submit", *arguments)

    assert refused.returncode == 2
    assert what in refused.stderr
    assert "Traceback" not in refused.stderr


def test_a_stop_from_the_shell_holds_until_a_reset(server: ServerProcess) -> None:
    data = ("--data", str(server.data))

    assert json.loads(skiros("stop", *data, "--reason", "a test", "--json").stdout)["halted"]
    assert not json.loads(skiros("reset", *data, "--json").stdout)["halted"]


def test_jobs_can_be_read_without_a_server_and_continue_when_it_is_back(tmp_path: Path) -> None:
    with ServerProcess("kitting", "--fake", data=tmp_path) as server:
        assert job(server, "submit", STARTER, "--id", "kept", "--hold").returncode == 0
        server.kill()
    assert (tmp_path / "server.json").exists()
    with pytest.raises(FileError, match="no server runs on this data directory"):
        Client.of_data(tmp_path)
    shown = job(server, "show", "kept")
    assert shown.returncode == 0
    assert "kept: NotAllowedToStart" in shown.stdout
    assert "no server runs on" in shown.stderr
    refused = job(server, "submit", STARTER)
    assert refused.returncode == 2
    assert "skiros serve --data" in refused.stderr
    with ServerProcess("--fake", "--pace", "max", data=tmp_path) as server:
        assert job(server, "start", "kept").returncode == 0
        assert job(server, "watch", "kept").returncode == 0
