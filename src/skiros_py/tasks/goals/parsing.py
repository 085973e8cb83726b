"""Goals as text: reading, and writing such that reading gives the same goal."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

from skiros_py.skills.conditions import Condition, ConditionType, Junction
from skiros_py.tasks.goals.forms import read
from skiros_py.tasks.goals.meaning import goal_of
from skiros_py.world.view import WorldView

_PLAIN = re.compile(r"[^\W\d](?:[\w.-]|:(?=\w))*")


def parse_goal(texts: Sequence[str], view: WorldView, conditions: Mapping[str, ConditionType]) -> tuple[Condition, ...]:
    """Reads goals such as ``"InKit(Starter, kit_1) and not EmptyHanded(gripper_1)"``, or such in PDDL.

    Args:
        texts: One or more goals; all must hold together.
        view: The world, for elements and classes; an element may be given by id or by its label.
        conditions: The known condition words.

    Returns:
        Conditions that must hold together, each once; what "and" joins becomes several.

    Raises:
        GoalSyntaxError: A text does not follow the grammar.
        UnknownName: A word is unknown; the message gives the nearest that exists.
        UsageError: An argument is of the wrong class, abstract where that is not allowed, or a variable out of place.
    """
    return goal_of(map(read, texts), view, conditions)


def goal_as_text(goal: Sequence[Condition]) -> str:
    """Writes a goal as text that :func:`parse_goal` reads back as the same goal in a world with the same elements."""
    return " and ".join(_enclosed(condition) if len(goal) > 1 else condition.written(_quoted) for condition in goal)


def _enclosed(condition: Condition) -> str:
    text = condition.written(_quoted)
    return f"({text})" if isinstance(condition, Junction) and not condition.negated else text


def _quoted(name: str) -> str:
    """Returns a name, in double quotes if the grammar requires them."""
    if _PLAIN.fullmatch(name):
        return name
    return '"' + re.sub(r'(["\\])', r"\\\1", name) + '"'
