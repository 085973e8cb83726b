"""From world model to validated plan, against the bare planner on the same files.

    uv run python benchmarks/planning.py

Both are timed in turn in the same run; the ratio of the medians decides.
"""

from __future__ import annotations

import argparse
import os
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from table import Figure, finish

from skiros_py.planning.fast_downward import FastDownward
from skiros_py.planning.plan import NoPlan
from skiros_py.runtime import Options, Session


def main() -> int:
    """Measures."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--pairs", type=int, default=15, help="how often each is timed")
    pairs = parser.parse_args().pairs
    ours, bare = [], []
    with Session("kitting", Options(fake=True)) as session, tempfile.TemporaryDirectory() as folder:
        planned = session.plan()
        if isinstance(planned.outcome, NoPlan) or planned.texts is None:
            raise SystemExit(f"no plan: {planned.outcome}")
        for name, text in (("domain.pddl", planned.texts.domain), ("problem.pddl", planned.texts.problem)):
            (Path(folder) / name).write_text(text, encoding="utf-8")
        for _ in range(pairs):
            started = time.perf_counter()
            session.plan()
            ours.append(time.perf_counter() - started)
            bare.append(_bare(folder))
    ratio = statistics.median(ours) / statistics.median(bare)
    return finish("planning", _figures(ours, bare, ratio, len(planned.outcome.steps)))


def _figures(ours: list[float], bare: list[float], ratio: float, steps: int) -> list[Figure]:
    own, raw = statistics.median(ours) * 1e3, statistics.median(bare) * 1e3
    return [
        Figure("bare fast-downward.py, median", f"{raw:.0f} ms"),
        Figure("world model to validated plan, median", f"{own:.0f} ms, best {min(ours) * 1e3:.0f} ms, {steps} steps"),
        Figure("ratio", f"{ratio:.2f}", "<= 1.5", ratio <= 1.5, "bare fast-downward.py on the same files"),
    ]


def _bare(folder: str) -> float:
    """Runs the planner alone, as it would be typed, and returns the wall time [s]."""
    command = FastDownward().command("domain.pddl", "problem.pddl")
    started = time.perf_counter()
    subprocess.run(command, cwd=folder, stdout=subprocess.DEVNULL, check=True, env=dict(os.environ))
    return time.perf_counter() - started


if __name__ == "__main__":
    sys.exit(main())
