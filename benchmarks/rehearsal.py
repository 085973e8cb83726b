"""Rehearsal: does it say what will fail, and is the goal reached with the plan that it found instead?

    uv run --group test python benchmarks/rehearsal.py --seeds 4

Scenes with a geometric trap, and as many without, are rehearsed from beliefs; then the same goal is pursued for real,
in a simulation in which what no belief says is drawn otherwise. The truth is what the first plan does there.
"""

from __future__ import annotations

import os
import sys
import tempfile
from argparse import ArgumentParser
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import rehearsal_scenes as scenes
from manipulation_scenes import Scene
from table import Figure, duration, finish

from skiros_py.config import ONTOLOGIES
from skiros_py.errors import SkirosError
from skiros_py.planning.plan import Plan
from skiros_py.planning.requests import RuledOut
from skiros_py.planning.service import Planned
from skiros_py.skills.outcome import CANCELLED, Failure, Outcome
from skiros_py.station.rehearsals.order import order_from
from skiros_py.station.rehearsals.rehearsal import rehearsed
from skiros_py.station.session import Options, Session
from skiros_py.station.worlds import open_world
from skiros_py.tasks.handle import TaskHandle
from skiros_py.tasks.rehearsal import Rehearsal
from skiros_py.tasks.trace import StepRun

_RIGHT, _REACHED = 0.95, 0.9


@dataclass(frozen=True)
class Run:
    """What really happened.

    Attributes:
        reached: Whether the goal was reached, by the truth of the simulation.
        as_planned: Whether each step of the first plan succeeded, perhaps after some tries.
        reason: Why not.
    """

    reached: bool
    as_planned: bool
    reason: str


def pursued(path: Path, seed: int, ruled_out: Sequence[RuledOut] = ()) -> Run:
    """Pursues the goal of a scene without a rehearsal, by the truth of the simulation."""
    plans: list[Plan] = []
    done, failed = Counter[str](), list[str]()

    def follow(task: TaskHandle) -> None:
        task.after_step(note)

    def keep(planned: Planned) -> None:
        plans.extend([planned.outcome] if isinstance(planned.outcome, Plan) else [])

    def note(run: StepRun, outcome: Outcome) -> None:
        if not isinstance(outcome, Failure):
            done[str(run.step)] += 1
        elif outcome.code != CANCELLED:
            failed.append(outcome.reason)

    with Session(str(path), Options(seed=seed)) as session:
        session.tasks.on_begin(follow)
        session.on_plan(keep)
        report = session.run(ruled_out=ruled_out)
    # another plan may repeat a step of the first one, such as a drive to a place where it then does something else
    left = Counter(str(step) for plan in plans[:1] for step in plan.steps) - done
    reasons = [*failed, *(c.reason for c in report.conditions if c.reason), *report.no_plan]
    return Run(report.reached, report.reached and not left, "; ".join(dict.fromkeys(reasons)))


@dataclass(frozen=True)
class Trial:
    """One scene.

    Attributes:
        scene: The scene.
        rehearsal: What the rehearsal said.
        first: What the first plan really did.
        again: What the plan that the rehearsal found did; None if it found none, or needed no other.
    """

    scene: Scene
    rehearsal: Rehearsal
    first: Run
    again: Run | None

    @property
    def right(self) -> bool:
        """Whether the rehearsal said of the first plan what it does."""
        return self.rehearsal.first_fails != self.first.as_planned

    @property
    def can_be_reached(self) -> bool:
        """Whether the first plan fails and there is another way."""
        return not self.first.as_planned and (self.scene.kind.endswith("another way") or self.first.reached)


def tried(scene: Scene) -> Trial:
    """Rehearses a scene, and then does it."""
    with tempfile.TemporaryDirectory(prefix="skiros-rehearsed-") as folder:
        path = scene.write(Path(folder))
        os.environ[ONTOLOGIES] = str(Path(folder) / "parts")
        rehearsal = rehearsed(order_from(open_world(str(path)), Options(seed=scene.seed)))
        first = pursued(path, scene.seed)
        another = rehearsal.passed and rehearsal.first_fails
        again = pursued(path, scene.seed, rehearsal.ruled_out) if another else None
    return Trial(scene, rehearsal, first, again)


def told(trial: Trial) -> Iterator[str]:
    """Yields how a scene went, and why where it is a miss."""
    rehearsal, first = trial.rehearsal, trial.first
    verdict = "right" if trial.right else "WRONG"
    yield f"{trial.scene.name} ({trial.scene.kind}): {verdict}, rehearsed in {duration(rehearsal.wall)}"
    yield f"  rehearsal: {'fails' if rehearsal.first_fails else 'works'}; {rehearsal.reason or 'passed'}"
    for one in rehearsal.ruled_out:
        yield f"  ruled out: {one.reason}"
    yield f"  first plan: {'as planned' if first.as_planned else 'fails'}; {first.reason}"
    if trial.again is not None:
        yield f"  other plan: {'reached' if trial.again.reached else 'NOT reached'}; {trial.again.reason}"


def main(arguments: Sequence[str] | None = None) -> int:
    """Rehearses scenes and does them; prints the table."""
    parser = ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=40, help="scenes with a trap, and as many without")
    parser.add_argument("--first", type=int, default=0, help="the first seed; odd ones draw from other ranges")
    parser.add_argument("--write", type=Path, help="write the scenes into a folder instead")
    given = parser.parse_args(arguments)
    seeds = range(given.first, given.first + 2 * given.seeds, 2)
    drawn = [scenes.scene(seed, trap=trap) for seed in seeds for trap in (True, False)]
    if given.write is not None:
        for scene in drawn:
            folder = given.write / scene.name
            print(f"{ONTOLOGIES}={folder / 'parts'} skiros rehearse {scene.write(folder)}")
        return 0
    trials: list[Trial] = []
    with suppress(KeyboardInterrupt):
        for scene in drawn:
            try:
                trials.append(tried(scene))
            except SkirosError as error:
                print(f"{scene.name} ({scene.kind}): broke: {error}", flush=True)
                continue
            print("\n".join(told(trials[-1])), flush=True)
    return finish("rehearsal", figures(trials, len(drawn)))


def figures(trials: Sequence[Trial], wanted: int) -> list[Figure]:
    """Returns the figures of the trials."""
    right = sum(trial.right for trial in trials)
    failing = [trial for trial in trials if not trial.first.as_planned]
    can_be = [trial for trial in trials if trial.can_be_reached]
    again = sum(trial.again is not None and trial.again.reached for trial in can_be)
    plain = sum(trial.first.reached for trial in can_be)
    walls = sorted(trial.rehearsal.wall for trial in trials)
    return [
        Figure("scenes that were tried", f"{len(trials)}", f"{wanted}", len(trials) == wanted),
        Figure("said right", f"{right} of {len(trials)}", f">= {_RIGHT:.0%}", right >= _RIGHT * len(trials)),
        Figure("plans that fail", f"{len(failing)}", "> 0", bool(failing)),
        Figure(
            "reached with another plan, of those that can be",
            f"{again} of {len(can_be)}",
            f">= {_REACHED:.0%}",
            again >= _REACHED * len(can_be),
            f"without a rehearsal {plain}",
        ),
        Figure("time of a rehearsal, median", duration(walls[len(walls) // 2]) if walls else "-"),
    ]


if __name__ == "__main__":
    sys.exit(main())
