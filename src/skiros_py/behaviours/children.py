"""What nodes share: bases by their fields, checks of fields, and children that run in turn or until ended."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from contextlib import closing
from dataclasses import dataclass
from typing import Self

from skiros_py.messages import joined
from skiros_py.skills.behaviour import Behaviour, Scope, Uses, check_behaviour, require
from skiros_py.skills.conditions import Condition, holds
from skiros_py.skills.conditions.watch import Watch
from skiros_py.skills.outcome import Execution, Failure, Outcome, Success


@dataclass(frozen=True, slots=True)
class Composite(Behaviour):
    """A node with one or more children, in order."""

    children: tuple[Behaviour, ...]

    def __post_init__(self) -> None:
        require(isinstance(self.children, tuple), self.kind, "its parts are a tuple", self.children)
        require(bool(self.children), self.kind, "at least one part: without one there is no outcome", self.children)
        for child in self.children:
            check_behaviour(self.kind, child)

    @classmethod
    def of(cls, *children: Behaviour) -> Self:
        """Makes one."""
        return cls(children)

    @property
    def title(self) -> str:
        """Its kind."""
        return self.kind

    def named_children(self) -> Mapping[str, Behaviour]:
        """Its children by number, counted from 0."""
        return {str(number): child for number, child in enumerate(self.children)}


class Decorator(Behaviour):
    """A node around one child."""

    __slots__ = ()

    child: Behaviour

    def named_children(self) -> Mapping[str, Behaviour]:
        """Its child."""
        return {"0": self.child}


@dataclass(frozen=True, slots=True)
class ConditionNode(Behaviour):
    """A leaf that evaluates conditions.

    Attributes:
        conditions: Over the skill's parameters; expressions over signals may be texts.
    """

    conditions: tuple[Condition, ...]

    def __post_init__(self) -> None:
        object.__setattr__(self, "conditions", read_conditions(self.kind.replace("_", " "), self.conditions))

    @classmethod
    def of(cls, *conditions: Condition | str) -> Self:
        """Makes one: ``Check.of("Gripper.gap > 0.01")``, ``WaitUntil.of("Arm.still and Gripper.force > 2")``."""
        return cls(conditions)  # type: ignore[arg-type]  # texts are read

    @property
    def title(self) -> str:
        """Its kind and conditions."""
        return f"{self.kind.replace('_', ' ')} {' and '.join(map(str, self.conditions))}"

    def uses(self) -> Uses:
        """Its conditions."""
        return Uses(conditions=self.conditions)


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


def in_turn(
    children: Iterable[Behaviour], scope: Scope, *, ends_with: type[Outcome], same: bool = False
) -> Execution[Outcome]:
    """Runs behaviours in turn; each starts in the cycle after the end of the one before.

    Args:
        children: The behaviours.
        scope: Scope of their parent.
        ends_with: The outcome that ends it.
        same: True where all are one child that is tried again.
    """
    outcome: Outcome = Success()
    for number, child in enumerate(children):
        if number:
            yield
        outcome = yield from scope.run(child, "0" if same else str(number))
        if isinstance(outcome, ends_with):
            return outcome
    return outcome


def run_until(
    child: Behaviour, key: str, scope: Scope, end: Callable[[Execution[Outcome]], Outcome | None]
) -> Execution[Outcome]:
    """Runs a child until it ends or is ended; then runs the recovery of what was cancelled.

    Args:
        child: The child.
        key: Its key.
        scope: Scope of its parent.
        end: Called in each cycle: ticks the child's run, or ends it; returns its outcome, None while it goes on.
    """
    with scope.apart() as inner, closing(inner.run(child, key)) as run:
        while True:
            outcome = end(run)
            if outcome is not None:
                break
            yield
        run.close()
        yield from inner.recover()
    return outcome


def lost(watch: Watch, what: str) -> Failure | None:
    """Returns the failure where a watched condition holds no longer; its text begins with the words given."""
    broken = watch.broken()
    return None if broken is None else Failure(joined(" ", (what, broken.sentence)))
