"""Kitting over many seeds: success rate, agreement of belief and truth, and durations.

    uv run python benchmarks/kitting.py --seeds 50

Each seed is a fresh ``skiros run`` in a separate process, with newly drawn part poses; the bars are those of the
project. Every failed attempt is listed with its reason. ``--simulation`` names an engine, and twice compares two, seed
by seed.
"""

from __future__ import annotations

import argparse
import json
import math
import statistics
import subprocess
import sys
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from typing import Any

from table import Figure, finish, finish_side_by_side

from skiros_py.system import default_simulation


def main() -> int:
    """Runs the campaign."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=50, help="number of runs")
    parser.add_argument("--first", type=int, default=0, help="first seed")
    parser.add_argument("--scene", default="kitting")
    parser.add_argument("--jobs", type=int, default=2, help="runs at a time; figures are of simulated time")
    parser.add_argument("--simulation", action="append", help="engine that simulates; twice for two engines")
    options = parser.parse_args()
    engines = options.simulation or [default_simulation()]
    seeds = range(options.first, options.first + options.seeds)
    wanted = [(seed, engine) for seed in seeds for engine in engines]
    with ThreadPoolExecutor(options.jobs) as pool:
        runs = dict(zip(wanted, pool.map(lambda one: _run(options.scene, *one), wanted), strict=True))
    failures = [f"{engine}, {line}" for (seed, engine), run in runs.items() for line in _failures(seed, run)]
    print("failed tries:" if failures else "no try failed")
    for line in failures:
        print(f"  {line}")
    measured = {name: _figures([run for (_, engine), run in runs.items() if engine == name]) for name in engines}
    title = f"kitting, {len(seeds)} seeds"
    return finish_side_by_side(title, measured) if len(engines) > 1 else finish(title, measured[engines[0]])


def _run(scene: str, seed: int, engine: str) -> dict[str, Any]:
    command = [sys.executable, "-m", "skiros_py.cli", "run", scene, "--seed", str(seed), "--simulation", engine]
    done = subprocess.run([*command, "--json"], capture_output=True, text=True, check=False, stdin=subprocess.DEVNULL)
    try:
        run: dict[str, Any] = json.loads(done.stdout)
    except json.JSONDecodeError:
        run = {"error": (done.stderr or done.stdout).strip()[-500:]}
    print(f"seed {seed}, {engine}: {'reached' if run.get('reached') else 'NOT reached'}", file=sys.stderr, flush=True)
    return run


def _failures(seed: int, run: dict[str, Any]) -> list[str]:
    if "error" in run:
        return [f"seed {seed}: {run['error']}"]
    lines = [f"seed {seed}: {s['skill']} at {s['start']:.1f} s: {s['reason']}" for s in run["steps"] if s["reason"]]
    lines += [f"seed {seed}: {c['condition']} missing by the truth" for c in run["conditions"] if not c["true"]]
    wrong = [c for c in run["conditions"] if c["true"] != c["believed"]]
    return lines + [f"seed {seed}: {c['condition']} believed {c['believed']}, truth {c['true']}" for c in wrong]


def _figures(runs: list[dict[str, Any]]) -> list[Figure]:
    good = [run for run in runs if "error" not in run]
    reached = sum(run["reached"] for run in good)
    conditions = [c for run in good for c in run["conditions"]]
    equal = sum(c["true"] == c["believed"] for c in conditions)
    all_conditions = len(conditions) + (len(runs) - len(good)) * 3
    first = _first_tries(good)
    share = sum(first) / max(1, len(first))
    cycle = _cycle_times(good)
    every = f"{len(runs)} of {len(runs)}"
    return [
        Figure("goal reached by the truth", f"{reached} of {len(runs)}", every, reached == len(runs)),
        Figure("picks right at the first try", f"{share:.1%} of {len(first)}", ">= 95 %", share >= 0.95),
        Figure("belief equals truth, conditions", f"{equal} of {all_conditions}", "all", equal == all_conditions),
        Figure(
            "pick + place of one part, simulated",
            f"median {_median(cycle):.1f} s, max {max(cycle, default=math.nan):.1f} s",
            "median <= 22 s",
            _median(cycle) <= 22.0,
            "40 to 50 s for the pick alone in the SkiROS chapter",
        ),
        Figure("whole run, simulated", f"median {_median(r['simulated'] for r in good):.0f} s"),
        Figure("whole run, wall", f"median {_median(r['wall'] for r in good):.0f} s"),
    ]


def _median(values: Iterable[float]) -> float:
    return statistics.median([*values] or [math.nan])


def _first_tries(runs: list[dict[str, Any]]) -> list[bool]:
    """Returns for each part to be picked whether the first pick succeeded."""
    result = []
    for run in runs:
        seen: set[str] = set()
        for step in run["steps"]:
            part = step["arguments"].get("Object")
            if step["skill"] == "pick" and part not in seen:
                seen.add(part)
                result.append(not step["reason"])
    return result


def _cycle_times(runs: list[dict[str, Any]]) -> list[float]:
    """Returns for each placed part the simulated time of its picks and places, without driving [s]."""
    times: list[float] = []
    for run in runs:
        by_part: dict[str, float] = {}
        for step in run["steps"]:
            part = step["arguments"].get("Object")
            if part is not None:
                by_part[part] = by_part.get(part, 0.0) + step["end"] - step["start"]
        times += by_part.values()
    return times


if __name__ == "__main__":
    sys.exit(main())
