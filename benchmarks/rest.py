"""The REST API under load: a real server, called from a second process.

    uv run python benchmarks/rest.py
    uv run python benchmarks/rest.py --seconds 10 --only orders

Orders and bare answers are compared with those of a plain FastAPI application (``rest_peer.py``), in turns.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from statistics import median

from rest_server import Server, running, running_peer
from rest_settings import JOB, SCENE
from table import Figure, finish

_ROUNDS = 3
_FLIGHT, _FLOOD = 64, 400
"""Orders at a time: fewer and more than the server lets wait."""
_PLACES = 100
"""Number of orders that the server lets wait."""
_LOADS = {
    "no load": "without load",
    "half-open": "beside 1,300 half-open connections",
    "slow": "beside 200 readers that never read",
    "orders": "in a flood of orders",
}
_TIMES = 1.2
"""Maximum ratio of memory after 10,000 jobs and 100,000 events to that after 1,000 jobs."""


def main() -> int:
    """Measures."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=float, default=60.0, help="for how long orders come in, to each of both")
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
        with _data() as data, running(SCENE, Path(data), "--pace", "real") as server, running_peer(Path(data)) as peer:
            if busy:
                server.order(JOB)
                server.wait_for_start(JOB)
                figures += _compared(server, peer, options.seconds / _ROUNDS, "while a kitting job runs")
                state = server.job(JOB)["state"]["text"]
                figures.append(Figure("state of that job", state, "Running, Ended", state in ("Running", "Ended")))
            else:
                figures += _compared(server, peer, options.seconds / _ROUNDS, "idle")
    return figures


def _compared(server: Server, peer: Server, seconds: float, words: str) -> list[Figure]:
    """Loads both in turns, then the server with more orders at a time than it accepts."""
    turns = [
        (_load("orders", server, seconds, _FLIGHT), _load("orders", peer, seconds, _FLIGHT)) for _ in range(_ROUNDS)
    ]
    flood = _load("orders", server, seconds, _FLOOD)
    ours, theirs = ({name: median(turn[which][name] for turn in turns) for name in turns[0][0]} for which in (0, 1))
    rate, bare = ours["rate"] / theirs["rate"], ours["bare"] / theirs["bare"]
    patience = _PLACES / flood["rate"] * 1e3
    wrong = sum(turn[0]["wrong"] for turn in turns) + flood["wrong"]
    return [
        Figure(
            f"orders accepted, {words}, {_FLIGHT} at a time",
            f"{ours['rate']:.0f} /s",
            ">= 0.5 x",
            rate >= 0.5,
            f"plain FastAPI {theirs['rate']:.0f} /s: {rate:.2f} x; processor time {ours['cpu']:.1f} and"
            f" {theirs['cpu']:.1f} ms each",
        ),
        Figure(
            f"bare answer, {words}",
            f"{ours['bare']:.1f} ms",
            "<= 1.5 x",
            bare <= 1.5,
            f"plain FastAPI {theirs['bare']:.1f} ms: {bare:.2f} x",
        ),
        Figure(
            f"order accepted among {_FLOOD} at a time, {words}, p99",
            f"{flood['p99']:.0f} ms",
            "<= 2 x",
            flood["p99"] <= 2 * patience and flood["refused"] > 0,
            f"{_PLACES} orders at the rate of {flood['rate']:.0f} /s take {patience:.0f} ms;"
            f" {flood['refused']:.0f} refused with 429 in {flood['refusal']:.0f} ms",
        ),
        Figure(f"orders lost or doubled, {words}", f"{wrong:.0f}", "0", wrong == 0, "every tenth sent twice"),
    ]


def _stops(_options: argparse.Namespace) -> list[Figure]:
    figures = []
    for load in ("no load", "half-open", "slow", "orders"):
        with _data() as data:
            with running_peer(Path(data)) as peer:
                plain = _stopped(peer, load)
            with running(SCENE, Path(data), "--pace", "real") as server:
                said = _stopped(server, load)
        figures.append(
            Figure(
                f"stop answered, {_LOADS[load]}, worst of 30",
                f"{said['worst']:.0f} ms",
                "<= 200 ms",
                said["worst"] <= 200.0,
                f"median {said['median']:.1f} ms; an answer of plain FastAPI in the same load: worst"
                f" {plain['worst']:.0f} ms, median {plain['median']:.1f} ms",
            )
        )
    return figures


def _stopped(server: Server, load: str) -> dict[str, float]:
    flood = _start("orders", server, 3600.0, _FLOOD) if load == "orders" else None
    try:
        time.sleep(5.0 if flood else 0.0)
        return _load("stops", server, load)
    finally:
        if flood is not None:
            flood.kill()
            flood.communicate()


def _events(_options: argparse.Namespace) -> list[Figure]:
    figures = []
    for busy in (False, True):
        with _data() as data, running(SCENE, Path(data), "--pace", "real") as server:
            if busy:
                server.order(JOB)
                server.wait_for_start(JOB)
            said = _load("events", server, 10)
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


def _load(part: str, server: Server, *arguments: object) -> dict[str, float]:
    """Runs the load in a second process, and returns its measurements.

    Raises:
        RuntimeError: It failed; the text is what it said.
    """
    process = _start(part, server, *arguments)
    answer, error = process.communicate()
    if process.returncode:
        raise RuntimeError(f"the load '{part}' ended with {process.returncode}:\n{error}")
    said: dict[str, float] = json.loads(answer.splitlines()[-1])
    return said


def _start(part: str, server: Server, *arguments: object) -> subprocess.Popen[str]:
    script = str(Path(__file__).with_name("rest_load.py"))
    command = [sys.executable, script, part, server.url, str(server.pid), *map(str, arguments)]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


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
        few = _load("jobs", server, 0, options.jobs // 10)
        many = _load("jobs", server, options.jobs // 10, options.jobs)
        events = _load("changes", server, 10 * options.jobs)
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
    "stops": _stops,
    "same-job": _same_job,
    "memory": _memory,
}

if __name__ == "__main__":
    raise SystemExit(main())
