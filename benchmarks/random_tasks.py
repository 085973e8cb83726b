"""Random worlds and goals of the tiny domain, drawn from a seed, to compare two ways of planning."""

from __future__ import annotations

import random
from collections.abc import Sequence
from dataclasses import dataclass, replace

from random_goals import goal_in_turns, random_goal

from skiros_py.planning.problem.task import Capability
from skiros_py.planning.sequence import counts
from skiros_py.skills.conditions import Condition
from skiros_py.skills.parameters import Param
from skiros_py.testing.tiny import (
    AT_LOCATION,
    DRIVE,
    EMPTY_HANDED,
    FREE,
    HOLDING,
    IN_CONTAINER,
    PICK,
    PLACE,
    tiny_world,
)
from skiros_py.world.world import World

TAKE = replace(
    PICK,
    name="take",
    help="Takes a ball out of a slot.",
    params=(*PICK.params[:3], Param("Slot", "tiny:Slot", "Where it lies."), PICK.params[4]),
    pre=(*PICK.pre[:2], IN_CONTAINER("Ball", "Slot"), EMPTY_HANDED("Gripper")),
)
"""Like pick, from slots."""

_BALLS = ("tiny:Ball", "tiny:RedBall", "tiny:Giant")


@dataclass(frozen=True, slots=True)
class RandomTask:
    """A world, its skills, and a goal that may be unreachable."""

    world: World
    capabilities: tuple[Capability, ...]
    goal: tuple[Condition, ...]


def random_task(seed: int) -> RandomTask:
    """Returns the task of a seed: balls in boxes, slots and grippers, and one to three conditions."""
    chance = random.Random(seed)  # noqa: S311  a seed must give the same task again
    robots = chance.randint(1, 2)
    world = tiny_world(*_facts(chance), robots=robots)
    _scatter(chance, world)
    able = _able(chance, world)
    goal = tuple(dict.fromkeys(_condition(chance, world) for _ in range(chance.randint(1, 3))))
    return RandomTask(world, able, goal)


def mixed_task(seed: int) -> RandomTask:
    """Returns the task of a seed with composite goals, and sometimes with sequence numbers and stock."""
    chance = random.Random(seed)  # noqa: S311  a seed must give the same task again
    facts = _facts(chance)
    facts += _numbers(chance) if chance.random() < 0.5 else []
    facts += _stock(chance) if chance.random() < 0.3 else []
    world = tiny_world(*facts)
    _scatter(chance, world)
    able = _able(chance, world)
    is_in_turns = counts(world) and chance.random() < 0.5
    return RandomTask(world, able, goal_in_turns(chance, world) if is_in_turns else random_goal(chance, world))


def _able(chance: random.Random, world: World) -> tuple[Capability, ...]:
    skills = [DRIVE, PICK, PLACE, TAKE]
    if chance.random() < 0.3:
        skills.remove(chance.choice(skills))
    return tuple(Capability(s, _agents(chance, world.instances(s.agent_class))) for s in skills)


def _numbers(chance: random.Random) -> list[str]:
    """Enables sequence and work numbers, and gives some places numbers."""
    numbers = [("box_a", "sequence"), ("box_b", "sequence"), ("slot_1", "work"), ("slot_2", "work")]
    given = [f"scene:{place} sk:{kind}Number {chance.randint(1, 3)} ." for place, kind in numbers]
    return ["scene:floor sk:useSequenceNumbers true .", *(fact for fact in given if chance.random() < 0.8)]


def _stock(chance: random.Random) -> list[str]:
    described = f'a sk:Stock ; sk:stockOf "{chance.choice(_BALLS)}" ; sk:stockCount {chance.randint(1, 4)}'
    return [f"scene:more {described} .", f"scene:{chance.choice(['box_a', 'box_b'])} sk:hasA scene:more ."]


def _facts(chance: random.Random) -> list[str]:
    facts = [f"scene:slot_{n} a tiny:Slot ; sk:on scene:floor ." for n in range(3, 3 + chance.randint(0, 2))]
    for number in range(2, 2 + chance.randint(0, 5)):
        box = chance.choice(["box_a", "box_b"])
        facts.append(f"scene:ball_{number} a {chance.choice(_BALLS)} ; sk:in scene:{box} .")
    return facts


def _scatter(chance: random.Random, world: World) -> None:
    """Puts some balls into slots and grippers, at most one into each."""
    balls = list(world.instances("tiny:Ball"))
    places = [(place, "sk:in") for place in world.instances("tiny:Slot")]
    places += [(gripper, "sk:heldBy") for gripper in world.instances("sk:Gripper")]
    with world.transaction("random", "scattered") as tx:
        for place, relation in places:
            if len(balls) > 1 and chance.random() < 0.3:
                ball = balls.pop(chance.randrange(len(balls)))
                tx.place(ball, relation, place)


def _agents(chance: random.Random, able: Sequence[str]) -> tuple[str, ...]:
    return tuple(agent for agent in able if chance.random() < 0.9)


def _condition(chance: random.Random, world: World) -> Condition:
    ball = chance.choice([*world.instances("tiny:Ball"), *_BALLS])
    slot = chance.choice(world.instances("tiny:Slot"))
    kind = chance.random()
    if kind < 0.6:
        return IN_CONTAINER(ball, slot)
    if kind < 0.7:
        return HOLDING("gripper_1", chance.choice(world.instances("tiny:Ball")))
    if kind < 0.8:
        return FREE(slot)
    if kind < 0.9:
        return AT_LOCATION("robot_1", chance.choice(["box_a", "box_b", "slot_1"]))
    return ~EMPTY_HANDED("gripper_1")
