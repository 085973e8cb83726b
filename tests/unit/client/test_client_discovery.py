"""The server of a data directory is found while it lives, and only then."""

from __future__ import annotations

import os
import stat
from pathlib import Path

import pytest

from skiros_py.client.client import find_server, server_of
from skiros_py.errors import FileError
from skiros_py.server.serving import announced
from skiros_py.world.journal.data_directory import DirectoryLock

URL = "http://127.0.0.1:8000"


@pytest.fixture
def owned(tmp_path: Path):
    lock = DirectoryLock(tmp_path)
    yield tmp_path
    lock.release()


def test_a_server_is_found_while_it_serves(owned: Path) -> None:
    with announced(owned, URL, "secret") as server:
        assert find_server(owned) == server
        assert server.pid == os.getpid()
    assert find_server(owned) is None


def test_only_the_owner_can_read_the_address_file(owned: Path) -> None:
    with announced(owned, URL, "secret"):
        assert stat.S_IMODE((owned / "server.json").stat().st_mode) == 0o600


def test_the_token_does_not_appear_in_the_repr(owned: Path) -> None:
    with announced(owned, URL, "secret") as server:
        assert "secret" not in repr(server)


def test_the_address_file_of_a_killed_server_is_ignored(tmp_path: Path) -> None:
    lock = DirectoryLock(tmp_path)
    with announced(tmp_path, URL, "secret"):
        lock.release()
        assert find_server(tmp_path) is None


def test_the_address_file_of_a_killed_server_is_ignored_while_another_program_uses_the_directory(owned: Path) -> None:
    with announced(owned, URL, "secret") as server:
        (owned / "server.json").write_text(server.model_copy(update={"pid": 1}).model_dump_json(), encoding="utf-8")
        assert find_server(owned) is None


def test_finding_a_server_does_not_lock_the_directory(tmp_path: Path) -> None:
    DirectoryLock(tmp_path).release()
    find_server(tmp_path)
    DirectoryLock(tmp_path).release()


@pytest.mark.parametrize("text", ["", "{}", "[", '{"url": 1}'])
def test_an_invalid_address_file_means_no_server(owned: Path, text: str) -> None:
    (owned / "server.json").write_text(text, encoding="utf-8")

    assert find_server(owned) is None


def test_without_a_server_the_error_explains_how_to_start_one(tmp_path: Path) -> None:
    with pytest.raises(FileError, match="skiros serve --data"):
        server_of(tmp_path)
