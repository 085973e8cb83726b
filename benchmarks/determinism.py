"""Runs the same seed twice, once alone and once beside busy processes, and compares the digests.

    uv run python benchmarks/determinism.py

The digest is a hash over joint and body states (10 Hz) and all changes of the world model.
"""

from __future__ import annotations

import argparse
import json
import multiprocessing
import subprocess
import sys

from table import Figure, finish


def main() -> int:
    """Compares."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seed", type=int, default=7)
    parser.add_argument("--hogs", type=int, default=multiprocessing.cpu_count(), help="busy processes beside")
    options = parser.parse_args()
    alone = _digest(options.seed)
    hogs = [multiprocessing.Process(target=_spin, daemon=True) for _ in range(options.hogs)]
    for hog in hogs:
        hog.start()
    beside = _digest(options.seed)
    for hog in hogs:
        hog.kill()
        hog.join()
    other = _digest(options.seed + 1)
    return finish(
        "determinism",
        [
            Figure(f"digest of seed {options.seed}, alone", alone),
            Figure(f"digest beside {options.hogs} busy processes", beside, "the same", beside == alone, alone),
            Figure("digest of another seed", other, "another", other != alone, alone),
        ],
    )


def _digest(seed: int) -> str:
    command = [sys.executable, "-m", "skiros_py.cli", "run", "kitting", "--seed", str(seed), "--json"]
    done = subprocess.run(command, capture_output=True, text=True, check=False, stdin=subprocess.DEVNULL)
    run = json.loads(done.stdout)
    if not run.get("reached"):
        raise SystemExit(f"seed {seed} did not reach its goal: {run}")
    return str(run["digest"])


def _spin() -> None:
    while True:
        pass


if __name__ == "__main__":
    sys.exit(main())
