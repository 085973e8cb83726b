"""Plans that use their robots: makespan against a lower bound, time to the first plan, agreement of validators.

    uv run --group test python benchmarks/fleet.py
    uv run --group test python benchmarks/fleet.py --only head-on

Parts out of a hundred, four for each kit; a kit takes one robot at a time. No plan is shorter than its longest chain,
than the work of all chains divided by the robots, and than the time during which the busiest place is occupied.
Makespans are planned times, from the durations that the skills declare. Every plan is replayed by the product's
validator and by that of unified-planning. Besides, two robots meet head on in lanes, in physics (``lanes.py``).
"""

from __future__ import annotations

import argparse
import random
import statistics
import sys
import time
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import pyparsing
import unified_planning.shortcuts as up
from lanes import head_on, meet_all
from planning_worlds import able, crowded
from table import Figure, finish
from unified_planning.engines import SequentialPlanValidator, ValidationResultStatus
from unified_planning.io import PDDLReader

from skiros_py.planning.plan import Plan
from skiros_py.planning.planners.fast_downward import FastDownward
from skiros_py.planning.replay import replay
from skiros_py.planning.service import Planned, PlanningOptions, plan
from skiros_py.skills.conditions import Condition
from skiros_py.skills.outcome import Failure, Success
from skiros_py.world.world import World
from skiros_skills import kitting
from skiros_skills.conditions import OBJECT_AT_LOCATION
from skiros_skills.drive import DESCRIPTION as DRIVE
from skiros_skills.pick import DESCRIPTION as PICK
from skiros_skills.place import DESCRIPTION as PLACE

SKILLS = {skill.name: skill for skill in (DRIVE, PICK, PLACE)}
SECONDS = {name: skill.duration or 0.0 for name, skill in SKILLS.items()}
CHAIN = 2 * SECONDS["drive"] + SECONDS["pick"] + SECONDS["place"]
"""How long one part takes [s]."""
_STARTED = time.perf_counter()
_LONGEST = ((4, 1.3), (8, 1.6))
"""For up to so many robots the greatest makespan, as a multiple of the bound."""


@dataclass(frozen=True, slots=True)
class Run:
    """One plan.

    Attributes:
        makespan: Its makespan [s].
        ratio: The same as a multiple of the lower bound.
        wall: How long planning took [s].
        valid: What both validators say: ours, then the other one.
    """

    makespan: float
    ratio: float
    wall: float
    valid: tuple[bool, bool]

    def __str__(self) -> str:
        return f"{self.makespan:.0f} s = {self.ratio:.2f} x the bound, planned in {self.wall:.1f} s"


def main() -> int:
    """Measures."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, help="number of goals of each size (10), and of lanes (20)")
    parser.add_argument("--quick", action="store_true", help="few parts, few robots, two goals, two lanes")
    parser.add_argument("--only", choices=("plans", "head-on"), help="measure only one of the two")
    options = parser.parse_args()
    parts, robots = ((10,), (1, 2, 4)) if options.quick else ((10, 30, 50), (1, 2, 4, 8, 16))
    goals, lanes = (options.seeds or usual for usual in ((2, 2) if options.quick else (10, 20)))
    found = [] if options.only == "head-on" else figures(parts, robots, range(goals))
    found += [] if options.only == "plans" else head_on_figures(range(lanes))
    return finish("fleet", found)


def head_on_figures(seeds: Sequence[int]) -> list[Figure]:
    """Returns the figures for two robots that meet head on in a lane."""
    met = meet_all(seeds)
    failed = [[one for one in meeting.outcomes if not isinstance(one, Success)] for meeting in met]
    no_room = [head_on(seed).has_no_room for seed in seeds]
    roomy = [not fails for fails, tight in zip(failed, no_room, strict=True) if not tight]
    tight = [
        all(isinstance(one, Failure) and one.values for one in fails)
        for fails, tight in zip(failed, no_room, strict=True)
        if tight
    ]
    worst = max(meeting.stood for meeting in met)
    touches = sorted({touch for meeting in met for touch in meeting.touches})
    return [
        Figure(
            f"{len(met)} lanes, two robots head on: until one gives way or says why not, simulated",
            f"median {statistics.median(meeting.stood for meeting in met):.1f} s, at most {worst:.1f} s",
            "<= 10 s",
            worst <= 10.0,
        ),
        Figure("both arrive where there is room", f"{sum(roomy)} of {len(roomy)}", "all", all(roomy)),
        Figure("both say why where there is none", f"{sum(tight)} of {len(tight)}", "all", all(tight)),
        Figure("robots touch each other or a wall", ", ".join(touches) or "never", "never", not touches),
    ]


def figures(parts: Sequence[int], robots: Sequence[int], seeds: Sequence[int]) -> list[Figure]:
    """Returns the figures for numbers of parts and robots."""
    found: list[Figure] = []
    runs: list[Run] = []
    for wanted in parts:
        fewer: list[Run] = []
        for number in robots:
            own = []
            for seed in seeds:
                own.append(measure(wanted, number, seed))
                _tell(f"{wanted} parts, {number} robots, goal {seed}: {own[-1]}")
            most = next((ratio for up_to, ratio in _LONGEST if number <= up_to), None)
            longer = sum(run.makespan > before.makespan + 1e-6 for run, before in zip(own, fewer, strict=False))
            worst = max(run.ratio for run in own)
            holds = longer == 0 and (most is None or worst <= most)
            bar = "never longer with more robots" + (f", <= {most} x" if most else "")
            value = f"median {_seconds(own)}, at most {worst:.2f} x the bound" + (f", {longer} longer" * bool(longer))
            found.append(Figure(f"{wanted} parts, {number} robots: makespan", value, bar, holds))
            runs += own
            fewer = own
    wanted, number = max(parts), min(8, max(robots))
    first = [measure(wanted, number, seed, tries=0, outside=False).wall for seed in seeds]
    again = [measure(wanted, number, seeds[0], outside=False).makespan for _ in range(2)]
    agree = sum(all(run.valid) for run in runs)
    return [
        *found,
        Figure(
            f"{wanted} parts, {number} robots: first validated plan",
            f"median {statistics.median(first):.1f} s, at most {max(first):.1f} s",
            "<= 5 s",
            statistics.median(first) <= 5.0,
        ),
        Figure("same goal, same plan", f"{again[0]:g} s, {again[1]:g} s", "equal", again[0] == again[1]),
        Figure("both validators accept", f"{agree} of {len(runs)} plans", "all", agree == len(runs)),
    ]


def measure(parts: int, robots: int, seed: int, *, tries: int = PlanningOptions().tries, outside: bool = True) -> Run:
    """Plans for one goal, and validates the plan.

    Args:
        parts: How many parts are wanted.
        robots: How many robots there are.
        seed: Which parts.
        tries: How often the first schedule is changed in order to improve it.
        outside: False to omit the other validator, which takes long.
    """
    world, goal = _problem(parts, robots, seed)
    planner = FastDownward()
    planner.warm_up()
    try:
        started = time.perf_counter()
        planned = plan(planner, world, able(world), goal, options=PlanningOptions(tries=tries))
        wall = time.perf_counter() - started
    finally:
        planner.close()
    if not isinstance(planned.outcome, Plan):
        raise SystemExit(f"no plan for {parts} parts and {robots} robots: {planned.outcome}")
    steps, starts = planned.outcome.steps, planned.outcome.starts
    makespan = max(start + SECONDS[step.skill] for start, step in zip(starts, steps, strict=True))
    ours = replay(world, steps, goal, SKILLS) is None
    return Run(makespan, makespan / bound(goal, robots, world), wall, (ours, not outside or is_valid_outside(planned)))


def bound(goal: Sequence[Condition], robots: int, world: World) -> float:
    """Returns what no plan is shorter than [s].

    A place is occupied while a robot comes, works there, and, unless it is the last one, leaves.
    """
    places = [world.placement(condition.arguments[0]) for condition in goal]
    visits = (
        Counter(placement.place for placement in places if placement is not None),
        Counter(condition.arguments[1].rpartition("_")[0] for condition in goal),
    )
    works = (SECONDS["pick"], SECONDS["place"])
    busy = [
        number * (SECONDS["drive"] + work) + (number - 1) * SECONDS["drive"]
        for own, work in zip(visits, works, strict=True)
        for number in own.values()
    ]
    return max(CHAIN, len(goal) * CHAIN / robots, *busy)


def is_valid_outside(planned: Planned) -> bool:
    """Returns whether unified-planning accepts the plan for the PDDL it belongs to."""
    if planned.texts is None or not isinstance(planned.outcome, Plan):
        return False
    up.get_environment().credits_stream = None
    pyparsing.ParserElement.disable_memoization()  # unified-planning enables it: its parser then takes twice as long
    reader = PDDLReader()
    problem = reader.parse_problem_string(planned.texts.domain, planned.texts.problem)
    written = "\n".join(map(planned.texts.line, planned.outcome.groundings)) + "\n"
    answer = SequentialPlanValidator().validate(problem, reader.parse_plan_string(problem, written))
    return bool(answer.status is ValidationResultStatus.VALID)


def _problem(parts: int, robots: int, seed: int) -> tuple[World, list[Condition]]:
    kits = (parts + 3) // 4
    world = crowded(parts=100, boxes=25, kits=kits, robots=robots)
    wanted = random.Random(seed).sample(sorted(world.instances(kitting.PART)), parts)  # noqa: S311
    slots = [f"kit_{kit}_{letter}" for kit in range(2, kits + 2) for letter in "abcd"]
    return world, [OBJECT_AT_LOCATION(part, slot) for part, slot in zip(wanted, slots, strict=False)]


def _tell(text: str) -> None:
    print(f"[{time.perf_counter() - _STARTED:5.0f} s] {text}", file=sys.stderr, flush=True)


def _seconds(runs: Sequence[Run]) -> str:
    return f"{statistics.median(run.makespan for run in runs):.0f} s"


if __name__ == "__main__":
    sys.exit(main())
