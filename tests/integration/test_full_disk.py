"""A disk that fills while a job runs: everything stands, reads go on, and so does the job once there is room."""

from __future__ import annotations

import mmap
import os
import resource
import shutil
import subprocess
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager, suppress
from pathlib import Path

import httpx2
import pytest
from support.programs import needs
from support.server_process import ServerProcess

from skiros_py.station.data_files import check_data

from .hard import LATER, STARTER, job_of, moves, over, until

MKFS = shutil.which("mkfs.ext2", path=f"{os.environ.get('PATH', '')}:/usr/sbin:/sbin")


@contextmanager
def mounted(folder: Path, *arguments: str) -> Iterator[Path]:
    """Mounts a real file system."""
    folder.mkdir()
    if subprocess.run(["mount", *arguments, str(folder)], capture_output=True, check=False).returncode:
        pytest.skip("mounting a file system needs a privilege that containers lack; the other tests refuse writes")
    try:
        yield folder
    finally:
        subprocess.run(["umount", "-l", str(folder)], check=True)


@pytest.fixture
def small_disk(tmp_path: Path) -> Iterator[Path]:
    """A real file system of 8 MB."""
    with mounted(tmp_path / "disk", "-t", "tmpfs", "-o", "size=8m", "tmpfs") as folder:
        yield folder


@pytest.fixture
def device(small_disk: Path, tmp_path: Path) -> Iterator[Path]:
    """A file system on a block device of 64 MB, whose blocks are taken from the small disk as they are written.

    It becomes read-only, as any does at an error, when the folder "trap" is read: its entry has the length 0.
    """
    image, content = small_disk / "image", tmp_path / "content"
    (content / "trap").mkdir(parents=True)
    (content / "trap" / "damaged-entry").touch()
    with image.open("wb") as file:
        file.truncate(64 << 20)
    subprocess.run([MKFS or "mkfs.ext2", "-q", "-d", str(content), str(image)], check=True, capture_output=True)
    with image.open("r+b") as file, mmap.mmap(file.fileno(), 0) as blocks:
        name = blocks.find(b"damaged-entry")
        blocks[name - 4 : name - 2] = bytes(2)
    with mounted(tmp_path / "device", "-o", "loop,errors=remount-ro", str(image)) as folder:
        yield folder


def make_read_only(folder: Path) -> None:
    """Lets the kernel make a file system read-only, as after an error on the disk, although files are being written."""
    with suppress(OSError):
        list((folder / "trap").iterdir())
    with pytest.raises(OSError, match="Read-only file system"):
        (folder / "written").touch()


@contextmanager
def filled(folder: Path) -> Iterator[None]:
    """Fills a file system to the last byte."""
    ballast = folder / "ballast"
    with ballast.open("wb", buffering=0) as file, suppress(OSError):
        while True:
            file.write(b"x" * 4096)
    try:
        yield
    finally:
        ballast.unlink()


@contextmanager
def refused(server: ServerProcess) -> Iterator[None]:
    """No file of the server can be written: the kernel refuses it with an error, as a failing disk does."""
    before = resource.prlimit(server.pid, resource.RLIMIT_FSIZE)
    resource.prlimit(server.pid, resource.RLIMIT_FSIZE, (0, before[1]))
    try:
        yield
    finally:
        resource.prlimit(server.pid, resource.RLIMIT_FSIZE, before)


def suspended(api: httpx2.Client) -> bool:
    """Returns True if the job waits without a question: it goes on by itself."""
    return bool(job_of(api, "kit")["state"]["substates"] == ["Suspended"])


def held_and_resumed(
    server: ServerProcess, api: httpx2.Client, full: AbstractContextManager[None], status: int
) -> None:
    """Runs a job, lets the disk fail in the middle, looks, and waits for the end of the job."""
    api.put("/jobs/kit", json=STARTER).raise_for_status()
    until(lambda: moves(api, "kit"))
    with full:
        until(lambda: suspended(api))
        (alarm,) = [one for one in api.get("/alarms").json()["items"] if one["kind"] == "disk"]
        assert alarm["active"]
        assert [job["state"]["substates"] for job in api.get("/jobs").json()["items"]] == [["Suspended"]]
        for path in ("/health/live", "/world/elements", "/jobs/kit/trace", "/alarms", "/robots"):
            assert api.get(path).status_code in (200, 404), path
        until(lambda: api.get("/stop").json()["standing"] is not False)
        refusal = api.put("/jobs/other", json={**STARTER, **LATER})
        assert refusal.status_code == status, refusal.text
        assert "disk" in refusal.json()["detail"]
        edit = api.patch("/elements/rack_1", json={"label": "another"}, headers={"If-Match": "*"})
        assert edit.status_code == status, edit.text
        assert api.get("/jobs/other").status_code == 404
    assert over(api, "kit")["outcome"] == "succeeded"
    assert not [one for one in api.get("/alarms").json()["items"] if one["kind"] == "disk" and one["active"]]
    api.put("/jobs/other", json={**STARTER, **LATER}).raise_for_status()
    assert "Traceback" not in server.said, server.said


def test_a_full_disk_holds_the_job_until_there_is_room(small_disk: Path) -> None:
    data = small_disk / "cell"
    with ServerProcess("kitting", "--fake", "--pace", "3", data=data) as server, server.client() as client:
        held_and_resumed(server, client.http, filled(small_disk), 507)
        before = client.http.get("/world").json()
        assert server.end() == 0
    with ServerProcess("--fake", data=data) as server, server.client() as client:
        assert job_of(client.http, "kit")["outcome"] == "succeeded"
        assert client.http.get("/world").json()["version"] >= before["version"]


def test_a_disk_that_refuses_every_write_holds_the_job_until_it_works_again(tmp_path: Path) -> None:
    with ServerProcess("kitting", "--fake", "--pace", "3", data=tmp_path) as server, server.client() as client:
        held_and_resumed(server, client.http, refused(server), 503)
        assert server.end() == 0


def test_a_server_killed_on_a_full_disk_holds_the_job_at_its_next_start(small_disk: Path) -> None:
    data = small_disk / "cell"
    with ServerProcess("kitting", "--fake", "--pace", "3", data=data) as server, server.client() as client:
        client.http.put("/jobs/kit", json=STARTER).raise_for_status()
        until(lambda: moves(client.http, "kit"))
        with filled(small_disk):
            until(lambda: suspended(client.http))
            server.kill()
    with ServerProcess("--fake", data=data) as server, server.client() as client:
        job = job_of(client.http, "kit")
        assert job["state"]["substates"] == ["Held"]
        assert job["choices"]


@needs(MKFS, "mkfs.ext2 is not installed")
def test_a_disk_that_becomes_read_only_holds_the_job_and_loses_nothing(device: Path, small_disk: Path) -> None:
    """The kernel keeps it read-only until it is mounted again, for which the server has to end."""
    data = device / "cell"
    with ServerProcess("kitting", "--fake", "--pace", "3", data=data) as server, server.client() as client:
        api = client.http
        api.put("/jobs/kit", json=STARTER).raise_for_status()
        until(lambda: moves(api, "kit"))
        make_read_only(device)
        until(lambda: suspended(api))
        assert api.put("/jobs/other", json={**STARTER, **LATER}).status_code in (503, 507)
        assert api.get("/elements").status_code == 200
        assert "Traceback" not in server.said, server.said
        server.kill()
    subprocess.run(["umount", str(device)], check=True)
    subprocess.run(["mount", "-o", "loop", str(small_disk / "image"), str(device)], check=True)
    assert {one.file for one in check_data(data) if not one.file.startswith("recordings/")} == set()  # not synced
    with ServerProcess("--fake", data=data) as server, server.client() as client:
        assert job_of(client.http, "kit")["state"]["substates"] == ["Held"]
        assert client.http.get("/jobs/other").status_code == 404


@needs(MKFS, "mkfs.ext2 is not installed")
def test_a_disk_that_fails_once_loses_nothing(device: Path, small_disk: Path) -> None:
    """The device fails to write (EIO or ENOSPC): the disk below it has no room for its blocks."""
    data = device / "cell"
    with ServerProcess("kitting", "--fake", "--pace", "3", data=data) as server, server.client() as client:
        api = client.http
        api.put("/jobs/kit", json=STARTER).raise_for_status()
        until(lambda: moves(api, "kit"))
        with filled(small_disk):
            until(lambda: suspended(api))
            (alarm,) = [one for one in api.get("/alarms").json()["items"] if one["kind"] == "disk"]
            assert "the disk cannot be written" in alarm["text"]
        assert over(api, "kit")["outcome"] == "succeeded"
        before = api.get("/world").json()["version"]
        server.kill()
    assert list(check_data(data)) == []
    with ServerProcess("--fake", data=data) as server, server.client() as client:
        assert job_of(client.http, "kit")["outcome"] == "succeeded"
        assert client.http.get("/world").json()["version"] >= before
