"""Names for Python, the ontology and people, and conversions between them."""

from __future__ import annotations

import keyword
import re
from collections.abc import Iterable

from skiros_py.errors import UsageError

_LONGEST = 40
_LONGEST_SENTENCE = 100
_MODULE = re.compile(r"[a-z][a-z0-9_]*")
_CLASS = re.compile(r"[A-Z][A-Za-z0-9]*")
_EDGE = re.compile(r"(?<=[a-z0-9])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])|[^A-Za-z0-9]+")


def module_name(name: str, what: str) -> str:
    """Checks the name of something that becomes a Python module ("read_code").

    Raises:
        UsageError: It is not valid; the text suggests a similar one.
    """
    if not _MODULE.fullmatch(name):
        near = snake_case(name)
        hint = f", such as '{near}'" if _MODULE.fullmatch(near) and not keyword.iskeyword(near) else ""
        raise UsageError(f"{what} '{name[:80]}': a name of small letters, digits and '_'{hint}")
    return _usable(name, what)


def class_name(name: str, what: str) -> str:
    """Checks the name of something that is written in capitals and joined words ("RobotAtLocation").

    Raises:
        UsageError: It is not valid; the text suggests a similar one.
    """
    if not _CLASS.fullmatch(name):
        near = joined(name)
        hint = f", such as '{near}'" if _CLASS.fullmatch(near) else ""
        raise UsageError(f"{what} '{name[:80]}': a name of letters and digits that begins with a capital{hint}")
    return _usable(name, what)


def _usable(name: str, what: str) -> str:
    if keyword.iskeyword(name):
        raise UsageError(f"{what} '{name}': that is a word of Python itself; choose another")
    if len(name) > _LONGEST:
        raise UsageError(f"{what} '{name[:_LONGEST]}…': {_LONGEST} letters at most")
    return name


def check_distinct(names: Iterable[str], what: str) -> None:
    """Checks that the names in the generated code are all different.

    Raises:
        UsageError: Two are the same, or one is defined in every such file.
    """
    seen = set(_IN_TEMPLATES)
    for name in names:
        if name in seen:
            raise UsageError(f"{what}: the code would have two things called {name}; choose another name")
        seen.add(name)


_IN_TEMPLATES = frozenset(
    {
        "Any",
        "AssertEffects",
        "ClassVar",
        "DESCRIPTION",
        "Do",
        "Execution",
        "Failure",
        "Kind",
        "Options",
        "Outcome",
        "P",
        "Param",
        "Path",
        "Primitive",
        "SCENE",
        "Sequence",
        "Session",
        "Skill",
        "SkillDescription",
        "Success",
    }
)
"""Names that all generated files define."""


def sentence(text: str, what: str) -> str:
    """Turns a text into one sentence: a capital at the start, a full stop at the end.

    Raises:
        UsageError: It is empty, too long for a line, or contains invalid characters.
    """
    text = text.strip()
    if not text or len(text) > _LONGEST_SENTENCE:
        raise UsageError(f"{what}: one sentence of 1 to {_LONGEST_SENTENCE} letters, not {len(text)}")
    if not text.isprintable() or "\\" in text or '"' in text:
        raise UsageError(f"{what}: one line without '\\' and '\"', not {text!r}")
    return text[0].upper() + text[1:] + ("" if text[-1] in ".!?" else ".")


def words_of(name: str) -> str:
    """Returns a name as people write it: "RobotAtLocation" and "robot_at_location" are "robot at location"."""
    return " ".join(part for part in _EDGE.split(name) if part).lower()


def snake_case(name: str) -> str:
    """Returns a name as Python calls modules: "RobotAtLocation" is "robot_at_location"."""
    return words_of(name).replace(" ", "_")


def joined(name: str) -> str:
    """Returns a name as Python calls classes: "read_code" is "ReadCode"."""
    return "".join(part[:1].upper() + part[1:] for part in _EDGE.split(name) if part)


def constant_name(name: str) -> str:
    """Returns a name as Python calls constants: "RobotAtLocation" is "ROBOT_AT_LOCATION"."""
    return snake_case(name).upper()
