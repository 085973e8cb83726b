"""Wall time and memory of the default run, and the latency of help.

    uv run python benchmarks/startup.py

Times are the best of five; memory is the maximum total over all processes of a run.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import threading
import time

import psutil
from table import Figure, finish, in_steps


def main() -> int:
    """Measures."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--runs", type=int, default=5)
    runs = parser.parse_args().runs
    full = [_measure("run", "kitting") for _ in range(runs)]
    fake = [_measure("run", "kitting", "--fake") for _ in range(runs)]
    help_ = [_measure("--help") for _ in range(runs)]
    bare = [_measure_command([sys.executable, "-c", "pass"]) for _ in range(runs)]
    wall, memory = min(w for w, _ in full), max(m for _, m in full)
    quick, nothing = (min(w for w, _ in one) for one in (help_, bare))
    return finish(
        "start-up",
        [
            in_steps("skiros run kitting, wall", wall, 167e6),
            Figure("skiros run kitting, memory of all processes", f"{memory:.0f} MiB", "<= 2048 MiB", memory <= 2048.0),
            Figure("skiros run kitting --fake, wall", f"{min(w for w, _ in fake):.1f} s"),
            Figure(
                "skiros --help", f"{quick * 1e3:.0f} ms", "<= 10 x", quick <= 10.0 * nothing,
                f"{nothing * 1e3:.0f} ms for python -c pass",
            ),
        ],
    )  # fmt: skip


def _measure(*arguments: str) -> tuple[float, float]:
    return _measure_command([sys.executable, "-m", "skiros_py.cli", *arguments])


def _measure_command(command: list[str]) -> tuple[float, float]:
    """Returns wall time [s] and the maximum total resident memory of the process and its children [MiB]."""
    started = time.perf_counter()
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, stdin=subprocess.DEVNULL)
    peak = [0.0]
    watcher = threading.Thread(target=_watch, args=(process, peak))
    watcher.start()
    status = process.wait()
    wall = time.perf_counter() - started
    watcher.join()
    if status != 0:
        raise SystemExit(f"{' '.join(command)} ended with {status}")
    return wall, peak[0]


def _watch(process: subprocess.Popen[bytes], peak: list[float]) -> None:
    while process.poll() is None:
        try:
            top = psutil.Process(process.pid)
            family = [top, *top.children(recursive=True)]
            total = sum(p.memory_info().rss for p in family) / 2**20
            peak[0] = max(peak[0], total)
        except psutil.Error:
            pass
        time.sleep(0.05)


if __name__ == "__main__":
    sys.exit(main())
