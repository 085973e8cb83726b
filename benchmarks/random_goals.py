"""Random goals of the tiny domain with all constructs: and, or, not, for all, exists, classes."""

from __future__ import annotations

import random

from skiros_py.errors import SkirosError
from skiros_py.skills.conditions import Condition
from skiros_py.tasks.goals import parse_goal
from skiros_py.testing.tiny import CONDITIONS
from skiros_py.world.world import World

_CLASSES = ("Ball", "RedBall", "Giant")
_BOXES = ("box_a", "box_b")

_Scope = tuple[tuple[str, str], ...]
"""The variables of the enclosing quantifiers, with their classes."""


def goal_in_turns(chance: random.Random, world: World) -> tuple[Condition, ...]:
    """Returns an alternative for one slot, and one of these in another slot, to be achieved in order.

    Only the other choice does not stand in the way of what comes later.
    """
    one, other = chance.sample(world.instances("tiny:Slot"), 2)
    balls = chance.sample(world.instances("tiny:Ball"), 2)
    texts = [f"In({balls[0]}, {one}) or In({balls[1]}, {one})", f"In({chance.choice(balls)}, {other})"]
    return parse_goal(chance.sample(texts, 2), world, CONDITIONS)


def random_goal(chance: random.Random, world: World, depth: int = 2) -> tuple[Condition, ...]:
    """Returns one or two conditions up to a nesting depth; meaningless ones are drawn again."""
    while True:
        texts = [_text(chance, world, (), depth) for _ in range(chance.randint(1, 2))]
        try:
            return parse_goal(texts, world, CONDITIONS)
        except SkirosError:
            continue


def _text(chance: random.Random, world: World, scope: _Scope, depth: int) -> str:
    if depth == 0 or chance.random() < 0.4:
        return _plain(chance, world, scope)
    match chance.choice(["and", "or", "not", "for all", "exists"]):
        case "not":
            return f"not ({_text(chance, world, scope, depth - 1)})"
        case "and" | "or" as word:
            each = (_text(chance, world, scope, depth - 1) for _ in range(2))
            return f"({f' {word} '.join(each)})"
        case quantifier:
            variable, class_ = f"v{len(scope)}", chance.choice([*_CLASSES, "Slot"])
            inner = _text(chance, world, (*scope, (variable, class_)), depth - 1)
            return f"({quantifier} {variable}: {class_} ({inner}))"


def _plain(chance: random.Random, world: World, scope: _Scope) -> str:
    ball, slot = _one(chance, world, scope, "Ball"), _one(chance, world, scope, "Slot")
    kind = chance.random()
    if kind < 0.6:
        return f"In({ball}, {chance.choice([slot, slot, slot, *_BOXES])})"
    if kind < 0.75:
        return f"Free({slot})"
    if kind < 0.85:
        return f"Holding(gripper_1, {ball})"
    if kind < 0.95:
        return f"At(robot_1, {chance.choice(_BOXES)})"
    return "EmptyHanded(gripper_1)"


def _one(chance: random.Random, world: World, scope: _Scope, kind: str) -> str:
    """Returns a ball or a slot: usually a variable, otherwise a name, sometimes a class."""
    variables = [name for name, class_ in scope if (class_ == "Slot") == (kind == "Slot")]
    if variables and chance.random() < 0.7:
        return chance.choice(variables)
    if kind == "Ball" and chance.random() < 0.2:
        return chance.choice(_CLASSES)
    return chance.choice(world.instances(f"tiny:{kind}"))
