"""What the tests of the hard cases share: orders, waiting, slow and frozen planners."""

from __future__ import annotations

import os
import signal
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TypeVar

import httpx2
import psutil
from support.serving import Served

from skiros_py.station.session import Options

PATIENCE = 60.0
STARTER = {"goal": "InKit(Starter, kit_1)"}
HOLDS = {"goal": "EmptyHanded(gripper_1)"}
"""Nothing has to be done for it."""
LATER = {"not_before": "2100-01-01T00:00:00Z"}
ANYHOW = {"If-Match": "*"}
SLOWLY = Options(fake=True, pace=6.0, overrun=10.0)
"""A robot that pretends, and takes its time; a busy machine is no fault of a module here."""

_SLEEP = "import time; time.sleep(600)"

T = TypeVar("T")


@contextmanager
def api_of(served: Served, key: str = "") -> Iterator[httpx2.Client]:
    """Yields a plain client of a server's API."""
    headers = {"Authorization": f"Bearer {key}"} if key else {}
    hooks = {"request": [_mean_it]}
    with httpx2.Client(base_url=f"{served.url}/api/v1", headers=headers, event_hooks=hooks, timeout=PATIENCE) as api:
        yield api


def _mean_it(request: httpx2.Request) -> None:
    """Says of orders that they are meant: tests have a server in common, and order under the same ids."""
    path = request.url.path
    if (request.method == "PUT" and "/jobs/" in path) or (request.method == "POST" and path.endswith("/jobs")):
        request.url = request.url.copy_merge_params({"again": "true"})


def until(reached: Callable[[], T], patience: float = PATIENCE) -> T:
    """Waits until something is so, and returns it."""
    deadline = time.monotonic() + patience
    while not (value := reached()):
        assert time.monotonic() < deadline, "it was never reached"
        time.sleep(0.005)
    return value


def job_of(api: httpx2.Client, id_: str) -> dict[str, Any]:
    told: dict[str, Any] = api.get(f"/jobs/{id_}").raise_for_status().json()
    return told


def over(api: httpx2.Client, id_: str) -> dict[str, Any]:
    """Waits until a job is over, and returns it."""
    return until(lambda: job if (job := job_of(api, id_))["outcome"] else None)


def happened(api: httpx2.Client, id_: str) -> list[str]:
    """Returns what happened for a job, in one word each."""
    return [one["what"] for one in api.get(f"/jobs/{id_}/trace", params={"limit": 1000}).json()["items"]]


def steps(api: httpx2.Client, id_: str) -> list[str]:
    """Returns the skills that were begun for a job."""
    response = api.get(f"/jobs/{id_}/response").raise_for_status().json()
    return [step["skill"] for step in response["job_response_data"]]


def moves(api: httpx2.Client, id_: str) -> bool:
    """Tells whether something moves for a job at this moment."""
    response = api.get(f"/jobs/{id_}/response").raise_for_status().json()
    return any(step["ended"] is None for step in response["job_response_data"])


def cycles(api: httpx2.Client, many: int = 20) -> None:
    """Waits until the control cycle has come round some more times."""
    before = api.get("/state").json()["cycle"]
    until(lambda: api.get("/state").json()["cycle"] >= before + many)


def begin_anew(api: httpx2.Client) -> None:
    """Ends and removes all jobs, and puts the scene back."""
    api.post("/reset").raise_for_status()
    for job in (jobs := api.get("/jobs", params={"limit": 1000}).json()["items"]):
        api.post(f"/jobs/{job['id']}/abort")
    for job in jobs:
        over(api, job["id"])
        api.delete(f"/jobs/{job['id']}").raise_for_status()
    until(lambda: api.put("/scene", json={"name": "kitting"}, headers=ANYHOW).status_code == 200)


# ---------------------------------------------------------------------- planners


class HeldPlanner:
    """A planner that holds its answer back while a file is there, with a child that does nothing.

    Args:
        folder: Where to put its files.

    Attributes:
        command: Command line, for ``planner_command``.
    """

    def __init__(self, folder: Path) -> None:
        self._hold = folder / "hold"
        script = folder / "held_planner.py"
        script.write_text(
            "import os, subprocess, sys, time\n"
            f"hold = {str(self._hold)!r}\n"
            f"if os.path.exists(hold): subprocess.Popen([sys.executable, '-S', '-c', {_SLEEP!r}, {str(folder)!r}])\n"
            "while os.path.exists(hold): time.sleep(0.01)\n"
            f"kairos = {str(Path(sys.executable).with_name('kairos'))!r}\n"
            "os.execv(kairos, ['kairos', sys.argv[1], sys.argv[2], '--no-anytime', '--output', sys.argv[3]])\n",
            encoding="utf-8",
        )
        self._folder = folder
        self.command = f"{sys.executable} -S {script} {{domain}} {{problem}} {{plan}}"
        self.hold()

    def hold(self) -> None:
        self._hold.touch()

    def let_go(self) -> None:
        self._hold.unlink(missing_ok=True)

    @property
    def processes(self) -> list[psutil.Process]:
        """Its processes that run: itself and its child."""
        return [one for one in psutil.process_iter() if self._is_ours(one)]

    def _is_ours(self, process: psutil.Process) -> bool:
        try:
            return (
                process.status() != psutil.STATUS_ZOMBIE
                and process.cmdline()[1:2] == ["-S"]
                and any(str(self._folder) in word for word in process.cmdline())
            )
        except psutil.Error:
            return False


def freeze_planner(parent: int) -> list[psutil.Process]:
    """Waits for Fast Downward below a process, stops it in its tracks, and returns all its processes."""

    def frozen() -> list[psutil.Process]:
        planners = [one for one in psutil.Process(parent).children(recursive=True) if _is_planner(one)]
        # Right after the fork it is still in the group of the resident program, which must go on.
        found = [one for one in planners if os.getpgid(one.pid) in {planner.pid for planner in planners}]
        for one in found:
            os.killpg(os.getpgid(one.pid), signal.SIGSTOP)
        return found

    return until(_unless_gone(frozen))


def _unless_gone(find: Callable[[], list[psutil.Process]]) -> Callable[[], list[psutil.Process]]:
    def found() -> list[psutil.Process]:
        try:
            return find()
        except (psutil.NoSuchProcess, ProcessLookupError):
            return []

    return found


def _is_planner(process: psutil.Process) -> bool:
    """Tells whether a process works at a plan; the resident program forks for each and works at none itself."""
    words, parent = " ".join(process.cmdline()), process.parent()
    above = " ".join(parent.cmdline()) if parent else ""
    resident = "resident_program" in words and "resident_program" not in above
    return not resident and ("fast_downward" in words or "/downward" in words)


def gone(processes: list[psutil.Process]) -> bool:
    """Tells whether all of some processes have ended."""
    return not any(map(_runs, processes))


def _runs(process: psutil.Process) -> bool:
    try:
        return process.is_running() and process.status() != psutil.STATUS_ZOMBIE
    except psutil.NoSuchProcess:
        return False
