"""Lanes in which robots meet, narrow passages and docks: generated scenes, and what happens in them, in physics.

Two rooms are connected by a lane that takes one robot at a time. Robots stand in it head on, and each wants to the
room behind the other. Widths, lengths, distances, sideways offsets, headings, who is told first, and whether there is
room to give way in the rooms depend on the seed.
"""

from __future__ import annotations

import math
import random
import sys
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import cycle, islice
from pathlib import Path

from skiros_py.execution.monitor import ModuleEvent
from skiros_py.geometry import Pose, wrap_angle
from skiros_py.simulation.truth import Truth
from skiros_py.skills.outcome import Failure, Outcome, Success
from skiros_py.skills.surroundings import map_pose
from skiros_py.station.session import Options, Session
from skiros_py.world import vocabulary as v

WEST, EAST = -1.0, 1.0
_HALL = 7.0
"""Width of the rooms [m]."""
_ROOMY = 2.0
"""Rooms that are shorter are dead ends, as wide as the lane [m]."""
_LONGEST = 240.0
"""When a meeting is broken off [s]."""
_BEFORE_WALL, _BESIDE = 0.75, 2.0
"""Where a goal is in a room: before its end, and beside the middle, where no other robot passes [m]."""
_EVERY = 5
"""Cycles between two looks at what touches what."""

_SCENE = """
@prefix scene: <https://w3id.org/skiros-py/scene#> .
@prefix kitting: <https://w3id.org/skiros-py/kitting#> .
@prefix sk: <https://w3id.org/skiros-py/core#> .
@prefix owl: <http://www.w3.org/2002/07/owl#> .
@prefix rdf: <http://www.w3.org/1999/02/22-rdf-syntax-ns#> .
@prefix rdfs: <http://www.w3.org/2000/01/rdf-schema#> .

<https://w3id.org/skiros-py/scenes/lane> a owl:Ontology ;
    owl:imports <https://w3id.org/skiros-py/core> , <https://w3id.org/skiros-py/kitting> ,
        <https://w3id.org/skiros-py/robots/mobile_panda> .

scene:this a sk:Scene ; rdfs:label "a lane" .
scene:unknown_location a sk:UnknownLocation ; rdfs:label "unknown location" .
scene:floor a sk:Floor ; rdfs:label "floor" ; sk:pose "0 0 0 0 0 0"^^sk:poseLiteral ;
    sk:size "{length:g} {width:g}"^^sk:vectorLiteral .
"""
_WALL = """
scene:wall_{number} a kitting:Rack ; rdfs:label "wall {number}" ; sk:on scene:floor ;
    sk:pose "{x:.3f} {y:.3f} 0 0 0 {yaw:.3f}"^^sk:poseLiteral ;
    sk:solid '[{{"kind": "box", "size": [{length:.3f}, {width:.3f}, 1.0], "at": [0, 0, 0.5]}}]'^^rdf:JSON .
"""
_ROBOT = """
scene:base_{number} sk:pose "{x:.3f} {y:.3f} 0 0 0 {yaw:.3f}"^^sk:poseLiteral .
scene:goal_{number} a kitting:ParkingPlace ; rdfs:label "goal {number}" ; sk:on scene:floor ;
    sk:pose "{goal_x:.3f} {goal_y:.3f} 0 0 0 {goal_yaw:.3f}"^^sk:poseLiteral .
"""
_FURTHER = 'scene:robot_{number} a sk:Robot ; rdfs:label "robot {number}" ; sk:builtLike scene:robot_1 .\n'


@dataclass(frozen=True, slots=True)
class Traveller:
    """One robot in a lane.

    Attributes:
        x: Where along the lane it stands, 0 in the middle [m].
        y: How far beside the middle [m].
        towards: WEST or EAST: the room that it wants to; it faces it.
        yaw: By how much it faces elsewhere [rad].
        waits: True if it is not told to go.
    """

    x: float
    y: float
    towards: float
    yaw: float = 0.0
    waits: bool = False


@dataclass(frozen=True, slots=True)
class Lane:
    """A lane between two rooms, and the robots in it.

    Attributes:
        length: Its length [m].
        width: Its width [m].
        rooms: Length of the western and of the eastern room [m]; one of less than 2 m is a dead end of the lane.
        robots: The robots.
        first: Numbers of the robots, in the order in which they are told to go.
    """

    length: float
    width: float
    rooms: tuple[float, float]
    robots: tuple[Traveller, ...]
    first: tuple[int, ...]

    @property
    def has_no_room(self) -> bool:
        """Whether no robot can give way."""
        return max(self.rooms) < _ROOMY

    def scene(self) -> str:
        """Returns the scene, as Turtle."""
        west, east = self.rooms
        hall, half = self.length + west + east, self.length / 2.0
        middle = (east - west) / 2.0
        side = (_HALL - self.width) / 2.0
        beyond = [room if room < _ROOMY else 0.0 for room in self.rooms]
        narrow, shift = self.length + sum(beyond), (beyond[1] - beyond[0]) / 2.0
        walls = [(shift, sign * (self.width + side) / 2.0, narrow, side) for sign in (-1.0, 1.0)]
        walls += [(middle, sign * (_HALL / 2.0 + 0.1), hall + 0.4, 0.2) for sign in (-1.0, 1.0)]
        walls += [(-half - west - 0.1, 0.0, 0.2, _HALL), (half + east + 0.1, 0.0, 0.2, _HALL)]
        text = _SCENE.format(length=2.0 * (half + max(self.rooms)) + 1.0, width=_HALL + 1.0)
        for number, (x, y, length, width) in enumerate(walls, start=1):
            text += _WALL.format(number=number, x=x, y=y, yaw=0.0, length=length, width=width)
        for number, robot in enumerate(self.robots, start=1):
            room = west if robot.towards == WEST else east
            facing = 0.0 if robot.towards == EAST else math.pi
            beside = 0.0 if room < _ROOMY else _BESIDE * (-1) ** number
            goal = robot.towards * (half + room - _BEFORE_WALL), beside
            text += _FURTHER.format(number=number) * (number > 1)
            text += _ROBOT.format(
                number=number, x=robot.x, y=robot.y, yaw=facing + robot.yaw, goal_x=goal[0], goal_y=goal[1],
                goal_yaw=facing,
            )  # fmt: skip
        return text


def head_on(seed: int) -> Lane:
    """Returns a lane with two robots head on; in every fifth there is no room to give way in either room."""
    chance = random.Random(seed)  # noqa: S311
    width, length = chance.uniform(1.45, 2.1), chance.uniform(4.0, 8.0)
    beside = (width - 1.4) / 2.0
    gap = chance.uniform(1.4, min(3.0, length - 1.5))
    shift = chance.uniform(-0.5, 0.5) * (length - 1.2 - gap)
    robots = tuple(
        Traveller(shift - side * gap / 2.0, chance.uniform(-beside, beside), side, chance.uniform(-0.2, 0.2))
        for side in (EAST, WEST)
    )
    roomy = (4.0, 4.0), (4.0, 1.5), (1.5, 4.0), (4.0, 4.0), (1.5, 1.5)
    return Lane(length, width, roomy[seed % 5], robots, tuple(chance.sample((0, 1), 2)))


@dataclass(frozen=True, slots=True)
class Meeting:
    """What happened.

    Attributes:
        stood: Simulated time from when the first of them stood for another until one gives way or says why not [s];
            infinite if neither happens.
        outcomes: How each robot's drive ended; None if it has not.
        gave_way: Numbers of the robots that did.
        lasted: Simulated time until all had ended [s].
        touches: Which robots touched which bodies.
    """

    stood: float
    outcomes: tuple[Outcome | None, ...]
    gave_way: tuple[int, ...]
    lasted: float
    touches: tuple[str, ...]


def meet(lane: Lane, seed: int, disturb: Callable[[Session, float], None] = lambda _session, _time: None) -> Meeting:
    """Lets the robots of a lane drive, in physics.

    Args:
        lane: The lane.
        seed: Seed of the run.
        disturb: Called in each cycle, with the time since the start [s].
    """
    with tempfile.TemporaryDirectory() as folder:
        scene = Path(folder) / "lane.ttl"
        scene.write_text(lane.scene(), encoding="utf-8")
        with Session(str(scene), Options(seed=seed)) as session:
            return _meet(session, lane, disturb)


def _meet(session: Session, lane: Lane, disturb: Callable[[Session, float], None]) -> Meeting:
    truth = Truth(session.simulation)
    begin = session.cycle.board.snapshot.time
    waits: list[float] = []
    ends: list[float] = []
    gave_way: list[int] = []

    def note(event: ModuleEvent) -> None:
        if event.text.startswith("waits for robot_"):
            waits.append(event.time)
        if event.text.startswith("makes room for"):
            gave_way.append(int(event.agent.rpartition("_")[2]))
            ends.append(event.time)

    session.monitor.subscribe(note)
    running = {
        number: session.start_module("drive", {"Location": f"goal_{number + 1}"}, f"base_{number + 1}")
        for number in lane.first
        if not lane.robots[number].waits
    }
    while not all(one.done for one in running.values()):
        session.cycle.step()
        now = session.cycle.board.snapshot.time
        if session.cycle.board.snapshot.cycle % _EVERY == 0:
            truth.watch()
        if not ends and any(one.done and isinstance(one.result, Failure) for one in running.values()):
            ends.append(now)
        disturb(session, now - begin)
        if now - begin > _LONGEST:
            break
    outcomes = tuple(
        running[number].result if number in running and running[number].done else None
        for number in range(len(lane.robots))
    )
    stood = 0.0 if not waits else min(ends, default=float("inf")) - waits[0]
    touches = sorted({f"{link} - {body}" for link, body in truth.worst if body != "floor"})
    return Meeting(stood, outcomes, tuple(gave_way), now - begin, tuple(touches))


_SPARE = 0.1
"""By how much passages are wider than the robot [m]."""
_WIDTH = 0.61
"""Width of the robot [m]."""
_ENDLESS = 12.0
"""Length of the walls beside a passage: there is no way around them [m]."""


@dataclass(frozen=True, slots=True)
class Passing:
    """A drive through a passage.

    Attributes:
        seed: Seed of the scene and of the run.
        outcome: How it ended; None if it has not.
        touches: What touched which bodies.
    """

    seed: int
    outcome: Outcome | None
    touches: tuple[str, ...]


def passage(seed: int) -> str:
    """Returns a scene, as Turtle: a passage between two walls, 0.1 m wider than the robot, between it and its goal.

    Thickness, place and direction of the walls, and where robot and goal are, depend on the seed.
    """
    chance = random.Random(seed)  # noqa: S311
    thick, turned, beside = chance.uniform(0.1, 1.5), chance.uniform(-0.6, 0.6), chance.uniform(-0.8, 0.8)
    x, y = chance.uniform(2.2, 3.0), chance.uniform(-0.5, 0.5)
    away = (_WIDTH + _SPARE + _ENDLESS) / 2.0
    text = _SCENE.format(length=2.0 * _ENDLESS, width=2.0 * _ENDLESS)
    for number, sign in enumerate((-1.0, 1.0), start=1):
        at = x - sign * away * math.sin(turned), y + sign * away * math.cos(turned)
        text += _WALL.format(number=number, x=at[0], y=at[1], yaw=turned, length=thick, width=_ENDLESS)
    goal = x + chance.uniform(2.2, 3.0), y + beside
    return text + _ROBOT.format(
        number=1, x=0.0, y=0.0, yaw=chance.uniform(-1.0, 1.0), goal_x=goal[0], goal_y=goal[1],
        goal_yaw=chance.uniform(-0.8, 0.8),
    )  # fmt: skip


def pass_through(seed: int) -> Passing:
    """Lets a robot drive through the passage of a seed, in physics."""
    with tempfile.TemporaryDirectory() as folder:
        scene = Path(folder) / "passage.ttl"
        scene.write_text(passage(seed), encoding="utf-8")
        with Session(str(scene), Options(seed=seed)) as session:
            truth = Truth(session.simulation)
            outcome = _drive(session, "goal_1", truth.watch)
            touches = sorted({f"{link} - {body}" for link, body in truth.worst if body != "floor"})
            return Passing(seed, outcome, tuple(touches))


def pass_all(seeds: Sequence[int]) -> list[Passing]:
    """Lets a robot drive through the passage of each seed, and says how it went."""
    found = []
    for passing in map(pass_through, seeds):
        said = passing.outcome.reason if isinstance(passing.outcome, Failure) else "through"
        touches = ", ".join(passing.touches) or "nothing"
        print(f"passage {passing.seed}: {said}, touched {touches}", file=sys.stderr, flush=True)
        found.append(passing)
    return found


def dock_all(drives: int, seed: int) -> list[tuple[float, float] | None]:
    """Lets the robot of the kitting scene drive from dock to dock.

    Args:
        drives: How often.
        seed: Seed of the run.

    Returns:
        For each drive how far its pose as localised is from the driving pose [m, rad]; None where the drive failed.
    """
    found: list[tuple[float, float] | None] = []
    with Session("kitting", Options(seed=seed)) as session:
        context = session.runtime.context
        base = context.cell.group_of("base_1")
        for place in islice(cycle(("pallet_a", "kit_1", "pallet_b", "pallet_a", "pallet_b", "kit_1")), drives):
            there, driving = map_pose(context, place), context.world.value(place, v.DRIVING_POSE)
            if isinstance(_drive(session, place), Success) and there is not None and isinstance(driving, Pose):
                goal, here = there @ driving, base.pose(context.board.snapshot, context.board.guard)
                found.append((goal.distance(here), abs(wrap_angle(goal.yaw - here.yaw))))
            else:
                found.append(None)
    return found


def _drive(session: Session, location: str, watch: Callable[[], None] = lambda: None) -> Outcome | None:
    """Drives to a location; returns the outcome, or None if it takes too long."""
    begin = session.cycle.board.snapshot.time
    running = session.start_module("drive", {"Location": location}, "base_1")
    while not running.done and session.cycle.board.snapshot.time - begin < _LONGEST:
        session.cycle.step()
        watch()
    return running.result if running.done else None


def meet_all(seeds: Sequence[int]) -> list[Meeting]:
    """Lets two robots meet head on in the lane of each seed, and says how it went."""
    found = []
    for seed in seeds:
        lane = head_on(seed)
        met = meet(lane, seed)
        said = "; ".join(one.reason if isinstance(one, Failure) else "arrives" for one in met.outcomes if one)
        print(f"lane {seed}: {lane.width:.2f} x {lane.length:.1f} m, rooms {lane.rooms}: stood {met.stood:.1f} s, ends "
              f"after {met.lasted:.0f} s, makes room: {met.gave_way}; {said}", file=sys.stderr, flush=True)  # fmt: skip
        found.append(met)
    return found
