"""The REST API under load: a real server, called from a second process.

    uv run python benchmarks/rest.py
    uv run python benchmarks/rest.py --seconds 10 --only orders

Latencies of orders are measured from the time at which each was due, not from its sending, so that a stalling server is
charged for the orders that had to wait.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

from rest_server import Server, running
from rest_settings import JOB, SCENE
from table import Figure, finish

_TIMES = 1.2
"""Maximum ratio of memory after 10,000 jobs and 100,000 events to that after 1,000 jobs."""


def main() -> int:
    """Measures."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=float, default=60.0, help="for how long orders come in")
    parser.add_argument("--jobs", type=int, default=10_000, help="finished jobs for the figure of memory")
    parser.add_argument("--pace", type=float, default=2.0, help="pace of the job that goes by two doors")
    parser.add_argument("--only", choices=sorted(_PARTS), help="one part of it")
    options = parser.parse_args()
    parts = [options.only] if options.only else list(_PARTS)
    return finish("rest", [figure for part in parts for figure in _PARTS[part](options)])


# ---------------------------------------------------------------------- orders and events


def _orders(options: argparse.Namespace) -> list[Figure]:
    figures = []
    for busy in (False, True):
        with _data() as data, running(SCENE, Path(data), "--pace", "real") as server:
            if busy:
                server.order(JOB)
                server.wait_for_start(JOB)
            said = _load("orders", server, str(options.seconds))
            state = server.job(JOB)["state"]["text"] if busy else ""
        words = "while a kitting job runs" if busy else "idle"
        bar = 100.0 if busy else 25.0
        figures += [
            Figure(
                f"order accepted, {words}, p99 of {said['sent']}",
                f"{said['p99']:.1f} ms",
                f"<= {bar:.0f} ms",
                said["p99"] <= bar,
                f"median {said['median']:.1f} ms, worst {said['worst']:.1f} ms, a bare answer {said['bare']:.1f} ms",
            ),
            Figure(
                f"orders lost or doubled, {words}",
                str(said["wrong"]),
                "0",
                said["wrong"] == 0 and state in ("", "Running", "Ended"),
                f"{said['rate']:.0f} orders/s, every tenth sent twice" + (f"; the job: {state}" if state else ""),
            ),
        ]
    return figures


def _events(_options: argparse.Namespace) -> list[Figure]:
    figures = []
    for busy in (False, True):
        with _data() as data, running(SCENE, Path(data), "--pace", "real") as server:
            if busy:
                server.order(JOB)
                server.wait_for_start(JOB)
            said = _load("events", server, "10")
        words = "while a kitting job runs" if busy else "idle"
        figures += [
            Figure(
                f"event from the kernel to 50 clients, {words}, p99",
                f"{said['p99']:.1f} ms",
                "<= 100 ms",
                said["p99"] <= 100.0 and said["missing"] == 0,
                f"median {said['median']:.1f} ms, {said['events']} events each, {said['missing']} missing",
            ),
            Figure(
                f"the same beside 20 clients that never read, {words}",
                f"{said['p99_stuck']:.1f} ms",
                "<= 100 ms",
                said["p99_stuck"] <= 100.0 and said["memory"] <= _TIMES,
                f"memory {said['memory']:.2f} x",
            ),
        ]
    return figures


def _load(part: str, server: Server, *arguments: str) -> dict[str, float]:
    """Runs the load in a second process, and returns its measurements."""
    command = [sys.executable, str(Path(__file__).with_name("rest_load.py")), part, server.url, str(server.pid)]
    done = subprocess.run([*command, *arguments], check=True, capture_output=True, text=True)
    said: dict[str, float] = json.loads(done.stdout.splitlines()[-1])
    return said


# ---------------------------------------------------------------------- the same job by two doors


def _same_job(options: argparse.Namespace) -> list[Figure]:
    by_command = json.loads(
        subprocess.run(
            [sys.executable, "-m", "skiros_py.cli", "run", SCENE, "--pace", str(options.pace), "--json"],
            check=True,
            capture_output=True,
            text=True,
        ).stdout
    )["simulated"]
    with _data() as data, running(SCENE, Path(data), "--pace", str(options.pace)) as server:
        server.order(JOB)
        by_rest = server.wait_for_end(JOB)
    ratio = by_rest / by_command
    return [
        Figure(
            f"the kitting job through REST, at {options.pace:g} times real time",
            f"{by_rest:.1f} s simulated",
            "<= 1.05 x",
            ratio <= 1.05,
            f"{by_command:.1f} s by skiros run: {ratio:.3f} x",
        )
    ]


# ---------------------------------------------------------------------- memory


def _memory(options: argparse.Namespace) -> list[Figure]:
    with _data() as data, running(SCENE, Path(data), "--fake", "--pace", "max") as server:
        few = _load("jobs", server, "0", str(options.jobs // 10))
        many = _load("jobs", server, str(options.jobs // 10), str(options.jobs))
        events = _load("changes", server, str(10 * options.jobs))
    ratio = max(many["memory"], events["memory"]) / few["memory"]
    return [
        Figure(
            f"memory after {options.jobs} finished jobs and {events['events']:.0f} events",
            f"{max(many['memory'], events['memory']):.0f} MiB",
            f"<= {_TIMES} x",
            ratio <= _TIMES,
            f"{few['memory']:.0f} MiB after {options.jobs // 10} jobs: {ratio:.2f} x",
        )
    ]


def _data() -> tempfile.TemporaryDirectory[str]:
    return tempfile.TemporaryDirectory(prefix="skiros-bench-")


_PARTS: dict[str, Callable[[argparse.Namespace], list[Figure]]] = {
    "orders": _orders,
    "events": _events,
    "same-job": _same_job,
    "memory": _memory,
}

if __name__ == "__main__":
    raise SystemExit(main())
