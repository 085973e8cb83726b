"""A real server process for the REST benchmark, and the benchmark's own requests."""

from __future__ import annotations

import contextlib
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import httpx2

_PATIENCE = 120.0


@dataclass(frozen=True, slots=True)
class Server:
    """A running server.

    Attributes:
        url: Address of its API.
        pid: Its process.
    """

    url: str
    pid: int

    def order(self, job: str) -> None:
        """Orders the goal of its scene."""
        goals = httpx2.get(f"{self.url}/goals", timeout=30.0).raise_for_status().json()
        body = {"goal": " and ".join(goals["goals"])}
        httpx2.put(f"{self.url}/jobs/{job}", json=body, timeout=30.0).raise_for_status()

    def job(self, job: str) -> dict[str, Any]:
        """Returns the present state of a job."""
        found: dict[str, Any] = httpx2.get(f"{self.url}/jobs/{job}", timeout=30.0).raise_for_status().json()
        return found

    def wait_for_start(self, job: str) -> None:
        """Waits until the job has a plan and runs."""
        deadline = time.monotonic() + _PATIENCE
        while not self.job(job)["plan"]:
            if time.monotonic() > deadline:
                raise TimeoutError("the job does not start")
            time.sleep(0.1)

    def wait_for_end(self, job: str) -> float:
        """Returns the time from dispatch to end of the job [s of run time].

        Raises:
            Halted: Everything was halted, so that it would never end.
            ValueError: It did not succeed.
        """
        with httpx2.Client(timeout=None) as client:
            while self.job(job)["state"]["text"] not in ("Ended", "Aborted"):
                stop = client.get(f"{self.url}/stop").raise_for_status().json()
                if stop["halted"]:
                    raise Halted(stop["why"])
                time.sleep(0.2)
            trace = client.get(f"{self.url}/jobs/{job}/trace").raise_for_status().json()["items"]
            outcome = self.job(job)["outcome"]
            if outcome != "succeeded":
                raise ValueError(f"the job ended otherwise: {outcome}")
            return float(trace[-1]["time"]) - float(trace[0]["time"])


class Halted(RuntimeError):
    """Everything was halted, for example by the watchdog on an overloaded machine."""


@contextlib.contextmanager
def running(scene: str, data: Path, *options: str) -> Iterator[Server]:
    """Runs ``skiros serve`` in a separate process during the block."""
    command = [sys.executable, "-m", "skiros_py.cli", "serve", scene, "--data", str(data), "--port", "0", *options]
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as process:
        try:
            yield Server(f"{_address(data, process)}/api/v1", process.pid)
        finally:
            process.send_signal(signal.SIGTERM)
            try:
                process.wait(30.0)
            except subprocess.TimeoutExpired:
                process.kill()


@contextlib.contextmanager
def running_peer(folder: Path) -> Iterator[Server]:
    """Runs the application that the server is compared with."""
    with closing(socket.create_server(("127.0.0.1", 0))) as free:
        port = free.getsockname()[1]
    script = Path(__file__).with_name("rest_peer.py")
    url = f"http://127.0.0.1:{port}/api/v1"
    with subprocess.Popen([sys.executable, str(script), str(folder / "peer.db"), str(port)]) as process:
        try:
            deadline = time.monotonic() + _PATIENCE
            while True:
                with contextlib.suppress(httpx2.ConnectError):
                    httpx2.get(f"{url}/jobs").raise_for_status()
                    break
                if time.monotonic() > deadline:
                    raise TimeoutError("the compared application does not listen")
                time.sleep(0.1)
            yield Server(url, process.pid)
        finally:
            process.kill()


def _address(data: Path, process: subprocess.Popen[bytes]) -> str:
    from skiros_py.api.server import SERVER_FILE, LocalServer

    deadline = time.monotonic() + _PATIENCE
    while time.monotonic() < deadline and process.poll() is None:
        with contextlib.suppress(OSError, ValueError):
            return LocalServer.model_validate_json((data / SERVER_FILE).read_text(encoding="utf-8")).url
        time.sleep(0.1)
    raise TimeoutError("the server does not listen")
