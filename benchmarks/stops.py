"""Stops at every hundredth cycle of whole kitting runs, in physics: all stands, nothing is dropped, it goes on.

    uv run --group test python benchmarks/stops.py

A run is stopped every ten seconds, and the goal is ordered again each time. Runs are shifted against each other by a
hundred cycles, so that together they are stopped at every hundredth cycle; the ground truth judges.
"""

from __future__ import annotations

import math
import sys
from argparse import ArgumentParser
from dataclasses import dataclass, field

from table import Figure, finish

from skiros_py.devices.mobile_base import BaseSpec, BaseState
from skiros_py.simulation.truth import Truth
from skiros_py.station.session import Options, Session
from skiros_py.tasks.report import GoalReport

_EVERY, _GAP = 100, 2000
"""Cycles between the stops of all runs together, and between those of one run."""
_WAIT = 100
"""Cycles after standing in which nothing may fall."""
_HEARD = 3
"""Cycles from a stop until a base slows down: the command, the next exchange, its drives."""
_ROOM = 0.002
"""How much farther than its braking distance a base may come, as its speed is measured [m]."""
_FALL = 0.5
"""Speed downwards from which a part falls: one that is let go some millimetres over its place is slower [m/s]."""
_PATIENCE = 3
"""Orders in a row that end without the goal, and without a stop, before a run is given up."""


@dataclass(slots=True)
class Run:
    """A run with its stops.

    Attributes:
        number: Which run.
        late: Stops after which something still moved once the braking time was over.
        dropped: What was held before a stop and not after it, and what fell at any time.
        stops: Their number.
        rolled: Greatest distance of a base from where it was at a stop to where it stood [m].
        beyond: By how much that was farther than its braking distance, at most [m].
        seconds: Simulated time [s].
        report: The last report.
        dishonest: Reports of a condition that was not so.
    """

    number: int
    late: int = 0
    dropped: list[str] = field(default_factory=list)
    stops: int = 0
    rolled: float = 0.0
    beyond: float = -math.inf
    seconds: float = 0.0
    report: GoalReport | None = None
    dishonest: int = 0


def run(number: int, scene: str, first: int) -> Run:
    """Runs a scene with a stop every ten seconds, until its goal is reached.

    Args:
        number: The seed.
        scene: The scene.
        first: Cycle of the first stop.
    """
    found = Run(number)
    with Session(scene, Options(seed=number)) as session:
        truth, cycles = Truth(session.simulation), 0
        base = next(one for robot in session.spec.robots for one in robot.of(BaseSpec))
        before: dict[str, str] = {}
        at, within = truth.base_pose(base.id), 0.0
        parts, heights, falling = tuple(truth.placements()), dict[str, float](), set[str]()

        def count() -> None:
            nonlocal cycles, before, at, within
            cycles += 1
            for part in parts:
                height = truth.pose(part).position[2]
                fast = heights.get(part, height) - height > _FALL * session.cycle.board.period
                if fast and part not in falling:
                    found.dropped.append(f"{part} falls at cycle {cycles}")
                heights[part] = height
                (falling.add if fast else falling.discard)(part)
            if cycles >= first and (cycles - first) % _GAP == 0:
                before, at = _held(truth), truth.base_pose(base.id)
                within = _braking_distance(base, session)
                session.stop()

        session.cycle.observe(count)
        left = _PATIENCE
        while left:
            found.report = session.run()
            found.dishonest += sum(one.believed and not one.true for one in found.report.conditions)
            if not found.report.stopped:
                left = 0 if found.report.reached else left - 1
                continue
            found.stops += 1
            found.late += not session.cycle.board.still
            rolled = at.distance(truth.base_pose(base.id))
            found.rolled, found.beyond = max(found.rolled, rolled), max(found.beyond, rolled - within)
            for _ in range(_WAIT):
                session.cycle.step()
            after = _held(truth)
            found.dropped += [f"{part} at cycle {cycles}" for part, by in before.items() if after.get(part) != by]
        found.seconds = session.cycle.board.snapshot.time
    return found


def _held(truth: Truth) -> dict[str, str]:
    """Returns what grippers hold, by part."""
    return {part: place for part, place in truth.placements().items() if place.startswith("gripper")}


def _braking_distance(base: BaseSpec, session: Session) -> float:
    """Returns how far a base may roll on from now [m]: at its speed until it hears of the stop, then braking."""
    speed = abs(session.cycle.board.snapshot.state(base.id, BaseState).linear)
    return speed * _HEARD * session.cycle.board.period + speed**2 / (2.0 * base.max_linear_acceleration)


def main() -> int:
    """Runs the campaign."""
    parser = ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--runs", type=int, default=_GAP // _EVERY, help="number of runs")
    parser.add_argument("--first", type=int, default=0, help="first run")
    parser.add_argument("--scene", default="kitting")
    arguments = parser.parse_args()
    runs: list[Run] = []
    for number in range(arguments.first, arguments.first + arguments.runs):
        found = run(number, arguments.scene, (number + 1) * _EVERY)
        runs.append(found)
        print(
            f"run {number}: {found.stops} stops, {found.seconds:.0f} s, rolled {1e3 * found.rolled:.0f} mm, "
            f"{1e3 * found.beyond:+.1f} mm, {_outcome(found)}",
            file=sys.stderr,
            flush=True,
        )
    stops = sum(one.stops for one in runs)
    dropped = [f"run {one.number}, {what}" for one in runs for what in one.dropped]
    beyond = max(one.beyond for one in runs)
    reached = sum(one.report is not None and one.report.reached for one in runs)
    return finish(
        "stops",
        [
            Figure("stops", f"{stops}"),
            _none("something moved after its braking time", sum(one.late for one in runs)),
            Figure("a base came to rest within, at most", f"{1e3 * max(one.rolled for one in runs):.0f} mm"),
            Figure("that beyond its braking distance, at most", f"{1e3 * beyond:.1f} mm", "<= 2 mm", beyond <= _ROOM),
            _none("parts dropped", len(dropped), "; ".join(dropped[:2])),
            _none("goals believed and not reached", sum(one.dishonest for one in runs)),
            Figure(
                "runs that reach the goal after all stops", f"{reached} of {len(runs)}", "all", reached == len(runs)
            ),
        ],
    )


def _outcome(found: Run) -> str:
    assert found.report is not None
    why = "; ".join(one.reason for one in found.report.conditions if not one.believed)
    return ("reached" if found.report.reached else f"not reached: {why}") + "".join(
        f"; dropped {d}" for d in found.dropped
    )


def _none(what: str, count: int, where: str = "") -> Figure:
    return Figure(what, f"{count}{where and f' ({where})'}", "0", count == 0)


if __name__ == "__main__":
    sys.exit(main())
