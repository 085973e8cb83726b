"""Tasks of the tiny domain without a plan, drawn from a seed, with the cause that follows from their modification.

Each mutation starts from a task that has a plan and modifies one thing; the expected cause is defined with the
modification, independently of the explanation.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from random import Random

from skiros_py.planning.plan import Cause, CauseKind
from skiros_py.planning.problem.task import Capability
from skiros_py.skills.conditions import AllOf, Compare, Condition, ConditionType, Exists, Related, Role
from skiros_py.skills.parameters import Kind, Param
from skiros_py.skills.skill import SkillDescription
from skiros_py.testing.tiny import (
    AT_LOCATION,
    DRIVE,
    EMPTY_HANDED,
    HAS_PART,
    HOLDING,
    IN_CONTAINER,
    PICK,
    PLACE,
    tiny_world,
)
from skiros_py.world.vocabulary import DRIVING_POSE, HAS_A, IN
from skiros_py.world.world import World

_OPENING = "tiny:opening"

IN_TRAY = ConditionType(
    "InTray",
    (Role("ball", "tiny:Ball"), Role("tray", "sk:Container")),
    Exists("slot", "tiny:Slot", AllOf((Related(HAS_A, "tray", "slot"), Related(IN, "ball", "slot")))),
    "It lies in some slot of the tray.",
    abstract=True,
)
OPEN = ConditionType("Open", (Role("door", "tiny:Door"),), Compare(_OPENING, "=", "door", "open"), "It stands open.")
AJAR = ConditionType("Ajar", (Role("door", "tiny:Door"),), Compare(_OPENING, "=", "door", "ajar"), "A little open.")
CHARGED = ConditionType("Charged", (Role("robot", "sk:Robot"),), Compare("tiny:charge", ">=", "robot", 20.0), "It is.")
KNOWS = ConditionType(
    "Knows",
    (Role("robot", "sk:Robot"), Role("location", "sk:Location")),
    Related("tiny:knows", "robot", "location"),
    "It was shown the location.",
)

_DOOR = (
    Param("Base", "sk:Base", "The base that pushes.", Kind.HARDWARE),
    Param("Robot", "sk:Robot", "The robot it carries.", Kind.PLANNING),
    Param("Door", "tiny:Door", "The door."),
)


def _pushing(name: str, word: ConditionType) -> SkillDescription:
    return SkillDescription(
        name=name,
        help="Pushes a door.",
        agent="Base",
        target="Door",
        params=_DOOR,
        pre=(HAS_PART("Robot", "Base"), AT_LOCATION("Robot", "Door")),
        post=(word("Door"),),
    )


_SKILLS = (DRIVE, PICK, PLACE, _pushing("open", OPEN), _pushing("set_ajar", AJAR))


@dataclass(frozen=True, slots=True)
class Expected:
    """The cause that must be found.

    Attributes:
        kind: Its kind.
        elements: What it must name, at least.
        skill: The skill that it must name; None where it need not name any.
    """

    kind: CauseKind
    elements: frozenset[str] = frozenset()
    skill: str | None = None

    def is_met(self, cause: Cause) -> bool:
        """Returns whether a cause is the expected one."""
        named = self.skill is None or cause.skill == self.skill
        return cause.kind is self.kind and named and self.elements <= set(cause.elements)


@dataclass(frozen=True, slots=True)
class Mutation:
    """A modified task.

    Attributes:
        name: How it was spoilt.
        world: The world.
        capabilities: The skills that are there.
        goal: What cannot be reached.
        spoilt: The conditions that the cause is about.
        expected: The cause.
        again: Draws the very same task in a new world.
    """

    name: str
    world: World
    capabilities: tuple[Capability, ...]
    goal: tuple[Condition, ...]
    spoilt: tuple[Condition, ...]
    expected: Expected
    again: Callable[[], Mutation] | None = None

    def is_explained(self, causes: Sequence[Cause]) -> bool:
        """Returns whether the only cause is the expected one, for the expected conditions."""
        return len(causes) == 1 and self.expected.is_met(causes[0]) and set(causes[0].conditions) == set(self.spoilt)


def mutations(seed: int, rounds: int = 2) -> Iterator[Mutation]:
    """Draws modified tasks: each kind of modification a number of times, each in a world of its own.

    Args:
        seed: Where the random numbers start.
        rounds: How often each way is drawn.
    """
    for number in range(rounds):
        for spoil in _WAYS:
            yield _drawn(spoil, f"{seed} {number} {spoil.__name__}")


def _drawn(spoil: Callable[[_Draw], Mutation], key: str) -> Mutation:
    return replace(spoil(_Draw(Random(key))), again=partial(_drawn, spoil, key))  # noqa: S311  no secrets here


class _Draw:
    """A random world in which the rest of a goal is reachable, and methods to modify it."""

    def __init__(self, random: Random) -> None:
        self.random = random
        self.robots = random.choice((1, 2))
        self.balls = [f"ball_{n}" for n in range(1, random.randint(4, 8))]
        self.trays = {f"tray_{n}": [f"tray_{n}_{m}" for m in range(1, random.randint(3, 5))] for n in (1, 2)}
        self.skills = {skill.name: skill for skill in _SKILLS}
        self.unable: dict[str, tuple[str, ...]] = {}
        self.world = self._world()

    def _world(self) -> World:
        boxes = ("box_a", "box_b")
        facts = [f"scene:{b} a tiny:Ball ; sk:in scene:{self.random.choice(boxes)} ." for b in self.balls[1:]]
        for tray, slots in self.trays.items():
            has = " , ".join(f"scene:{slot}" for slot in slots)
            facts.append(f"scene:{tray} a sk:Container ; sk:on scene:floor ; sk:hasA {has} .")
            facts += [f"scene:{slot} a tiny:Slot ." for slot in slots]
        pose = '"-1 0 0 0 0 0"^^sk:poseLiteral'
        facts += [f"scene:door_{n} a tiny:Door ; sk:on scene:floor ; sk:drivingPose {pose} ." for n in (1, 2)]
        return tiny_world(*facts, robots=self.robots)

    # ------------------------------------------------------------ spoiling

    def without_skill(self, name: str, agents: Sequence[str]) -> None:
        """Removes a skill from some of its subsystems."""
        self.unable[name] = tuple(agents)

    def needing(self, name: str, condition: Condition) -> None:
        """Adds a precondition to a skill."""
        self.skills[name] = replace(self.skills[name], pre=(*self.skills[name].pre, condition))

    def moved(self, element: str, relation: str, place: str) -> None:
        """Moves an element to another place."""
        with self.world.transaction("mutation", "moved") as tx:
            tx.place(element, relation, place)

    def added(self, class_: str, name: str, place: str) -> str:
        """Adds an element at a place."""
        with self.world.transaction("mutation", "added") as tx:
            tx.add(class_, id=name)
            tx.place(name, IN, place)
        return name

    def set(self, element: str, property_: str, value: float | None) -> None:
        """Sets a property."""
        with self.world.transaction("mutation", "set") as tx:
            tx.set(element, property_, value)

    def related(self, subject: str, relation: str, object_: str) -> None:
        """Adds a relation."""
        with self.world.transaction("mutation", "stated") as tx:
            tx.relate(subject, relation, object_)

    # ------------------------------------------------------------ drawing

    def ball(self) -> str:
        """Draws a ball that is not red."""
        return self.random.choice(self.balls)

    def pair(self) -> tuple[str, str]:
        """Draws two balls that are not red."""
        one, other = self.random.sample(self.balls, 2)
        return one, other

    def agents(self, kind: str) -> tuple[str, ...]:
        """Returns the subsystems of a kind, of all robots."""
        return tuple(f"{kind}_{n}" for n in range(1, self.robots + 1))

    def robot(self) -> str:
        """Draws a robot's number."""
        return str(self.random.randint(1, self.robots))

    def made(
        self,
        name: str,
        spoilt: Sequence[Condition],
        kind: CauseKind,
        elements: Sequence[str] = (),
        skill: str | None = None,
    ) -> Mutation:
        """Makes the mutation, usually with a further, reachable condition in the goal."""
        able = tuple(
            Capability(s, tuple(a for a in self.world.instances(s.agent_class) if a not in self.unable.get(s.name, ())))
            for s in self.skills.values()
        )
        more = [OPEN("door_2")] if self.random.random() < 0.7 and "open" in self.skills else []
        if set(self.unable) & {"drive", "open"} or "Charged" in str(self.skills["drive"].pre):
            more = []
        goal = [*spoilt, *more]
        self.random.shuffle(goal)
        expected = Expected(kind, frozenset(elements), skill)
        return Mutation(name, self.world, able, tuple(goal), tuple(spoilt), expected)


# ------------------------------------------------------------------ skills and robots


def _nobody_places(draw: _Draw) -> Mutation:
    draw.without_skill("place", draw.agents("arm"))
    goal = IN_CONTAINER(draw.ball(), "slot_1")
    return draw.made("no subsystem has the skill", [goal], CauseKind.NO_SKILL, draw.agents("arm"), "place")


def _nobody_picks(draw: _Draw) -> Mutation:
    draw.without_skill("pick", draw.agents("arm"))
    goal = IN_TRAY(draw.ball(), "tray_1")
    return draw.made("no subsystem has the skill before", [goal], CauseKind.NO_SKILL, draw.agents("arm"), "pick")


def _robot_cannot_drive(draw: _Draw) -> Mutation:
    number = draw.robot()
    draw.without_skill("drive", [f"base_{number}"])
    goal = AT_LOCATION(f"robot_{number}", draw.random.choice(("box_a", "box_b", "door_1")))
    return draw.made("this robot lacks the skill", [goal], CauseKind.NO_SKILL, [f"base_{number}"], "drive")


def _skill_unknown(draw: _Draw) -> Mutation:
    del draw.skills["set_ajar"]
    return draw.made("no such skill is installed", [AJAR("door_1")], CauseKind.NO_SKILL, ["door_1"])


def _no_gripper(draw: _Draw) -> Mutation:
    with draw.world.transaction("mutation", "taken off") as tx:
        for gripper in draw.agents("gripper"):
            tx.remove(gripper)
    goal = IN_CONTAINER(draw.ball(), "slot_2")
    return draw.made("no gripper", [goal], CauseKind.MISSING_ELEMENT, ["sk:Gripper"])


# ------------------------------------------------------------------ facts


def _lost(draw: _Draw) -> Mutation:
    ball = draw.ball()
    draw.moved(ball, "sk:on", draw.random.choice(("unknown_location", "floor")))
    goal = draw.random.choice((IN_CONTAINER(ball, "slot_1"), IN_TRAY(ball, "tray_2")))
    return draw.made("the part lies where no skill takes it from", [goal], CauseKind.MISSING_FACT, [ball], "pick")


def _no_driving_pose(draw: _Draw) -> Mutation:
    draw.set("door_1", DRIVING_POSE, None)
    goal = draw.random.choice((OPEN("door_1"), AT_LOCATION("robot_1", "door_1")))
    return draw.made("no driving pose was taught", [goal], CauseKind.MISSING_FACT, ["door_1"], "drive")


def _flat_battery(draw: _Draw) -> Mutation:
    draw.needing("drive", CHARGED("Robot"))
    number = draw.robot()
    for other in range(1, draw.robots + 1):
        draw.set(f"robot_{other}", "tiny:charge", 5.0 if str(other) == number else 80.0)
    goal = AT_LOCATION(f"robot_{number}", "box_b")
    return draw.made("the battery is flat", [goal], CauseKind.MISSING_FACT, [f"robot_{number}"], "drive")


def _never_shown(draw: _Draw) -> Mutation:
    draw.needing("drive", KNOWS("Robot", "Location"))
    for number in range(1, draw.robots + 1):
        for place in ("box_a", "box_b", "door_2"):
            draw.related(f"robot_{number}", "tiny:knows", place)
    robot = f"robot_{draw.robot()}"
    goal = AT_LOCATION(robot, "door_1")
    return draw.made("never shown", [goal], CauseKind.MISSING_FACT, [robot, "door_1"], "drive")


def _none_of_class(draw: _Draw) -> Mutation:
    goal = draw.random.choice((IN_CONTAINER("tiny:Giant", "slot_1"), IN_TRAY("tiny:Giant", "tray_1")))
    return draw.made("there is none of the class", [goal], CauseKind.MISSING_ELEMENT, ["tiny:Giant"])


def _too_big(draw: _Draw) -> Mutation:
    giant = draw.added("tiny:Giant", "giant_1", draw.random.choice(("box_a", "box_b")))
    slot = draw.random.choice(("slot_1", "slot_2", *draw.trays["tray_1"]))
    goal = IN_CONTAINER(giant, slot)
    return draw.made("the part is too big", [goal], CauseKind.DOES_NOT_FIT, [giant, slot], "place")


def _too_big_for_all(draw: _Draw) -> Mutation:
    giant = draw.added("tiny:Giant", "giant_1", draw.random.choice(("box_a", "box_b")))
    return draw.made("no slot fits", [IN_TRAY(giant, "tray_1")], CauseKind.DOES_NOT_FIT, [giant], "place")


# ------------------------------------------------------------------ room


def _slot_taken(draw: _Draw) -> Mutation:
    wanted, other = draw.pair()
    slot = draw.random.choice(("slot_1", "slot_2", *draw.trays["tray_2"]))
    draw.moved(other, IN, slot)
    return draw.made("the slot is taken", [IN_CONTAINER(wanted, slot)], CauseKind.FULL, [slot, other], "place")


def _tray_full(draw: _Draw) -> Mutation:
    wanted = draw.ball()
    slots = draw.trays["tray_1"]
    for slot in slots:
        draw.added("tiny:Ball", f"stray_{slot}", slot)
    return draw.made("the tray is full", [IN_TRAY(wanted, "tray_1")], CauseKind.FULL, slots, "place")


def _one_too_many(draw: _Draw) -> Mutation:
    slots = draw.trays["tray_2"]
    balls = [draw.added("tiny:Ball", f"more_{n}", "box_a") for n in range(len(slots) + 1)]
    taken = draw.random.randrange(len(slots))
    for slot in slots[:taken]:
        draw.added("tiny:Ball", f"stray_{slot}", slot)
    wanted = [IN_TRAY(ball, "tray_2") for ball in balls[taken:]]
    return draw.made("one more than there is room for", wanted, CauseKind.FULL, ["tray_2", *slots[taken:]])


# ------------------------------------------------------------------ goals that contradict themselves


def _too_few(draw: _Draw) -> Mutation:
    count = draw.random.choice((2, 3))
    for number in range(2, count):
        draw.added("tiny:RedBall", f"red_ball_{number}", "box_a")
    where = draw.random.sample(["slot_1", "slot_2", *draw.trays["tray_1"]], count)
    wanted = [IN_CONTAINER("tiny:RedBall", slot) for slot in where]
    return draw.made("one thing demanded twice", wanted, CauseKind.TOO_FEW, ["tiny:RedBall"])


def _named_and_any(draw: _Draw) -> Mutation:
    wanted = [IN_CONTAINER("red_ball_1", "slot_1"), IN_TRAY("tiny:RedBall", "tray_1")]
    return draw.made("the only one demanded elsewhere", wanted, CauseKind.TOO_FEW, ["red_ball_1"])


def _two_places(draw: _Draw) -> Mutation:
    ball = draw.ball()
    others = [IN_CONTAINER(ball, "slot_2"), IN_TRAY(ball, "tray_1"), HOLDING("gripper_1", ball)]
    wanted = [IN_CONTAINER(ball, "slot_1"), draw.random.choice(others)]
    return draw.made("one part in two places", wanted, CauseKind.CONTRADICTION, [ball])


def _one_slot_for_two(draw: _Draw) -> Mutation:
    one, other = draw.pair()
    slot = draw.random.choice(("slot_1", "slot_2"))
    wanted = [IN_CONTAINER(one, slot), IN_CONTAINER(other, slot)]
    return draw.made("two parts in one slot", wanted, CauseKind.CONTRADICTION, [slot, one, other])


def _robot_in_two_places(draw: _Draw) -> Mutation:
    robot = f"robot_{draw.robot()}"
    wanted = [AT_LOCATION(robot, place) for place in draw.random.sample(("box_a", "box_b", "door_1"), 2)]
    return draw.made("one robot in two places", wanted, CauseKind.CONTRADICTION, [robot])


def _two_values(draw: _Draw) -> Mutation:
    return draw.made("two values", [OPEN("door_1"), AJAR("door_1")], CauseKind.CONTRADICTION, ["door_1"])


def _empty_and_full(draw: _Draw) -> Mutation:
    gripper = f"gripper_{draw.robot()}"
    wanted = [HOLDING(gripper, draw.ball()), EMPTY_HANDED(gripper)]
    return draw.made("a hand empty and full", wanted, CauseKind.CONTRADICTION, [gripper])


def _cannot_leave(draw: _Draw) -> Mutation:
    """A robot that drives only with empty hands cannot hold an element of one place and stand at another."""
    gripper = Param("Gripper", "sk:Gripper", "What it must not carry.", Kind.HARDWARE)
    drive = draw.skills["drive"]
    careful = (HAS_PART("Arm", "Gripper"), HAS_PART("Robot", "Arm"), EMPTY_HANDED("Gripper"))
    arm = Param("Arm", "sk:Arm", "The arm it is on.", Kind.HARDWARE)
    draw.skills["drive"] = replace(drive, params=(*drive.params, gripper, arm), pre=(*drive.pre, *careful))
    number, ball = draw.robot(), draw.ball()
    box = draw.world.placement(ball)
    assert box is not None
    other = "box_b" if box.place == "box_a" else "box_a"
    wanted = [HOLDING(f"gripper_{number}", ball), AT_LOCATION(f"robot_{number}", other)]
    return draw.made("each alone only", wanted, CauseKind.CONFLICT)


_WAYS: tuple[Callable[[_Draw], Mutation], ...] = (
    _nobody_places,
    _nobody_picks,
    _robot_cannot_drive,
    _skill_unknown,
    _no_gripper,
    _lost,
    _no_driving_pose,
    _flat_battery,
    _never_shown,
    _none_of_class,
    _too_big,
    _too_big_for_all,
    _slot_taken,
    _tray_full,
    _one_too_many,
    _too_few,
    _named_and_any,
    _two_places,
    _one_slot_for_two,
    _robot_in_two_places,
    _two_values,
    _empty_and_full,
    _cannot_leave,
)
