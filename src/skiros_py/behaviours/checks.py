"""What the fields of nodes must be: said where a node is made, long before a robot runs it."""

from __future__ import annotations

import math

from skiros_py.skills.behaviour import Behaviour, check_behaviour, check_texts, require
from skiros_py.skills.conditions import Condition, holds

__all__ = ["check_children", "check_seconds", "check_texts", "check_times", "read_conditions", "require"]


def check_children(what: str, children: tuple[Behaviour, ...]) -> None:
    """Refuses what is not a tuple of one or more behaviours."""
    require(isinstance(children, tuple), what, "its parts are a tuple", children)
    require(bool(children), what, "at least one part: with none, nobody knows whether it has worked", children)
    for child in children:
        check_behaviour(what, child)


def check_times(what: str, times: object) -> None:
    """Refuses what is not a number of times."""
    good = isinstance(times, int) and not isinstance(times, bool) and times >= 1
    require(good, what, "at least once, and a whole number of times", times)


def check_seconds(what: str, seconds: object) -> None:
    """Refuses what is not a duration [s]."""
    good = isinstance(seconds, int | float) and not isinstance(seconds, bool) and 0.0 <= seconds < math.inf
    require(good, what, "a number of seconds from 0", seconds)


def read_conditions(what: str, conditions: object) -> tuple[Condition, ...]:
    """Returns one or more conditions; expressions may be given as text.

    Raises:
        DescriptionError: Something is neither a condition nor an expression.
    """
    right = "one or more conditions over parameters, such as PARKED('Robot', 'Place'), or texts such as 'Arm.still'"
    require(isinstance(conditions, tuple) and conditions != (), what, right, conditions)
    read = [holds(one) if isinstance(one, str) else one for one in conditions]  # type: ignore[attr-defined]
    for one in read:
        require(isinstance(one, Condition), what, right, one)
    return tuple(read)
