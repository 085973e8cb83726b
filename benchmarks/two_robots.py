"""Two robots compared with one, in physics: makespan for the same goal, and contacts between the robots.

    uv run python benchmarks/two_robots.py

The kit has two docking places. Makespans are simulated time until the last condition of the goal holds, judged by the
simulator's truth; the bar is for four parts, eight parts in two kits are reported.
"""

from __future__ import annotations

import argparse
import math
import statistics
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass

import psutil
from table import Figure, finish

from skiros_py.simulation.truth import Truth
from skiros_py.skills.outcome import Failure
from skiros_py.station.session import Options, Session

_SCENE = "kitting_two"
_RATIO = 0.65
_PARTS = ("starter", "alternator", "compressor", "relay_box")
_EVERY = 5  # cycles between two looks at what touches what


@dataclass(frozen=True, slots=True)
class _Run:
    """Results of one run: simulated and wall time [s], memory of all processes [MB], contacts between robots."""

    reached: bool
    makespan: float
    wall: float
    memory: float
    touches: tuple[str, ...]


def main() -> int:
    """Measures."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=3, help="number of runs of each kind")
    parser.add_argument("--first", type=int, default=0, help="first seed")
    options = parser.parse_args()
    seeds = range(options.first, options.first + options.seeds)
    figures = [figure for kits in (1, 2) for figure in _figures(seeds, kits)]
    return finish("two robots", figures)


def _figures(seeds: Sequence[int], kits: int) -> list[Figure]:
    parts, goal = 4 * kits, _goal(kits)
    two = [_run(goal, seed, None) for seed in seeds]
    one = [_run(goal, seed, "robot_1") for seed in seeds]
    by_hand = [_by_hand(kits, seed) for seed in seeds]
    best = min(_median(one), statistics.median(by_hand))
    ratio = _median(two) / best
    every = f"{len(two)} of {len(two)}"
    reached = sum(run.reached for run in two)
    touches = sorted({touch for run in two for touch in run.touches})
    alone = f"one robot: {_median(one):.0f} s, in the best order by hand {statistics.median(by_hand):.0f} s"
    barred = kits == 1
    return [
        Figure(f"{parts} parts, goal reached by the truth", f"{reached} of {len(two)}", every, reached == len(two)),
        Figure(f"{parts} parts, robots touch", ", ".join(touches) or "never", "never", not touches),
        Figure(
            f"{parts} parts, makespan of two robots, simulated",
            f"median {_median(two):.0f} s, {ratio:.2f} of one robot's best",
            f"<= {_RATIO:.2f}" if barred else "",
            ratio <= _RATIO or not barred,
            alone,
        ),
        Figure(
            f"{parts} parts, simulated per wall second",
            f"{sum(r.makespan for r in two) / sum(r.wall for r in two):.1f}",
            compared=f"one robot: {sum(r.makespan for r in one) / sum(r.wall for r in one):.1f}",
        ),
        Figure(
            f"{parts} parts, memory of all processes",
            f"{max(r.memory for r in two):.0f} MB",
            compared=f"one robot: {max(r.memory for r in one):.0f} MB",
        ),
    ]


def _goal(kits: int) -> list[str]:
    numbers = range(1, kits + 1)
    return [
        f"ObjectAtLocation({part}_{n}, kit_{n}_{c})" for n in numbers for part, c in zip(_PARTS, "abcd", strict=True)
    ]


def _run(goal: Sequence[str], seed: int, robot: str | None) -> _Run:
    with Session(_SCENE, Options(seed=seed, robot=robot)) as session:
        truth = Truth(session.simulation)
        robots = {spec.id for spec in session.spec.robots}

        def look() -> None:
            if session.cycle.board.snapshot.cycle % _EVERY == 0:
                truth.watch()

        session.cycle.observe(look)
        begin = time.perf_counter()
        report = session.run(list(goal))
        wall = time.perf_counter() - begin
        touches = tuple(f"{link} - {body}" for link, body in truth.worst if body in robots)
        run = _Run(report.reached, session.cycle.board.snapshot.time, wall, _memory(), touches)
    who = robot or "both robots"
    print(f"{len(goal)} parts, {who}, seed {seed}: {run.makespan:.0f} s", file=sys.stderr, flush=True)
    return run


def _by_hand(kits: int, seed: int) -> float:
    """Returns the makespan of one robot that always takes the shortest way [s]: planners know no distances."""
    sides = {"starter": "north", "alternator": "north", "compressor": "south", "relay_box": "south"}
    with Session(_SCENE, Options(seed=seed, robot="robot_1")) as session:
        for n in range(1, kits + 1):
            for (part, side), compartment in zip(sides.items(), "abcd", strict=True):
                pallet = {"north": "ab", "south": "cd"}[side][n - 1]
                place = {"Object": f"{part}_{n}", "Compartment": f"kit_{n}_{compartment}"}
                session.run_module("drive", {"Location": f"pallet_{pallet}"}, "base_1")
                session.run_module("pick", {"Object": f"{part}_{n}"}, "arm_1")
                session.run_module("drive", {"Location": f"kit_{n}_{side}"}, "base_1")
                if isinstance(session.run_module("place", place, "arm_1"), Failure):
                    return math.inf
        return session.cycle.board.snapshot.time


def _memory() -> float:
    """Returns the private memory of this process and its children [MB]."""
    own = psutil.Process()
    return sum(process.memory_full_info().uss for process in (own, *own.children(recursive=True))) / 1e6


def _median(runs: Sequence[_Run]) -> float:
    return statistics.median(run.makespan for run in runs)


if __name__ == "__main__":
    sys.exit(main())
