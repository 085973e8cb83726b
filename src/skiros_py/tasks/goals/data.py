"""Goals as plain data, for programs: dictionaries and lists, as JSON has them.

::

    {"condition": "InKit", "arguments": ["Starter", "kit_1"]}
    {"not": GOAL}   {"all_of": [GOAL, …]}   {"any_of": [GOAL, …]}   {"if": GOAL, "then": GOAL}
    {"for_all": "c", "class": "Compartment", "holds": GOAL}   {"exists": "p", "class": "Starter", "holds": GOAL}
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from skiros_py.errors import UsageError
from skiros_py.skills.conditions import Condition, ConditionType, Junction, Quantified
from skiros_py.tasks.goals.meaning import goal_of
from skiros_py.world.view import WorldView

_LONGEST_PATH = 20


def goal_from_data(data: object, view: WorldView, conditions: Mapping[str, ConditionType]) -> tuple[Condition, ...]:
    """Creates a goal from plain data.

    Args:
        data: One condition, or a list of them that must hold together; see the head of this module.
        view: The world, for elements and classes; an element may be given by id or by its label.
        conditions: The known condition words.

    Returns:
        Conditions that must hold together, each once; what "all_of" joins becomes several.

    Raises:
        UnknownName: A word is unknown; the message gives the nearest that exists.
        UsageError: A field is wrong, and the message gives its path; or the goal makes no sense.
    """
    from pydantic import ValidationError  # imported only when needed: the command line must start quickly

    from skiros_py.tasks.goals.fields import GOALS

    several = isinstance(data, list | tuple)
    try:
        fields = GOALS.validate_python(data if several else [data])
    except ValidationError as error:
        problems = [(one["loc"] if several else one["loc"][1:], one["msg"]) for one in error.errors()]
        raise UsageError("\n".join(f"goal{_path(loc)}: {_said(message)}" for loc, message in problems)) from None
    return goal_of((one.said() for one in fields), view, conditions)


def goal_as_data(goal: Sequence[Condition]) -> list[dict[str, Any]]:
    """Returns a goal as plain data that :func:`goal_from_data` turns back into the same goal."""
    return [_data(condition) for condition in goal]


def _data(condition: Condition) -> dict[str, Any]:
    if condition.negated:
        return {"not": _data(~condition)}
    match condition:
        case Junction(word=word, parts=parts):
            return {"all_of" if word == "and" else "any_of": [_data(part) for part in parts]}
        case Quantified(quantifier=quantifier, variable=variable, class_=class_, part=part):
            return {quantifier.replace(" ", "_"): variable, "class": class_, "holds": _data(part)}
        case _:
            return {"condition": condition.type.name, "arguments": list(condition.arguments)}


def _path(loc: Sequence[int | str]) -> str:
    """Formats the path to a field ("[0].not.arguments[1]"); names in angle brackets are kinds, not fields."""
    fields = [f"[{name}]" if isinstance(name, int) else f".{name}" for name in loc if not str(name).startswith("<")]
    cut = (
        fields if len(fields) <= _LONGEST_PATH else [*fields[: _LONGEST_PATH // 2], "…", *fields[-_LONGEST_PATH // 2 :]]
    )
    return "".join(cut)


def _said(message: str) -> str:
    return message[:1].lower() + message[1:]
