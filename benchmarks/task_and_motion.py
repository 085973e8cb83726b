"""Task and motion: plans for five parts that stand close together, into a kit without room, with all their motions.

    uv run --group test --group bench python benchmarks/task_and_motion.py --seeds 50

Each seed is a scene in which fingers get at few parts before their neighbours are gone, and into few compartments once
those beside are full. A plan counts when each of its steps has a motion: a path of the base to a dock from which the
arm reaches what comes next, and a grasp or a release with its way there, back and into the posture for driving. What
geometry forbids goes back to the planner as a fact, until a plan has all motions. The judge of these is Coal on the
meshes of the robot at 1 mm, sample by sample; ``--execute N`` also carries N of the plans out in physics.

Times are of the processor, with all programs that planning starts, and compared with py_trees' 1,000 nodes in the same
run.
"""

from __future__ import annotations

import os
import resource
import sys
import tempfile
from argparse import ArgumentParser
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from statistics import median
from time import process_time

from kernel import py_trees_tick
from packed_scenes import packed
from plan_geometry import Geometry, Motion
from shelves import Judge
from table import Figure, duration, finish

from skiros_py.config import ONTOLOGIES
from skiros_py.errors import SkirosError
from skiros_py.planning.plan import Plan, Step
from skiros_py.planning.requests import RuledOut
from skiros_py.station.session import Options, Session

_BAR = 5.0 / 0.0019
"""Median time of a plan, in ticks of py_trees' 1,000 nodes."""
_MOST = 40
"""Plans that are tried for one scene."""


@dataclass(frozen=True)
class Planned:
    """What became of one scene.

    Attributes:
        seed: Its seed.
        plans: How many plans were made.
        steps: The steps of the one that has all motions; none if there is none.
        motions: Its motions.
        ruled_out: What geometry forbade.
        reason: Why there is no plan.
        seconds: Processor time until then, with all programs that planning starts [s].
    """

    seed: int
    plans: int
    steps: tuple[Step, ...]
    motions: tuple[Motion, ...]
    ruled_out: tuple[RuledOut, ...]
    reason: str
    seconds: float


def planned(session: Session, geometry: Geometry, seed: int) -> Planned:
    """Plans until a plan has all motions, or there is none."""
    started, ruled_out, reason = _processor(), list[RuledOut](), "too many plans"
    request = session.tasks.plan_request(session.goal)
    for number in range(1, _MOST + 1):
        asked = session.planning.ask(replace(request, ruled_out=tuple(ruled_out)))
        outcome = asked.result().value.outcome
        if not isinstance(outcome, Plan):
            reason = "; ".join(outcome.reasons)
            break
        found = geometry.motions(outcome.steps)
        if not isinstance(found, RuledOut):
            seconds = _processor() - started
            return Planned(seed, number, tuple(outcome.steps), tuple(found), tuple(ruled_out), "", seconds)
        ruled_out.append(found)
    return Planned(seed, number, (), (), tuple(ruled_out), reason, _processor() - started)


def _processor() -> float:
    """Returns the time of the processor, with that of programs that have ended [s]."""
    ended = resource.getrusage(resource.RUSAGE_CHILDREN)
    return process_time() + ended.ru_utime + ended.ru_stime


def touched(judge: Judge, motions: Iterable[Motion]) -> Iterator[str]:
    """Yields what motions touch by the judgement of Coal."""
    for motion in motions:
        back = motion.base.inverse()
        around = [replace(one, pose=back @ one.pose) for one in motion.around]
        if contact := judge.first_contact(motion.postures, around, motion.held, motion.gap):
            yield f"{motion.step}: {contact}"


def tick_of_peer() -> float:
    """Returns the time of a tick of py_trees' 1,000 nodes now [s], the best of some."""
    tick = py_trees_tick()
    if tick is None:
        raise SystemExit("py_trees is not installed: uv sync --group bench")
    times = []
    for _ in range(20):
        started = process_time()
        tick()
        times.append(process_time() - started)
    return median(times)


def executed(path: Path, seed: int, ruled_out: Sequence[RuledOut], engine: str) -> str:
    """Carries a plan out in physics; returns why its goal is not reached by the truth, empty if it is."""
    with Session(str(path), Options(seed=seed, simulation=engine)) as session:
        report = session.run(ruled_out=ruled_out)
    missing = [f"{one.condition}: {one.reason}" for one in report.conditions if not one.true]
    return "; ".join(missing)


def main() -> int:
    """Plans for each scene; prints the table."""
    parser = ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--seeds", type=int, default=50, help="scenes")
    parser.add_argument("--first", type=int, default=0, help="the first seed; odd ones draw from other ranges")
    parser.add_argument("--step", type=int, default=1, help="from one seed to the next")
    parser.add_argument("--execute", type=int, default=0, help="carry so many of the plans out in physics")
    parser.add_argument("--simulation", default="", help="engine for that")
    given = parser.parse_args()
    seeds = range(given.first, given.first + given.step * given.seeds, given.step)
    found, ticks, hits, done = list[Planned](), list[float](), list[str](), list[str]()
    with suppress(KeyboardInterrupt), tempfile.TemporaryDirectory(prefix="skiros-packed-") as folder:
        os.environ[ONTOLOGIES] = str(Path(folder) / "parts")
        for seed in seeds:
            path = packed(seed).write(Path(folder))
            try:
                with Session(str(path), Options(fake=True)) as session:
                    geometry = Geometry(session)
                    found.append(one := planned(session, geometry, seed))
                    hits += (f"packed {seed}: {hit}" for hit in touched(Judge(session.spec.robots[0]), one.motions))
            except SkirosError as error:
                print(f"packed {seed} broke: {error}", flush=True)
                continue
            ticks.append(tick_of_peer())
            said = f"{len(one.steps)} steps" if one.steps else f"NONE: {one.reason}"
            print(
                f"packed {seed}: {said}, plan {one.plans}, {geometry.calls} motions, {duration(one.seconds)}"
                f" = {one.seconds / ticks[-1]:.0f} ticks",
                flush=True,
            )
            for fact in one.ruled_out if not one.steps else ():
                print(f"  {fact.skill} {fact.target}, {fact.blocker}: {fact.reason}", flush=True)
            if one.steps and len(done) < given.execute:
                done.append(executed(path, seed, one.ruled_out, given.simulation))
                print(f"  in physics: {done[-1] or 'reached'}", flush=True)
    for hit in hits:
        print(hit, flush=True)
    return finish("task and motion", figures(found, ticks, hits, done, len(seeds)))


def figures(
    found: Sequence[Planned], ticks: Sequence[float], hits: Sequence[str], done: Sequence[str], wanted: int
) -> list[Figure]:
    """Returns the figures."""
    solved = [one for one in found if one.steps]
    times = [one.seconds for one in solved] or [float("nan")]
    ratios = [one.seconds / tick for one, tick in zip(found, ticks, strict=True) if one.steps] or [float("nan")]
    plans = [one.plans for one in solved] or [0]
    rows = [
        Figure("plans with all motions", f"{len(solved)} of {wanted}", f"{wanted} of {wanted}", len(solved) == wanted),
        Figure(
            "time until then, median",
            f"{duration(median(times))} = {median(ratios):.0f} x",
            f"<= {_BAR:.0f} x",
            median(ratios) <= _BAR,
            f"py_trees' 1,000 nodes: {duration(median(ticks or [float('nan')]))}; PDDLStream's packed problem: 12.6 s",
        ),
        Figure("the same, longest", f"{duration(max(times))} = {max(ratios):.0f} x"),
        Figure("plans until then", f"median {median(plans):.0f}, at most {max(plans)}"),
        Figure("motions that touch something by Coal at 1 mm", f"{len(hits)}", "0", not hits),
    ]
    if done:
        reached = sum(not one for one in done)
        rows.append(Figure("reached in physics, by the truth", f"{reached} of {len(done)}"))
    return rows


if __name__ == "__main__":
    sys.exit(main())
