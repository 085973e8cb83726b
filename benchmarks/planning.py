"""From world model to validated plan: compared with the bare planner on the same files, and in growing worlds.

    uv run python benchmarks/planning.py

Compared programs are timed in turn in the same run; the ratio of the medians decides.
"""

from __future__ import annotations

import argparse
import importlib
import importlib.util
import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

import planning_process
from agreement import disagreement
from planning_replan import replanning_times
from planning_worlds import PART_CLASSES, able, crowded, kitting_world
from random_tasks import random_task
from table import Figure, finish, in_steps

from skiros_py.planning.domain.pddl import write_pddl
from skiros_py.planning.plan import Plan
from skiros_py.planning.planners.fast_downward import FastDownward, driver_path
from skiros_py.planning.planners.kairos import OPTIONS, Kairos, program_path
from skiros_py.planning.planners.planner import Planner
from skiros_py.planning.problem.task import build_task
from skiros_py.planning.service import Planned, plan
from skiros_py.skills.conditions import Condition
from skiros_py.world.element import Placement, Value
from skiros_py.world.view import WorldView
from skiros_py.world.vocabulary import IN
from skiros_skills.conditions import OBJECT_AT_LOCATION

THREE = tuple(
    OBJECT_AT_LOCATION(class_, compartment)
    for class_, compartment in zip(PART_CLASSES, ("kit_1_a", "kit_1_b", "kit_1_c"), strict=False)
)
"""The goal of the scene ``kitting``."""


def main() -> int:
    """Measures."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--pairs", type=int, default=15, help="how often each is timed")
    parser.add_argument("--problems", type=int, default=500, help="random problems that are planned both ways")
    options = parser.parse_args()
    figures = [
        *_against_bare(options.pairs),
        *_many_robots(),
        *_crowded(options.pairs),
        *_written(options.pairs),
        *_learned(options.pairs),
        *_replanned(),
        *planning_process.figures(),
        *_agreeing(options.problems),
        *_threads(),
    ]
    return finish("planning", figures)


# ------------------------------------------------------------------ figures


def _against_bare(pairs: int) -> list[Figure]:
    """Three parts, one robot: Fast Downward and Kairos compared with the bare programs, warm and for the first plan."""
    world = kitting_world()
    ours, bare, quick, bare_quick, first = [], [], [], [], []
    planners: tuple[Planner, Planner] = (FastDownward(), Kairos())
    with tempfile.TemporaryDirectory() as folder:
        planned = _planned(planners[0], world, THREE)
        if planned.texts is None:
            raise SystemExit("no planner was asked")
        for name, text in (("domain.pddl", planned.texts.domain), ("problem.pddl", planned.texts.problem)):
            (Path(folder) / name).write_text(text, encoding="utf-8")
        for _ in range(pairs):
            ours.append(_timed(lambda: _planned(planners[0], world, THREE)))
            bare.append(_timed(lambda: _run(folder, *_FAST_DOWNWARD)))
            quick.append(_timed(lambda: _planned(planners[1], world, THREE)))
            bare_quick.append(_timed(lambda: _run(folder, str(program_path()), *_KAIROS)))
            first.append(_timed(lambda: _planned_at_first(world)))
    for planner in planners:
        planner.close()
    own, raw, fast, raw_fast, cold = map(statistics.median, (ours, bare, quick, bare_quick, first))
    return [
        Figure("bare fast-downward.py", _ms(raw)),
        Figure("3 parts, world to validated plan", f"{_ms(own)}, best {_ms(min(ours))}"),
        Figure("as a ratio", f"{own / raw:.2f}", "<= 1.2", own / raw <= 1.2, "bare fast-downward.py, same files"),
        Figure("the first plan, with a new planner", f"{_ms(cold)}, best {_ms(min(first))}"),
        Figure("as a ratio", f"{cold / raw:.2f}", "<= 1.2", cold / raw <= 1.2, "bare fast-downward.py, same files"),
        Figure("bare kairos", _ms(raw_fast)),
        Figure("3 parts with Kairos", f"{_ms(fast)}, best {_ms(min(quick))}"),
        Figure("as a ratio", f"{fast / raw_fast:.2f}", "<= 2.8", fast / raw_fast <= 2.8, "bare kairos, same files"),
    ]


def _many_robots() -> list[Figure]:
    """Ten of a hundred parts out of sixty places, four robots."""
    world = crowded(parts=100, boxes=60, kits=3, robots=4)
    goal = [OBJECT_AT_LOCATION(PART_CLASSES[i % 4], f"kit_{2 + i // 4}_{'abcd'[i % 4]}") for i in range(10)]
    planner = FastDownward()
    taken = statistics.median(_timed(lambda: _planned(planner, world, goal)) for _ in range(5))
    planner.close()
    return [in_steps("100 parts, 60 places, 4 robots, 10 wanted", taken, 8.3e6)]


def _learned(pairs: int) -> list[Figure]:
    """Three parts, in a world without learned costs and in one with a thousand, most of other robots and places."""
    plain, learned = kitting_world(), kitting_world()
    with learned.transaction("benchmark", "a thousand records") as tx:
        for number in range(1000):
            about = {"sk:ofSkill": ("drive", "pick", "place")[number % 3], "sk:ofRobot": f"robot_{number % 10 + 1}"}
            about |= {
                "sk:appliesTo": ("sk:Base", "sk:Arm", "sk:Arm")[number % 3],
                "sk:atPlace": f"place_{number // 30}",
            }
            lasted = tuple(10.0 + (number + run) % 7 for run in range(15))
            counts: dict[str, Value] = {"sk:runTimes": lasted, "sk:successes": 15.0, "sk:failures": 0.5}
            tx.add("sk:LearnedDuration", f"record {number}", None, {**about, **counts}, learned=True)
    planner = FastDownward()
    times: dict[int, list[float]] = {id(plain): [], id(learned): []}
    for turn in range(3 * pairs + 1):
        for world in (plain, learned) if turn % 2 else (learned, plain):
            taken = _timed(partial(_planned, planner, world, THREE))
            if turn:
                times[id(world)].append(taken)
    planner.close()
    without, with_records = (statistics.median(found) for found in times.values())
    ratio = with_records / without
    return [
        Figure("3 parts, nothing learned", _ms(without)),
        Figure("3 parts, 1,000 learned records", _ms(with_records)),
        Figure("as a ratio", f"{ratio:.3f}", "<= 1.05", ratio <= 1.05, "nothing learned, same run"),
    ]


def _crowded(pairs: int) -> list[Figure]:
    """The goal of three parts in a small world and in one a thousand times larger, with writes in between."""
    small, large = crowded(parts=40, boxes=10, others=30), crowded(parts=50_000, boxes=10_000, others=40_000)
    planner = FastDownward()
    times: dict[int, list[float]] = {id(small): [], id(large): []}
    for turn in range(pairs + 1):
        for world in (small, large):
            with world.transaction("benchmark", "something new") as tx:
                tx.add(PART_CLASSES[turn % 4], placement=Placement(IN, "pallet_a"))
            times[id(world)].append(_timed(partial(_planned, planner, world, THREE)))
    planner.close()
    few, many = (statistics.median(times[id(world)][1:]) for world in (small, large))
    return [
        Figure("3 parts in a world of 100", _ms(few)),
        Figure("3 parts in a world of 100,000", _ms(many)),
        Figure("as a ratio", f"{many / few:.2f}", "<= 1.3", many / few <= 1.3, "the world of 100"),
    ]


def _written(times: int) -> list[Figure]:
    """The complete problem of 500 parts in 50 boxes; `whole` includes everything."""
    world = crowded(parts=500, boxes=50)
    found = []
    for whole in (False, True):
        taken = statistics.median(_timed(partial(_write, world, whole=whole)) for _ in range(times))
        what = "every part in it" if whole else "interchangeable parts merged"
        found.append(in_steps(f"500 parts, 50 boxes as PDDL, {what}", taken, 560_000))
    return found


def _replanned() -> list[Figure]:
    taken = statistics.median(replanning_times(5))
    return [in_steps("from a failed pick to the next step", taken, 1.7e6)]


def _agreeing(problems: int) -> list[Figure]:
    """Random problems: the reduced problem has a plan exactly if the complete one has, and every plan is replayed."""
    planner = Kairos()
    wrong = [text for seed in range(problems) if (text := disagreement(random_task(seed), planner))]
    planner.close()
    for text in wrong[:5]:
        print(text)
    return [Figure(f"{problems} random problems, reduced unlike whole", str(len(wrong)), "0", not wrong)]


def _threads() -> list[Figure]:
    """A thousand goals from eight threads, if that benchmark is present."""
    if importlib.util.find_spec("planning_threads") is None:
        return []
    figures: list[Figure] = importlib.import_module("planning_threads").figures()
    return figures


# ------------------------------------------------------------------ what is timed


def _planned(planner: Planner, world: WorldView, goal: Sequence[Condition]) -> Planned:
    planned = plan(planner, world, able(world), goal)
    if not isinstance(planned.outcome, Plan):
        raise SystemExit(f"no plan: {planned.outcome}")
    return planned


def _write(world: WorldView, *, whole: bool) -> None:
    task = build_task(world, able(world), THREE, whole=whole)
    write_pddl(task.domain, task.problem, name="large")


def _planned_at_first(world: WorldView) -> Planned:
    """Plans with a new planner."""
    planner = FastDownward()
    try:
        return _planned(planner, world, THREE)
    finally:
        planner.close()


_FAST_DOWNWARD = (sys.executable, str(driver_path()), "--alias", "lama-first", "domain.pddl", "problem.pddl")
_KAIROS = ("domain.pddl", "problem.pddl", "--format", "json", "--output", "plan", *OPTIONS)


def _run(folder: str, *command: str) -> None:
    """Runs a planner alone, as from a shell."""
    subprocess.run(command, cwd=folder, stdout=subprocess.DEVNULL, check=True, env=dict(os.environ))


def _timed(work: Callable[[], object]) -> float:
    """Returns the wall time of a call [s]."""
    started = time.perf_counter()
    work()
    return time.perf_counter() - started


def _ms(seconds: float) -> str:
    return f"{seconds * 1e3:.0f} ms"


if __name__ == "__main__":
    sys.exit(main())
