"""Manipulation in scenes that it was not tuned to, in physics: campaigns of generated scenes, judged by the truth.

    uv run --group test python benchmarks/manipulation.py --campaign standing --seeds 4 --half odd

Every figure is taken from the simulator: poses of bodies, contacts and their forces. Each miss is listed with the
reason that the robot gave and what the truth shows. With ``--pictures`` there are pictures of each miss, and a sheet of
all scenes; with ``--film`` an animation of the first and a sheet of its moments. ``--simulation`` names an engine, and
twice compares two.
``--write`` writes the scenes instead, each in a folder of its own, to be run by ``skiros run``. Ctrl+C ends it with the
figures of the scenes so far.
"""

from __future__ import annotations

import math
import sys
import tempfile
from argparse import ArgumentParser, Namespace
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import suppress
from functools import partial
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING

import manipulation_scenes as scenes
from manipulation_scenes import Chance, Scene
from manipulation_stage import Campaign, Stage, Trial, at_most, conditions, first_tries, honest, none, share
from table import Figure, finish, finish_side_by_side

from skiros_py.config import ONTOLOGIES
from skiros_py.geometry import Pose, Primitive, Solid, wrap_angle
from skiros_py.ports.cell import BodySpec
from skiros_py.recording.pictures import contact_sheet
from skiros_py.system import default_simulation
from skiros_py.world import vocabulary as v
from skiros_py.world.poses import map_pose

if TYPE_CHECKING:
    from PIL.Image import Image

_DISTURBING = 1_000_000
"""Added to a seed for what is done to a running scene; even, so that the half of the ranges stays."""
_TRANSIENT, _HELD = 280.0, 140.0
"""Greatest forces on a hand [N]: ISO/TS 15066, in the first 10 ms and after 0.5 s."""


class Standing(Campaign):
    """Parts on places of any height, kits and places turned at random."""

    name = "standing"
    scene = staticmethod(scenes.standing)

    def figures(self, trials: Sequence[Trial]) -> list[Figure]:
        """Returns the share of conditions, first tries, and honesty."""
        return [conditions(trials, 98.0), first_tries(trials), honest(trials), _hits(trials)]


class Reach(Campaign):
    """Into shelves, over walls, between neighbours."""

    name = "reach"
    scene = staticmethod(scenes.reach)

    def run(self, stage: Stage) -> dict[str, float]:
        """Returns by how much the neighbours were moved."""
        stage.pursue(stage.scene.goals)
        parts = [body.id for body in stage.session.spec.bodies if body.mass > 0.0 and body.id != "part_1"]
        return {part: stage.moved(part) for part in parts}

    def faults(self, stage: Stage, facts: dict[str, float]) -> Iterator[str]:  # noqa: ARG002
        """Yields the neighbours that were moved."""
        yield from (f"{part} was moved by {1e3 * by:.0f} mm" for part, by in facts.items() if by > _STAYS)

    def figures(self, trials: Sequence[Trial]) -> list[Figure]:
        """Returns the share of parts that are held, hits, and honesty."""
        knocked = (any(by > _STAYS for by in trial.facts.values()) for trial in trials)
        return [
            conditions(trials, 95.0),
            first_tries(trials),
            none("scenes in which something fixed was hit", (bool(trial.hits) for trial in trials)),
            none("scenes in which a neighbour was moved", knocked),
            honest(trials),
        ]


_STAYS = 0.01
"""What was moved by less stands where it stood [m]."""


class Compartments(Campaign):
    """A kit with little play, shifted after it was registered; one compartment has a part unknown to the robot."""

    name = "compartments"
    scene = staticmethod(scenes.compartments)

    def run(self, stage: Stage) -> dict[str, float]:
        """Shifts the kit for each part after the first registration, and counts parts on parts."""
        chance, onto = Chance(stage.scene.seed + _DISTURBING), set[str]()
        self._fill_one(stage, chance)
        frame = stage.truth.pose("kit_1")

        def shift() -> None:
            x, y = (chance.sign() * chance.within(0.0, 0.03) for _ in "xy")
            there = frame @ Pose.of(x, y, 0.0, yaw=self._turn(chance))
            inside = [body for body, place in stage.truth.placements().items() if place.startswith("kit_1")]
            stage.shift([*inside, "kit_1"], "kit_1", stage.truth.pose("kit_1").inverse() @ there)

        def look() -> None:
            onto.update(stage.lying_on_parts())

        for goal in stage.scene.goals:
            stage.after("register_kit", "", shift)
            stage.after("put_down", "", look, delay=1.0)
            stage.pursue([goal])
        look()
        return dict.fromkeys(onto, 1.0)

    @staticmethod
    def _turn(chance: Chance) -> float:
        return chance.sign() * math.radians(chance.within(0.0, 10.0))

    @staticmethod
    def _fill_one(stage: Stage, chance: Chance) -> None:
        """Puts a part, as one that is there already, into an empty compartment; the robot does not know."""
        bodies = {body.id: body for body in stage.session.spec.bodies}
        like = chance.some(("part_3", "part_4"), 1)[0]
        full = {stage.truth.placements()[part] for part in ("part_3", "part_4")}
        row = bodies[str(bodies[like].place)].solid
        free = [b.id for b in bodies.values() if b.compartment and b.solid == row and b.id not in full]
        at = stage.truth.pose(chance.some(sorted(free), 1)[0]) @ Pose((0.0, 0.0, 0.0005))
        of = bodies[like]
        stage.session.simulation.add_body(BodySpec("untold", of.type, of.solid, mass=of.mass, pose=at))

    def faults(self, stage: Stage, facts: dict[str, float]) -> Iterator[str]:  # noqa: ARG002
        """Yields the parts that lie on others."""
        yield from (f"{part} was put onto another part" for part in facts)

    def figures(self, trials: Sequence[Trial]) -> list[Figure]:
        """Returns the share of parts inside, parts on parts, and honesty."""
        return [
            conditions(trials, 97.0),
            first_tries(trials),
            none("parts put onto another part", (True for trial in trials for _ in trial.facts)),
            honest(trials),
            _hits(trials),
        ]


class Shifted(Campaign):
    """A part that is moved between the look at it and the lift."""

    name = "shifted"
    scene = staticmethod(scenes.shifted)

    def run(self, stage: Stage) -> dict[str, float]:
        """Moves the part once."""
        chance = Chance(stage.scene.seed + _DISTURBING)
        moments = {"look": ("locate", ""), "exact look": ("register_part", ""), "approach": ("grasp", "approaching")}
        by: list[float] = []

        def move() -> None:
            for _ in range(_TRIES):
                angle, far = chance.turn(), chance.within(0.0, 0.05)
                step = Pose.of(far * math.cos(angle), far * math.sin(angle), 0.0, yaw=chance.turn(0.5))
                there = stage.truth.pose("part_1") @ step
                if not stage.session.simulation.scene.hits("part_1", there @ Pose((0.0, 0.0, 0.001))):
                    stage.session.simulation.move_body("part_1", there)
                    by.append(far)
                    return

        stage.after(*moments[stage.scene.kind], move, delay=chance.within(0.0, 1.5))
        stage.pursue(stage.scene.goals)
        return {"moved": by[0] if by else 0.0}

    def figures(self, trials: Sequence[Trial]) -> list[Figure]:
        """Returns the share of parts at the right place, and honesty."""
        moved = sum(trial.facts["moved"] > 0.0 for trial in trials)
        shares = [conditions(trials, 90.0), first_tries(trials), honest(trials), _hits(trials)]
        return [*shares, Figure("scenes in which the part was moved", f"{moved} of {len(trials)}")]


_TRIES = 20


class Misplaced(Campaign):
    """A storage place, a table with its kit, or a rack that stands 12 cm from where the scene says."""

    name = "misplaced"
    scene = staticmethod(scenes.misplaced)

    def run(self, stage: Stage) -> dict[str, float]:
        """Shifts it before anything moves, with what stands on it; returns how far off the belief is in the end."""
        chance, wrong = Chance(stage.scene.seed + _DISTURBING), stage.scene.kind
        standing = {
            "pallet_1": [part for part, place in stage.truth.placements().items() if place == "pallet_1"],
            "kit_table": ["kit_1"],
            "rack_1": [],
        }[wrong]
        angle = chance.turn()
        stage.shift([*standing, wrong], wrong, Pose((0.12 * math.cos(angle), 0.12 * math.sin(angle), 0.0)))
        stage.pursue(stage.scene.goals)
        world, told = stage.session.world, "kit_1" if wrong == "kit_table" else wrong
        really, believed = stage.truth.pose(told), map_pose(world, told)
        obstacles = [map_pose(world, obstacle) for obstacle in world.instances(v.OBSTACLE)]
        near = any(pose is not None and pose.distance(really) < _NEAR for pose in obstacles)
        off = really.distance(believed) if believed is not None else 0.0
        unnoticed = off > _CORRECTED and not near and not (wrong == "rack_1" and not stage.forces.links["rack_1"])
        return {"off": off, "unnoticed": float(unnoticed)}

    def faults(self, stage: Stage, facts: dict[str, float]) -> Iterator[str]:
        """Yields what was not noticed."""
        if facts["unnoticed"]:
            yield f"{stage.scene.kind} is {1e3 * facts['off']:.0f} mm off, and that was not noticed"

    def figures(self, trials: Sequence[Trial]) -> list[Figure]:
        """Returns what was not noticed, the share of goals reached, and honesty."""
        return [
            none("scenes in which it was not noticed", (bool(trial.facts["unnoticed"]) for trial in trials)),
            share("goal reached", [trial.reached for trial in trials], 80.0),
            honest(trials),
            _hits(trials),
        ]


_CORRECTED, _NEAR = 0.03, 0.7
"""Greatest distance of a believed pose from the true one where it was noticed, and of an obstacle in its place [m]."""


class Unknown(Campaign):
    """A box, post, bar or crate that no scene names comes into the way of a base or an arm."""

    name = "unknown"
    scene = staticmethod(scenes.unknown)

    def must_not_touch(self, stage: Stage) -> Iterable[str]:
        """Returns the thing, besides all that never moves."""
        return [*super().must_not_touch(stage), *(stage.session.simulation.scene.bodies.keys() & {"thing"})]

    def run(self, stage: Stage) -> dict[str, float]:
        """Brings the thing in before or during the motion."""
        chance, (whose, moment) = Chance(stage.scene.seed + _DISTURBING), stage.scene.kind.split()
        number = stage.scene.seed // 2
        shape = ("box", "post", "bar", "crate")[(number + number // 4) % 4]
        far = chance.within(0.08, 0.2) if whose == "arm" else chance.within(1.1, 1.9)

        def bring() -> None:
            if whose == "arm":
                self._bring(stage, partial(_desk_thing, shape, chance, stage.truth.pose("part_1"), far))
            else:
                ahead = stage.truth.base_pose("base_1") @ Pose((far, 0.0, 0.0))
                self._bring(stage, partial(_floor_thing, shape, chance, ahead))

        if moment == "before":
            bring()
        else:
            module, text = ("grasp", "approaching") if whose == "arm" else ("drive_base", "leg 1")
            stage.after(
                module, text, bring, delay=chance.within(0.1, 0.8) if whose == "arm" else chance.within(0.5, 2.0)
            )
        stage.pursue(stage.scene.goals)
        there = "thing" in stage.session.simulation.scene.bodies
        return {"there": float(there), "known": float(bool(stage.session.world.instances(v.OBSTACLE)))}

    @staticmethod
    def _bring(stage: Stage, draw: Callable[[], BodySpec]) -> None:
        """Brings in a thing where it is inside nothing."""
        cell = stage.session.simulation
        for _ in range(_TRIES):
            thing = draw()
            cell.add_body(thing)
            if thing.pose is not None and not cell.scene.hits(thing.id, thing.pose @ Pose((0.0, 0.0, 0.002))):
                return
            cell.remove_body(thing.id)

    def figures(self, trials: Sequence[Trial]) -> list[Figure]:
        """Returns contacts with what could be seen, forces, false successes, and what was not written down."""
        seen = [trial for trial in trials if trial.scene.kind.endswith("before")]
        hit = [trial for trial in trials if trial.hits]
        return [
            none("contacts with what a camera or scanner could have seen", (bool(trial.hits) for trial in seen)),
            at_most("10 ms mean force", [trial.transient for trial in trials], _TRANSIENT, "N", "ISO/TS 15066"),
            at_most("held force", [trial.held for trial in trials], _HELD, "N", "ISO/TS 15066"),
            none("false successes", (one.believed and not one.true for trial in trials for one in trial.conditions)),
            Figure("goal reached around it", f"{sum(trial.reached for trial in trials)} of {len(trials)}"),
            none("met, but not written down", (not trial.facts["known"] for trial in hit if "thing" in trial.hits)),
            Figure(
                "scenes in which there was room for it", f"{sum(t.facts['there'] for t in trials):.0f} of {len(trials)}"
            ),
        ]


def _floor_thing(shape: str, chance: Chance, near: Pose) -> BodySpec:
    """Returns a thing that stands on the floor about a place."""
    at = near @ Pose.of(0.0, chance.sign() * chance.within(0.0, 0.35), 0.0, yaw=chance.turn())
    if shape == "post":
        return _thing(Primitive("cylinder", (chance.within(0.03, 0.12), 1.2), Pose((0.0, 0.0, 0.6))), at)
    if shape == "bar":  # between the floor and the hand, as a barrier
        middle = Pose((0.0, 0.0, chance.within(0.2, 0.9)))
        return _thing(Primitive("box", (0.05, chance.within(0.4, 1.0), 0.06), middle), at)
    size, height = (chance.within(0.15, 0.5), chance.within(0.15, 0.5)), chance.within(0.15, 0.8)
    mass = 0.0 if shape == "box" else chance.within(3.0, 25.0)
    return _thing(Primitive("box", (*size, height), Pose((0.0, 0.0, height / 2.0))), at, mass)


def _desk_thing(shape: str, chance: Chance, part: Pose, far: float) -> BodySpec:
    """Returns a thing that stands beside a part, or hangs over it."""
    angle = chance.turn()
    at = Pose(part.position) @ Pose.of(far * math.cos(angle), far * math.sin(angle), 0.001, yaw=chance.turn())
    height = chance.within(0.1, 0.45)
    if shape == "post":
        return _thing(Primitive("cylinder", (chance.within(0.015, 0.04), height), Pose((0.0, 0.0, height / 2.0))), at)
    if shape == "bar":
        return _thing(Primitive("box", (0.03, 0.5, 0.04), Pose((0.0, 0.0, chance.within(0.2, 0.45)))), at)
    size = chance.within(0.04, 0.12), chance.within(0.04, 0.12)
    mass = 0.0 if shape == "box" else chance.within(0.5, 5.0)
    return _thing(Primitive("box", (*size, height), Pose((0.0, 0.0, height / 2.0))), at, mass)


def _thing(block: Primitive, pose: Pose, mass: float = 0.0) -> BodySpec:
    return BodySpec("thing", "benchmark:Thing", Solid((block,)), pose=pose, mass=mass)


class Docking(Campaign):
    """Docks at places one after the other, and passages hardly wider than the robot."""

    name = "docking"
    scene = staticmethod(scenes.docking)

    def run(self, stage: Stage) -> dict[str, float]:
        """Returns how far from each place the base stands in truth [mm], and how it is turned [degrees]."""
        facts: dict[str, float] = {}
        for place in sorted(body for body in stage.fixed() if body.startswith("pallet")):
            stage.pursue([f"RobotAtLocation(robot_1, {place})"])
            wanted = stage.truth.pose(place) @ scenes.AT_PLACE
            base = stage.truth.base_pose("base_1")
            facts[f"{place} mm"] = 1e3 * math.dist(wanted.position[:2], base.position[:2])
            facts[f"{place} deg"] = abs(math.degrees(wrap_angle(base.yaw - wanted.yaw)))
        return facts

    def faults(self, stage: Stage, facts: dict[str, float]) -> Iterator[str]:
        """Yields the docks that are missed."""
        for name, value in facts.items() if stage.scene.kind == "docks" else ():
            if value > _DOCKED[name.rpartition(" ")[2]]:
                yield f"docked {value:.2f} off: {name}"

    def figures(self, trials: Sequence[Trial]) -> list[Figure]:
        """Returns the errors of docking, and how many passages were driven without a contact."""
        docks, passages = ([t for t in trials if t.scene.kind == kind] for kind in ("docks", "passage"))
        errors = {
            unit: [value for t in docks for name, value in t.facts.items() if name.endswith(unit)] for unit in _DOCKED
        }
        return [
            *(at_most(f"docked off, {unit}", errors[unit], most, unit) for unit, most in _DOCKED.items()),
            share("docks reached", [bool(c.true) for trial in docks for c in trial.conditions], 100.0),
            share("passages driven", [trial.reached for trial in passages], 100.0),
            none("scenes with contacts", (bool(trial.hits) for trial in trials)),
            honest(trials),
        ]


_DOCKED = {"mm": 5.0, "deg": 0.5}
"""Greatest error of a docked base, by its unit."""


def _hits(trials: Sequence[Trial]) -> Figure:
    worst = max((trial.transient for trial in trials), default=0.0)
    return Figure("scenes in which something fixed was touched", f"{sum(bool(t.hits) for t in trials)}, {worst:.0f} N")


CAMPAIGNS: dict[str, Campaign] = {
    one.name: one for one in (Standing(), Reach(), Compartments(), Shifted(), Misplaced(), Unknown(), Docking())
}


# ---------------------------------------------------------------- the command


def main() -> int:
    """Runs a campaign."""
    parser = ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--campaign", choices=sorted(CAMPAIGNS), required=True)
    parser.add_argument("--seeds", type=int, default=30, help="number of scenes")
    parser.add_argument("--first", type=int, default=0, help="seed of the first scene")
    parser.add_argument("--half", choices=("odd", "even", "both"), default="both", help="seeds that are taken")
    parser.add_argument("--pictures", type=Path, help="folder for pictures of the misses, and for the contact sheet")
    parser.add_argument("--film", action="store_true", help="show the first scene as it runs, too")
    parser.add_argument("--simulation", action="append", help="engine that simulates; twice for two engines")
    parser.add_argument("--write", type=Path, help="folder for the scenes: they are written, and not run")
    arguments = parser.parse_args()
    campaign = CAMPAIGNS[arguments.campaign]
    drawn = [campaign.scene(seed) for seed in _seeds(arguments)]
    if arguments.write is not None:
        for scene in drawn:
            folder = arguments.write / scene.name
            print(f"{ONTOLOGIES}={folder / 'parts'} skiros run {scene.write(folder)}")
        return 0
    if arguments.film and arguments.pictures is None:
        parser.error("--film needs --pictures, the folder for it")
    measured: dict[str, list[Figure]] = {}
    engines = arguments.simulation or [default_simulation()]
    for engine in engines:
        pictures = arguments.pictures / engine if arguments.pictures and len(engines) > 1 else arguments.pictures
        trials: list[Trial] = []
        with suppress(KeyboardInterrupt):
            trials.extend(_run(campaign, drawn, engine, pictures, film=arguments.film))
        run = Figure("scenes that were run", f"{len(trials)}", f"{len(drawn)}", len(trials) == len(drawn))
        measured[engine] = [*campaign.figures(trials), run]
        if not run.holds:
            break
    title = f"{campaign.name}, {len(drawn)} scenes"
    return finish_side_by_side(title, measured) if len(engines) > 1 else finish(title, measured[engines[0]])


def _seeds(arguments: Namespace) -> list[int]:
    parities = {"odd": (1,), "even": (0,), "both": (0, 1)}[arguments.half]
    wanted = (seed for seed in count(arguments.first) if seed % 2 in parities)
    return [next(wanted) for _ in range(arguments.seeds)]


def _run(
    campaign: Campaign, drawn: Sequence[Scene], engine: str, pictures: Path | None, *, film: bool
) -> Iterator[Trial]:
    """Runs scenes one after the other, says how each went, and writes their pictures."""
    sheet: list[Image] = []
    if pictures is not None:
        pictures.mkdir(parents=True, exist_ok=True)
    for scene in drawn:
        names = (f"{scene.name}_run.gif", f"{scene.name}_moments.png") if film and scene is drawn[0] else ()
        films = [pictures / name for name in names] if pictures is not None else []
        with tempfile.TemporaryDirectory(prefix="skiros-campaign-") as folder:
            trial = campaign.trial(scene, Path(folder), pictures=pictures is not None, simulation=engine, films=films)
        verdict = "MISS" if trial.misses else "as wanted"
        print(f"{scene.name} ({scene.kind}, {engine}): {verdict}", file=sys.stderr, flush=True)
        for miss in trial.misses:
            print(f"  {miss}", flush=True)
        if pictures is not None:
            if trial.misses:
                contact_sheet(trial.pictures).save(pictures / f"{scene.name}.png")
            sheet += trial.pictures[-1:]
            contact_sheet(sheet).save(pictures / f"{campaign.name}.png")
        yield trial


if __name__ == "__main__":
    sys.exit(main())
