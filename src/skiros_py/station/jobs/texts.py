"""Converts goals of any form into texts, independently of the world: the same order always gives the same text."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any

from skiros_py.api.faults import fault_words
from skiros_py.errors import UsageError
from skiros_py.tasks.goals.said import Joined, Name, Negation, Quantification, Said, Word

_DEEPEST = 60
"""Maximum nesting: the goal language refuses deeper goals anyway, and recursion over them would fail."""
_PLAIN = re.compile(r"[^\W\d](?:[\w.-]|:(?=\w))*")
_VARIABLE = re.compile(r"[^\W\d]\w*")


def goal_texts(goal: object) -> tuple[str, ...]:
    """Returns the texts of a goal: texts unchanged, structured conditions converted.

    Args:
        goal: A text, a structured condition, or several of either.

    Raises:
        UsageError: The structure is wrong; the text gives the path to the fault.
    """
    several = goal if isinstance(goal, list | tuple) else [goal]
    structured = iter(_said([one for one in several if not isinstance(one, str)], "goal", alone=several is not goal))
    return tuple(one if isinstance(one, str) else _text(next(structured), frozenset(), 0) for one in several)


def check_structure(data: dict[str, Any], where: str) -> None:
    """Requires that a structured condition can be converted into text.

    Args:
        data: The condition.
        where: Path to it.

    Raises:
        UsageError: It cannot; the text gives the path to the fault.
    """
    (said,) = _said([data], where, alone=True)
    try:
        _text(said, frozenset(), 0)
    except UsageError as error:
        raise UsageError(f"{where}: {error}") from None


def _said(data: Sequence[object], where: str, *, alone: bool) -> list[Said]:
    from pydantic import ValidationError

    from skiros_py.tasks.goals.fields import GOALS

    try:
        fields = GOALS.validate_python(list(data))
    except ValidationError as error:
        problems = (f"{where}{_path(one['loc'][alone:])}: {fault_words(one)}" for one in error.errors()[:20])
        raise UsageError("; ".join(problems)) from None
    return [one.said() for one in fields]


def _path(loc: Sequence[int | str]) -> str:
    """Returns the path to a field: "[0].not.arguments[1]"; names in angle brackets are kinds, not fields."""
    fields = [f"[{name}]" if isinstance(name, int) else f".{name}" for name in loc if not str(name).startswith("<")]
    return "".join(fields[:20])[:200]


def _text(said: Said, variables: frozenset[str], depth: int) -> str:
    """Returns the text of a condition; everything joined or negated is in parentheses."""
    if depth > _DEEPEST:
        raise UsageError(f"the goal is nested deeper than {_DEEPEST} levels: say it in several conditions")
    match said:
        case Word(word, arguments):
            return f"{_word(word)}({', '.join(_name(argument, variables) for argument in arguments)})"
        case Negation(part):
            return f"not ({_text(part, variables, depth + 1)})"
        case Joined(word, parts):
            return f" {word} ".join(f"({_text(part, variables, depth + 1)})" for part in parts)
        case Quantification(quantifier, variable, class_, part):
            if not _VARIABLE.fullmatch(variable):
                raise UsageError(f"'{variable[:100]}' cannot be a variable: letters, digits and _ only")
            inner = _text(part, variables | {variable}, depth + 1)
            return f"{quantifier} {variable}: {_quoted(class_)} ({inner})"


def _word(word: str) -> str:
    if not _PLAIN.fullmatch(word):
        raise UsageError(f"unknown condition '{word[:100]}' in the goal: a word consists of letters, digits and _")
    return word


def _name(name: Name, variables: frozenset[str]) -> str:
    return name.text if name.text in variables else _quoted(name.text)


def _quoted(name: str) -> str:
    """Returns a name unchanged, or in double quotes if the grammar requires them."""
    if not name:
        raise UsageError("a name in the goal is empty")
    return name if _PLAIN.fullmatch(name) else '"' + re.sub(r'(["\\])', r"\\\1", name) + '"'
