"""``skiros key``."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path
from typing import get_args

import httpx2
from click.testing import CliRunner, Result
from support import warm_python
from support.serving import serving

from skiros_py.api.server import RoleName
from skiros_py.cli.key import command
from skiros_py.server.access.roles import Role


def _skiros(*arguments: str) -> subprocess.CompletedProcess[str]:
    return warm_python.run([*warm_python.SKIROS, "key", *arguments], timeout=60)


def test_a_key_created_in_the_shell_gives_access_until_it_is_revoked_there(tmp_path: Path) -> None:
    data = tmp_path / "data"
    with serving("kitting", data) as served, httpx2.Client(base_url=f"{served.url}/api/v1") as client:
        made = _skiros("create", "line 1", "--role", "mes", "--expires", "90d", "--data", str(data))
        theirs = {"X-API-Key": made.stdout.strip()}

        assert client.get("/session").status_code == 401
        assert client.get("/session", headers=theirs).json()["name"] == "line 1"

        (listed,) = json.loads(_skiros("list", "--data", str(data), "--json").stdout)["keys"]
        revoked = _skiros("revoke", listed["id"], "--data", str(data))

        assert revoked.returncode == 0
        assert client.get("/session", headers=theirs).status_code == 401


def test_the_first_key_can_be_created_in_an_empty_directory_and_is_shown_once(tmp_path: Path) -> None:
    made = _skiros("create", "anna", "--role", "admin", "--new", "--data", str(tmp_path / "new"))
    listed = _skiros("list", "--data", str(tmp_path / "new"))

    assert made.stdout.startswith("sk_")
    assert made.stdout.strip() not in listed.stdout
    assert "anna: never used" in listed.stdout


def test_a_fault_is_reported_in_one_line(tmp_path: Path) -> None:
    nothing = _skiros("list", "--data", str(tmp_path))
    _skiros("create", "anna", "--role", "admin", "--data", str(tmp_path))
    unknown = _skiros("revoke", "nope", "--data", str(tmp_path))
    span = _skiros("create", "anna", "--role", "admin", "--expires", "soon", "--data", str(tmp_path))

    assert (nothing.returncode, unknown.returncode, span.returncode) == (2, 2, 2)
    assert "skiros key create" in nothing.stderr
    assert "unknown key 'nope'" in unknown.stderr
    assert "12h, 90d or 4w" in span.stderr


def test_the_roles_are_those_of_the_server() -> None:
    option = next(one for one in command.commands["create"].params if one.name == "role")  # type: ignore[attr-defined]

    assert set(option.type.choices) == {role.value for role in Role} == set(get_args(RoleName))


def test_creating_a_key_does_not_create_a_missing_folder(tmp_path: Path) -> None:
    missing = tmp_path / "mistyped" / "plant"
    told = _invoke(missing)

    assert "no world lives there" in str(told.exception)
    assert not missing.parent.exists()


def test_a_file_is_refused_as_the_folder_for_a_key(tmp_path: Path) -> None:
    (tmp_path / "file").write_bytes(b"")

    assert "is not a folder" in str(_invoke(tmp_path / "file").exception)


def _invoke(data: Path) -> Result:
    return CliRunner().invoke(command, ["create", "anna", "--role", "viewer", "--data", str(data)])
