"""What the fields of a body's nodes must be: said where a node is made, long before a robot runs it."""

from __future__ import annotations

import math

from skiros_py.errors import DescriptionError
from skiros_py.skills.conditions import Condition

__all__ = ["check_conditions", "check_seconds", "check_texts", "check_times", "require"]


def require(good: bool, what: str, right: str, given: object) -> None:
    """Refuses what was written wrongly.

    Args:
        good: Whether it is right.
        what: The node whose field it is, for messages ("retry").
        right: What would be right.
        given: What was given.

    Raises:
        DescriptionError: It is not right.
    """
    if not good:
        raise DescriptionError(f"{what}: {right}, not {given!r:.100}")


def check_times(what: str, times: object) -> None:
    """Looks whether something is how often a thing can be done."""
    good = isinstance(times, int) and not isinstance(times, bool) and times >= 1
    require(good, what, "at least once, and a whole number of times", times)


def check_seconds(what: str, seconds: object) -> None:
    """Looks whether something is a length of time [s]."""
    good = isinstance(seconds, int | float) and not isinstance(seconds, bool) and 0.0 <= seconds < math.inf
    require(good, what, "a number of seconds from 0", seconds)


def check_texts(what: str, right: str, *texts: object) -> None:
    """Looks whether all are texts that say something."""
    for text in texts:
        require(isinstance(text, str) and text != "", what, right, text)


def check_conditions(what: str, conditions: object) -> None:
    """Looks whether something is a tuple of conditions over parameters, one at least."""
    right = "one or more conditions over parameters, such as PARKED('Robot', 'Place')"
    require(isinstance(conditions, tuple) and conditions != (), what, right, conditions)
    for condition in conditions if isinstance(conditions, tuple) else ():
        require(isinstance(condition, Condition), what, right, condition)
