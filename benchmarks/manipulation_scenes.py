"""Generated scenes for ``benchmarks/manipulation.py``: scene files and ontologies of their own parts, drawn from seeds.

Each range is cut into quarters: odd seeds draw from the first and the third, even seeds from the other two. What is
mended is tried on odd seeds, so that the even ones stay unseen for the final campaign.
"""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

import numpy as np

from skiros_py.geometry import Pose, Primitive

_PREFIXES = """@prefix scene: <https://w3id.org/skiros-py/scene#> .
@prefix kitting: <https://w3id.org/skiros-py/kitting#> .
@prefix own: <https://w3id.org/skiros-py/benchmarks/parts#> .
@prefix sk: <https://w3id.org/skiros-py/core#> .
@prefix owl: <http://www.w3.org/2002/07/owl#> .
@prefix rdf: <http://www.w3.org/1999/02/22-rdf-syntax-ns#> .
@prefix rdfs: <http://www.w3.org/2000/01/rdf-schema#> .
"""
_PARTS_IRI = "https://w3id.org/skiros-py/benchmarks/parts"
AT_PLACE = Pose((-0.78, 0.0, 0.0))
"""Where the base stands in the frame of a storage place or of a table."""
_SUPPORT = (-0.07, 0.0)
"""Middle of the surface on which parts lie, in the frame of a storage place [m]."""
_KIT_AT = (-0.05, 0.0)
"""Where a kit stands on its table [m]."""
_FLOOR = 0.006
"""Thickness of the bottom of a kit [m]."""
_PLAY = 0.003
"""Play of a part in its compartment, on each side [m]."""
_BESIDE = 0.06
"""Least distance between parts that stand beside each other [m]."""

T = TypeVar("T")


class Chance:
    """Draws from one half of each range, by the parity of the seed."""

    def __init__(self, seed: int) -> None:
        self._rng = np.random.default_rng(seed)
        self._quarter = 0 if seed % 2 else 1

    def within(self, low: float, high: float) -> float:
        """Returns a number of its half of a range."""
        quarter = self._quarter + 2 * int(self._rng.integers(2))
        return low + (high - low) * (quarter + float(self._rng.uniform())) / 4.0

    def count(self, low: int, high: int) -> int:
        """Returns a whole number of a range, both ends included."""
        return int(self._rng.integers(low, high + 1))

    def sign(self) -> float:
        """Returns 1 or -1."""
        return float(self._rng.choice((-1.0, 1.0)))

    def turn(self, most: float = math.pi) -> float:
        """Returns an angle up to a greatest one to either side [rad]."""
        return float(self._rng.uniform(-most, most))

    def some(self, things: Sequence[T], count: int) -> list[T]:
        """Returns some different things, in any order."""
        return [things[index] for index in self._rng.permutation(len(things))[:count]]


def box(x: float, y: float, z: float, at: tuple[float, float, float]) -> Primitive:
    """Returns a box by its lengths and its middle [m]."""
    return Primitive("box", _rounded(x, y, z), Pose(at))


def cylinder(radius: float, length: float, at: tuple[float, float, float], *, lying: bool = False) -> Primitive:
    """Returns a cylinder by its radius, its length and its middle [m], standing or lying along x."""
    return Primitive("cylinder", _rounded(radius, length), Pose.of(*at, pitch=math.pi / 2.0 if lying else 0.0))


def _rounded(*lengths: float) -> tuple[float, ...]:
    return tuple(round(length, 4) for length in lengths)


@dataclass(frozen=True)
class PartType:
    """A class of parts.

    Attributes:
        name: Its name, with its prefix.
        outline: Lengths along x and y [m].
        grasp_height: Where the fingers close above its frame [m].
        grasp_width: Its width there, across y [m].
        mass: [kg].
        blocks: Its shape; none for a class that an ontology has already.
    """

    name: str
    outline: tuple[float, float]
    grasp_height: float
    grasp_width: float
    mass: float = 0.0
    blocks: tuple[Primitive, ...] = ()

    @property
    def turtle(self) -> str:
        """Its class."""
        return (
            f'{self.name} a owl:Class ; rdfs:subClassOf kitting:Part ; rdfs:label "{self.label}" ;\n'
            f"    sk:mass {self.mass:.2f} ; sk:graspHeight {self.grasp_height:.4f} ;"
            f" sk:graspWidth {self.grasp_width:.4f} ;\n    {_solid(self.blocks)} .\n"
        )

    @property
    def label(self) -> str:
        """Its name without prefix, as goals have it."""
        return self.name.partition(":")[2]


KNOWN = (
    PartType("kitting:Starter", (0.118, 0.049), 0.032, 0.049),
    PartType("kitting:Alternator", (0.060, 0.060), 0.045, 0.060),
    PartType("kitting:Compressor", (0.098, 0.049), 0.045, 0.049),
    PartType("kitting:RelayBox", (0.059, 0.040), 0.032, 0.040),
)
"""The parts of the kitting ontology."""


def own_types(chance: Chance) -> tuple[PartType, ...]:
    """Draws five more classes of parts: a brick, a post, a bracket, a drum and a housing, of up to 3 kg."""
    return tuple(draw(chance) for draw in (_brick, _post, _bracket, _drum, _housing))


def _brick(chance: Chance) -> PartType:
    x, y, z = chance.within(0.075, 0.130), chance.within(0.030, 0.065), chance.within(0.035, 0.060)
    return _own("Brick", chance, (x, y), 0.6 * z, y, box(x, y, z, (0.0, 0.0, z / 2.0)))


def _post(chance: Chance) -> PartType:
    radius, height = chance.within(0.018, 0.033), chance.within(0.055, 0.110)
    block = cylinder(radius, height, (0.0, 0.0, height / 2.0))
    return _own("Post", chance, (2.0 * radius, 2.0 * radius), height - 0.025, 2.0 * radius, block)


def _bracket(chance: Chance) -> PartType:
    x, y, height = chance.within(0.080, 0.120), chance.within(0.050, 0.070), chance.within(0.060, 0.085)
    wide, deep = chance.within(0.030, 0.045), chance.within(0.030, 0.050)
    blocks = box(x, y, 0.015, (0.0, 0.0, 0.0075)), box(deep, wide, height, (0.0, 0.0, height / 2.0))
    return _own("Bracket", chance, (x, y), height - 0.028, wide, *blocks)


def _drum(chance: Chance) -> PartType:
    radius, length = chance.within(0.020, 0.030), chance.within(0.060, 0.110)
    middle = radius + 0.004
    blocks = box(length, 0.030, 0.012, (0.0, 0.0, 0.006)), cylinder(radius, length, (0.0, 0.0, middle), lying=True)
    return _own("Drum", chance, (length, 2.0 * radius), middle, 2.0 * radius, *blocks)


def _housing(chance: Chance) -> PartType:
    x, y = chance.within(0.075, 0.115), chance.within(0.045, 0.065)
    radius, height = chance.within(0.012, 0.018), chance.within(0.015, 0.024)
    knob = cylinder(radius, height, (-x / 4.0, 0.0, 0.040 + height / 2.0))
    return _own("Housing", chance, (x, y), 0.036, y, box(x, y, 0.040, (0.0, 0.0, 0.020)), knob)


def _own(
    name: str, chance: Chance, outline: tuple[float, float], height: float, width: float, *blocks: Primitive
) -> PartType:
    return PartType(f"own:{name}", outline, height, width, chance.within(0.1, 3.0), blocks)


@dataclass(frozen=True)
class Scene:
    """A generated scene.

    Attributes:
        name: Campaign and seed ("standing_3").
        seed: Its seed.
        kind: What is tried in it, where a campaign tries several things.
        types: Its own classes of parts.
        individuals: What is in it, as Turtle.
        goals: Its goal.
        robot: The robot that stands in the middle.
        stands: True where nothing moves the robot.
    """

    name: str
    seed: int
    kind: str
    types: tuple[PartType, ...]
    individuals: tuple[str, ...]
    goals: tuple[str, ...]
    robot: str = "mobile_panda"
    stands: bool = False

    def write(self, folder: Path) -> Path:
        """Writes the scene, and the ontology of its parts into the folder ``parts``; returns the file of the scene."""
        (folder / "parts").mkdir(parents=True, exist_ok=True)
        ontology = f"<{_PARTS_IRI}> a owl:Ontology ; owl:imports <https://w3id.org/skiros-py/kitting> .\n"
        texts = [_PREFIXES, ontology, *(one.turtle for one in self.types)]
        (folder / "parts" / "parts.ttl").write_text("\n".join(texts), encoding="utf-8")
        path = folder / f"{self.name}.ttl"
        path.write_text(self.turtle, encoding="utf-8")
        return path

    @property
    def turtle(self) -> str:
        """The text of the scene file."""
        imports = ("core", "kitting", f"robots/{self.robot}", "benchmarks/parts")
        start = f"scene:{'robot_1 sk:at scene:floor ;' if self.stands else 'base_1'} {_pose(Pose())} .\n"
        files = ", ".join(f"<https://w3id.org/skiros-py/{name}>" for name in imports)
        head = f"<https://w3id.org/skiros-py/scenes/{self.name}> a owl:Ontology ; owl:imports {files} .\n"
        goals = ", ".join(f'"{goal}"' for goal in self.goals)
        this = individual("this", "sk:Scene", f'rdfs:label "{self.name}"', f"sk:goal {goals}")
        return "\n".join([_PREFIXES, head, this, *_HALL, start, *self.individuals])


def individual(name: str, class_: str, *statements: str) -> str:
    """Returns an individual of a scene as Turtle."""
    return f"scene:{name} a {class_} ;\n    " + " ;\n    ".join(statements) + " .\n"


def _pose(pose: Pose) -> str:
    x, y, z = pose.position
    return f'sk:pose "{x:.5f} {y:.5f} {z:.5f} 0 0 {pose.yaw:.5f}"^^sk:poseLiteral'


def _solid(blocks: Sequence[Primitive]) -> str:
    text = [
        {
            "kind": block.kind,
            "size": block.size,
            "at": _rounded(*block.pose.position),
            "rpy": (0.0, math.pi / 2.0 if block.pose.orientation[1] else 0.0, 0.0),
        }
        for block in blocks
    ]
    return f"sk:solid '{json.dumps(text)}'^^rdf:JSON"


_HALL = (
    individual("floor", "sk:Floor", 'sk:size "12.0 12.0"^^sk:vectorLiteral', _pose(Pose())),
    individual("unknown_location", "sk:UnknownLocation", 'rdfs:label "unknown location"'),
)


def storage(name: str, at: Pose, height: float, *more: Primitive) -> str:
    """Returns a storage place with its top at a height [m], and more blocks that belong to it."""
    top = f'sk:supportOffset "{_SUPPORT[0]} {_SUPPORT[1]} {height:.4f}"^^sk:vectorLiteral'
    blocks = [box(0.60, 0.80, height, (0.0, 0.0, height / 2.0)), *more]
    return individual(name, "kitting:Pallet", "sk:on scene:floor", _pose(at), _solid(blocks), top)


def part(name: str, type_: PartType, place: str, at: Pose | None = None, *, frame: str = "") -> str:
    """Returns a part; without a pose it is drawn where on its place it lies."""
    where = [] if at is None else [_pose(at), f"sk:poseFrame scene:{frame or place}"]
    return individual(name, type_.name, f"sk:in scene:{place}", *where)


@dataclass(frozen=True)
class Cell:
    """A compartment of a kit: its name, its middle in the kit and its lengths along x and y [m]."""

    name: str
    x: float
    y: float
    size: tuple[float, float]


def kit(at: Pose, height: float, turned: float, cells: Sequence[Cell] = (), *, wall: float = 0.033) -> list[str]:
    """Returns a table, and on it a kit that is turned by an angle [rad].

    Args:
        at: Where the table stands.
        height: Height of the table [m].
        turned: Angle of the kit on it [rad].
        cells: Its compartments; none for the standard kit of 2 by 2.
        wall: Height of its walls [m].
    """
    stands = at @ Pose.of(*_KIT_AT, height, yaw=turned)
    x, y, z = (dock := stands.inverse() @ at @ AT_PLACE).position
    own = cells or [Cell(f"kit_1_{letter}", i * 0.073, j * 0.073, (0.14, 0.14)) for letter, i, j in _CORNERS]
    text = [
        individual(
            "kit_table",
            "kitting:Table",
            "sk:on scene:floor",
            _pose(at),
            _solid([box(0.60, 0.80, height, (0.0, 0.0, height / 2.0))]),
        ),
        individual(
            "kit_1",
            "kitting:Kit",
            "sk:on scene:kit_table",
            _pose(stands),
            f'sk:drivingPose "{x:.5f} {y:.5f} {z:.5f} 0 0 {dock.yaw:.5f}"^^sk:poseLiteral',
            "sk:hasA " + " , ".join(f"scene:{cell.name}" for cell in own),
            *([_solid(_walls(cells, wall))] if cells else []),
        ),
    ]
    inner = [[_solid([box(*cell.size, wall, (0.0, 0.0, wall / 2.0))])] if cells else [] for cell in own]
    for cell, solid in zip(own, inner, strict=True):
        where = _pose(Pose((cell.x, cell.y, _FLOOR)))
        text.append(individual(cell.name, "kitting:Compartment", "sk:poseFrame scene:kit_1", where, *solid))
    return text


_CORNERS = (("a", -1, 1), ("b", -1, -1), ("c", 1, 1), ("d", 1, -1))


def _walls(cells: Sequence[Cell], wall: float) -> list[Primitive]:
    """Returns the bottom of a kit, and four walls around each compartment."""
    thick = 0.004
    reach_x = max(abs(cell.x) + cell.size[0] / 2.0 for cell in cells) + 0.01
    reach_y = max(abs(cell.y) + cell.size[1] / 2.0 for cell in cells) + 0.01
    blocks = [box(2.0 * reach_x, 2.0 * reach_y, _FLOOR, (0.0, 0.0, _FLOOR / 2.0))]
    for cell in cells:
        (x, y), middle = cell.size, _FLOOR + wall / 2.0
        for side in (-1.0, 1.0):
            along = cell.x + side * (x + thick) / 2.0, cell.y, middle
            across = cell.x, cell.y + side * (y + thick) / 2.0, middle
            blocks += [box(thick, y + 2.0 * thick, wall, along), box(x, thick, wall, across)]
    return blocks


def around(chance: Chance, count: int) -> list[Pose]:
    """Returns where some places stand around the robot, each turned at random, with room to dock at each."""
    first = chance.turn()
    spots = []
    for number in range(count):
        angle = first + 2.0 * math.pi * number / count + chance.turn(0.2)
        distance = chance.within(1.9, 2.6)
        facing = angle + chance.turn(math.radians(40.0))
        spots.append(Pose.of(distance * math.cos(angle), distance * math.sin(angle), 0.0, yaw=facing))
    return spots


# ---------------------------------------------------------------- one generator for each campaign


def standing(seed: int) -> Scene:
    """Two to ten parts of nine types on places of any height; up to four of them are wanted in a kit."""
    chance = Chance(seed)
    types = own_types(chance)
    drawn = [chance.some((*KNOWN, *types), 1)[0] for _ in range(chance.count(2, 10))]
    places = [f"pallet_{number + 1}" for number in range(math.ceil(len(drawn) / 4))]
    *spots, table = around(chance, len(places) + 1)
    text = [storage(name, at, chance.within(0.4, 1.1)) for name, at in zip(places, spots, strict=True)]
    text += kit(table, chance.within(0.4, 1.1), chance.turn())
    text += [part(f"part_{n}", type_, places[n % len(places)]) for n, type_ in enumerate(drawn, start=1)]
    distinct = list(dict.fromkeys(drawn))
    wanted = chance.some(distinct, min(4, len(distinct)))
    goals = [f"ObjectAtLocation({type_.label}, kit_1_{c})" for type_, c in zip(wanted, "abcd", strict=False)]
    return Scene(f"standing_{seed}", seed, f"{len(drawn)} parts", types, tuple(text), tuple(goals))


def pallet(seed: int, robot: str, *, stands: bool) -> Scene:
    """Five to seven parts of at least five types on one pallet; four of them are wanted in a kit, the rest is clutter.

    Args:
        seed: Its seed.
        robot: The robot.
        stands: True where nothing moves the robot: pallet and kit are then within its reach.
    """
    chance = Chance(seed)
    types = own_types(chance)
    drawn = chance.some((*KNOWN, *types), 5)
    wanted = drawn[:4]
    drawn += chance.some(drawn[4:] + [one for one in types if one not in drawn], chance.count(0, 2))
    if stands:
        first = chance.turn()
        angles = first, first + chance.sign() * chance.within(math.pi / 2.0, math.pi)
        spots = [Pose.of(r * math.cos(a), r * math.sin(a), 0.0, yaw=a) for a in angles for r in [0.85]]
    else:
        spots = around(chance, 2)
    wide = 'sk:supportHalfExtents "0.14 0.28"^^sk:vectorLiteral'
    stored = storage("pallet_1", spots[0], chance.within(0.4, 0.7)).replace(" ;\n", f" ;\n    {wide} ;\n", 1)
    text = [stored, *kit(spots[1], chance.within(0.4, 0.7), chance.turn())]
    text += [part(f"part_{n}", type_, "pallet_1") for n, type_ in enumerate(drawn, start=1)]
    goals = [f"ObjectAtLocation({type_.label}, kit_1_{c})" for type_, c in zip(wanted, "abcd", strict=True)]
    name = f"pallet_{robot}_{seed}"
    return Scene(name, seed, f"{len(drawn)} parts", types, tuple(text), tuple(goals), robot, stands)


def reach(seed: int) -> Scene:
    """A part under the board of a shelf, behind walls, or between neighbours 60 mm from it; it is to be taken."""
    chance = Chance(seed)
    types = own_types(chance)
    kind = ("shelf", "walls", "neighbours")[seed // 2 % 3]
    at, height = Pose.of(1.9, 0.0, 0.0, yaw=chance.turn(0.6)), chance.within(0.4, 0.8)
    more: list[Primitive] = []
    if kind == "shelf":
        above, depth = height + chance.within(0.45, 0.75), chance.within(0.2, 0.6)
        more = [box(0.60, 0.02, above - height, (0.0, side * 0.41, (above + height) / 2.0)) for side in (-1.0, 1.0)]
        more.append(box(depth, 0.84, 0.02, (0.30 - depth / 2.0, 0.0, above + 0.01)))
    elif kind == "walls":
        wall, side = chance.within(0.08, 0.25), chance.sign()
        more = [box(0.02, 0.80, wall, (-0.24, 0.0, height + wall / 2.0))]
        more.append(box(0.50, 0.02, wall, (0.0, side * 0.23, height + wall / 2.0)))
    wanted, *others = chance.some((*KNOWN, *types), 5)
    text = [storage("pallet_1", at, height, *more)]
    if kind == "neighbours":
        text += _between(chance, wanted, others[: chance.count(2, 4)], height)
    else:
        text.append(part("part_1", wanted, "pallet_1"))
    return Scene(f"reach_{seed}", seed, kind, types, tuple(text), ("Holding(gripper_1, part_1)",))


def _between(chance: Chance, wanted: PartType, others: Sequence[PartType], height: float) -> list[str]:
    """Returns a part in the middle, and others on its sides, 60 mm from it."""
    middle = Pose.of(*_SUPPORT, height, yaw=chance.turn(0.3))
    text = [part("part_1", wanted, "pallet_1", middle)]
    for number, other in enumerate(others):
        axis, side = number // 2, -1.0 if number % 2 else 1.0
        off = side * ((wanted.outline[1 - axis] + other.outline[1 - axis]) / 2.0 + _BESIDE)
        at = middle @ Pose((0.0, off, 0.0) if axis == 0 else (off, 0.0, 0.0))
        text.append(part(f"part_{number + 2}", other, "pallet_1", at))
    return text


def compartments(seed: int) -> Scene:
    """A half full kit whose compartments have 3 mm of play on each side; two parts are wanted in it."""
    chance = Chance(seed)
    types = own_types(chance)
    pair = chance.some((*KNOWN, *types), 2)
    cells, filled = [], []
    wide = max(type_.outline[1] for type_ in pair) + _BESIDE + 2.0 * _PLAY
    deep = sum(type_.outline[0] for type_ in pair) / 2.0 + 0.03
    for row, type_ in enumerate(pair):
        size = type_.outline[0] + 2.0 * _PLAY, type_.outline[1] + 2.0 * _PLAY
        row_cells = [Cell(f"kit_1_{'abcdef'[3 * row + c]}", (row - 0.5) * deep, (c - 1) * wide, size) for c in range(3)]
        cells += row_cells
        full = chance.some(row_cells, 1)[0]
        filled.append(part(f"part_{row + 3}", type_, full.name, Pose((0.0, 0.0, 0.0005))))
    wall = max(0.008, min(type_.grasp_height for type_ in pair) - 0.015)
    pallet, table = around(chance, 2)
    text = [storage("pallet_1", pallet, chance.within(0.4, 0.7))]
    text += kit(table, chance.within(0.4, 0.7), chance.turn(0.5), cells, wall=min(0.033, wall))
    text += [part(f"part_{n}", type_, "pallet_1") for n, type_ in enumerate(pair, start=1)] + filled
    goals = ("InKit(part_1, kit_1)", "InKit(part_2, kit_1)")
    return Scene(f"compartments_{seed}", seed, " and ".join(t.label for t in pair), types, tuple(text), goals)


def shifted(seed: int) -> Scene:
    """A part among two others; somebody moves it while the robot is about to take it."""
    chance = Chance(seed)
    return _one_part(f"shifted_{seed}", seed, chance, ("look", "exact look", "approach")[seed // 2 % 3])


def misplaced(seed: int) -> Scene:
    """A storage place, a kit with its table, or a rack that is not where the scene says."""
    chance = Chance(seed)
    return _one_part(f"misplaced_{seed}", seed, chance, ("pallet_1", "kit_table", "rack_1")[seed // 2 % 3])


def _one_part(name: str, seed: int, chance: Chance, kind: str) -> Scene:
    types = own_types(chance)
    pallet, table = around(chance, 2)
    text = [storage("pallet_1", pallet, chance.within(0.4, 0.7)), *kit(table, chance.within(0.4, 0.7), chance.turn())]
    drawn = chance.some((*KNOWN, *types), 3)
    text += [part(f"part_{n}", type_, "pallet_1") for n, type_ in enumerate(drawn, start=1)]
    if kind == "rack_1":  # beside the way from the one to the other
        x, y, _ = pallet.position
        at = Pose.of(-y / math.hypot(x, y), x / math.hypot(x, y), 0.0, yaw=chance.turn())
        solid = _solid([box(0.4, 0.8, 1.2, (0.0, 0.0, 0.6))])
        text.append(individual("rack_1", "kitting:Rack", "sk:on scene:floor", _pose(at), solid))
    return Scene(name, seed, kind, types, tuple(text), ("ObjectAtLocation(part_1, kit_1_a)",))


def unknown(seed: int) -> Scene:
    """A place to drive to, or a part to be taken; something that no scene names comes into the way."""
    chance = Chance(seed)
    types = own_types(chance)
    kind = ("base before", "base during", "arm before", "arm during")[seed // 2 % 4]
    far = 4.0 if kind.startswith("base") else 1.9
    text = [storage("pallet_1", Pose.of(far, 0.0, 0.0, yaw=chance.turn(0.3)), chance.within(0.4, 0.7))]
    drawn = chance.some((*KNOWN, *types), 2)
    text += [part(f"part_{n}", type_, "pallet_1") for n, type_ in enumerate(drawn, start=1)]
    goal = "RobotAtLocation(robot_1, pallet_1)" if kind.startswith("base") else "Holding(gripper_1, part_1)"
    return Scene(f"unknown_{seed}", seed, kind, types, tuple(text), (goal,))


WIDTH = 0.61
"""Width of the robot [m]."""


def docking(seed: int) -> Scene:
    """Three places to dock at one after the other, or a passage 0.1 m wider than the robot."""
    chance = Chance(seed)
    if seed // 2 % 2:
        at, length = Pose.of(2.0, chance.within(-0.5, 0.5), 0.0, yaw=chance.turn(0.3)), chance.within(0.2, 1.2)
        aside = (WIDTH + 0.1) / 2.0 + 2.5
        text = []
        for name, side in (("rack_1", -1.0), ("rack_2", 1.0)):
            solid = _solid([box(length, 5.0, 1.2, (0.0, 0.0, 0.6))])
            stands = at @ Pose((0.0, side * aside, 0.0))
            text.append(individual(name, "kitting:Rack", "sk:on scene:floor", _pose(stands), solid))
        behind = at @ Pose.of(length / 2.0 + 2.4, chance.within(-0.4, 0.4), 0.0, yaw=chance.turn(0.3))
        text.append(storage("pallet_1", behind, 0.45))
        return Scene(f"docking_{seed}", seed, "passage", (), tuple(text), ("RobotAtLocation(robot_1, pallet_1)",))
    spots = around(chance, 3)
    text = [storage(f"pallet_{n}", at, chance.within(0.4, 1.1)) for n, at in enumerate(spots, start=1)]
    return Scene(f"docking_{seed}", seed, "docks", (), tuple(text), ("RobotAtLocation(robot_1, pallet_1)",))
