"""Kills a process that writes to a world, repeatedly, and checks that every acknowledged change is kept.

    uv run python benchmarks/world_crash.py [--rounds 500] [--seed 0]

Each round a process writes to the same data directory (elements, moves, removals, learned concepts, goals, compaction)
until it is killed with SIGKILL at a random moment; then everything is compared with a naive model.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from pathlib import Path

from table import Figure, finish
from world_crash_rounds import run


def main() -> int:
    """Measures."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=500)
    parser.add_argument("--seed", type=int, default=0)
    arguments = parser.parse_args()
    started = time.perf_counter()
    with tempfile.TemporaryDirectory() as folder:
        outcome = run(arguments.rounds, Path(folder), arguments.seed)
    for fault in outcome.faults:
        print(fault)
    faults = len(outcome.faults)
    return finish(
        "world crash",
        [
            Figure("processes killed", f"{outcome.rounds}, in {time.perf_counter() - started:.0f} s"),
            Figure("changes acknowledged before", f"{outcome.acknowledged:,}", "> 0", outcome.acknowledged > 0),
            Figure("changes kept without acknowledgement", f"{outcome.unacknowledged:,}"),
            Figure("compactions done", f"{outcome.compactions:,}", "> 0", outcome.compactions > 0),
            Figure("lost, half, doubled or wrong", f"{faults}", "0", faults == 0),
        ],
    )


if __name__ == "__main__":
    sys.exit(main())
