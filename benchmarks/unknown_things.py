"""Things that no scene names, in the way of base and arm: generated scenes, and the forces in them, in physics.

A generator draws shapes, sizes, places and masses from the seed.
"""

from __future__ import annotations

import sys
from argparse import ArgumentParser
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from chance import Chance
from table import Figure, finish

from skiros_py.geometry import Pose, Primitive, Solid
from skiros_py.ports.cell import BodySpec
from skiros_py.simulation.truth import Truth
from skiros_py.station.session import Options, Session
from skiros_py.tasks.report import GoalReport
from skiros_py.world import vocabulary as v

_TRANSIENT, _HELD = 280.0, 140.0
"""Greatest forces on a hand [N]: ISO/TS 15066, in the first 10 ms and after 0.5 s."""
_SECOND = 200
"""Cycles of a second."""


@dataclass(frozen=True, slots=True)
class Trial:
    """What happened in one scene.

    Attributes:
        place: What the thing was in the way of: "base" or "arm".
        seed: Seed of the scene.
        pressure: Force on the thing, cycle by cycle [N].
        report: What the robot reported.
        known: Whether it has written that something is there.
    """

    place: str
    seed: int
    pressure: np.ndarray
    report: GoalReport
    known: bool

    @property
    def transient(self) -> float:
        """Greatest mean force over 10 ms [N]."""
        return float(((self.pressure[1:] + self.pressure[:-1]) / 2.0).max(initial=0.0))

    @property
    def held(self) -> float:
        """Greatest mean force over half a second [N]."""
        window = np.ones(_SECOND // 2) / (_SECOND // 2)
        return float(np.convolve(self.pressure, window, "valid").max(initial=0.0))

    @property
    def is_honest(self) -> bool:
        """Whether belief is truth."""
        return all(one.believed == one.true for one in self.report.conditions)


def for_base(seed: int) -> BodySpec:
    """Returns a box, post, bar or crate between the start of the robot and its goal."""
    chance = Chance(seed)
    kind = ("box", "post", "bar", "crate")[seed // 2 % 4]
    at = Pose.of(chance.within(1.9, 3.3), 1.6 + chance.sign() * chance.within(0.0, 0.4), 0.0, yaw=chance.turn())
    if kind == "post":
        return _body(Primitive("cylinder", (chance.within(0.03, 0.12), 1.2), Pose((0.0, 0.0, 0.6))), at, 0.0)
    if kind == "bar":  # between the floor and the hand, as a barrier
        height = chance.within(0.2, 0.9)
        return _body(Primitive("box", (0.05, chance.within(0.4, 1.0), 0.06), Pose((0.0, 0.0, height))), at, 0.0)
    size, height = chance.within(0.15, 0.5), chance.within(0.15, 0.8)
    mass = 0.0 if kind == "box" else chance.within(3.0, 25.0)
    return _body(Primitive("box", (size, chance.within(0.15, 0.5), height), Pose((0.0, 0.0, height / 2.0))), at, mass)


def for_arm(seed: int) -> BodySpec:
    """Returns a post or bar over the pallet at which the robot works."""
    chance = Chance(seed)
    x, y = chance.within(4.75, 4.95), 1.6 + chance.sign() * chance.within(0.0, 0.3)
    if seed // 2 % 2:
        return _body(Primitive("box", (0.05, 0.05, 0.6), Pose((0.0, 0.0, 0.3))), Pose((x, y, 0.45)), 0.0)
    bar = Primitive("box", (0.04, chance.within(0.3, 0.8), 0.04), Pose((0.0, 0.0, 0.0)))
    return _body(bar, Pose((x, y, chance.within(0.65, 0.9))), 0.0)


def _body(block: Primitive, pose: Pose, mass: float) -> BodySpec:
    return BodySpec("thing", "benchmark:Thing", Solid((block,)), pose=pose, mass=mass)


def run(place: str, seed: int) -> Trial:
    """Runs one scene; for the arm, the thing comes when the robot has arrived."""
    with Session("kitting", Options(seed=seed)) as session:
        if place == "arm":
            session.run(["RobotAtLocation(robot_1, pallet_a)"])
        session.simulation.add_body(for_base(seed) if place == "base" else for_arm(seed))
        truth, pressure = Truth(session.simulation), []
        session.cycle.observe(lambda: pressure.append(truth.pressure("thing")))
        goal = "RobotAtLocation(robot_1, pallet_a)" if place == "base" else "Holding(gripper_1, starter_1)"
        report = session.run([goal])
        known = bool(session.world.instances(v.OBSTACLE))
        return Trial(place, seed, np.array(pressure), report, known)


def trials(seeds: range) -> Iterator[Trial]:
    """Runs both kinds of scene with each seed, and says how each went."""
    for seed in seeds:
        for place in ("base", "arm"):
            trial = run(place, seed)
            said = "reached" if trial.report.reached else "; ".join(one.reason for one in trial.report.conditions)
            print(f"{place} {seed}: 10 ms {trial.transient:.0f} N, held {trial.held:.0f} N, "
                  f"{'known' if trial.known else 'not known'}, {said}", file=sys.stderr, flush=True)  # fmt: skip
            yield trial


def main() -> int:
    """Runs the campaign."""
    parser = ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--seeds", type=int, default=30, help="number of scenes of each kind")
    parser.add_argument("--first", type=int, default=0, help="seed of the first scene")
    arguments = parser.parse_args()
    found = list(trials(range(arguments.first, arguments.first + arguments.seeds)))
    base, arm = ([one for one in found if one.place == place] for place in ("base", "arm"))
    touched = sum(one.pressure.max(initial=0.0) > 0.0 for one in base)
    hit = [one for one in arm if one.pressure.max(initial=0.0) > 0.0]
    figures = [
        Figure(
            "in the base's way, which its scanner could see: contacts", f"{touched} of {len(base)}", "0", not touched
        ),
        Figure("  goal reached around it", _share(one.report.reached for one in base)),
        Figure("in the arm's way: contacts", f"{len(hit)} of {len(arm)}"),
        _force("  mean force in 10 ms, greatest", [one.transient for one in found], _TRANSIENT),
        _force("  held force, greatest", [one.held for one in found], _HELD),
        Figure("  goal reached", _share(one.report.reached for one in arm)),
        Figure("belief is not truth", *_none(not one.is_honest for one in found)),
        Figure("met, but not written down", *_none(not one.known for one in hit)),
    ]
    return finish("unknown things", figures)


def _share(yes: Iterator[bool]) -> str:
    each = list(yes)
    return f"{sum(each)} of {len(each)}"


def _force(what: str, forces: list[float], most: float) -> Figure:
    over = sum(force > most for force in forces)
    return Figure(what, f"{max(forces, default=0.0):.0f} N, {over} over", f"<= {most:.0f} N", not over, "ISO/TS 15066")


def _none(faults: Iterator[bool]) -> tuple[str, str, bool]:
    count = sum(faults)
    return str(count), "0", count == 0


if __name__ == "__main__":
    sys.exit(main())
