"""Children that run at the same time."""

from __future__ import annotations

import enum
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from skiros_py.behaviours.children import Composite
from skiros_py.errors import DescriptionError
from skiros_py.skills.behaviour import Behaviour, Scope, Uses, require
from skiros_py.skills.outcome import Execution, Failure, Outcome, Success
from skiros_py.skills.plain import Reader


class Policy(enum.Enum):
    """When a :class:`Parallel` is over; children that still run then are cancelled and recover."""

    FIRST_FAILURE = "first failure"
    """With the first failure, or when all have succeeded."""
    FIRST_SUCCESS = "first success"
    """With the first success, or when all have failed."""
    ALL = "all"
    """When all have ended; a failure among them is its failure."""


_UNTIL = {
    Policy.FIRST_FAILURE: "one fails",
    Policy.FIRST_SUCCESS: "one succeeds",
    Policy.ALL: "all have ended",
}


@dataclass(frozen=True, slots=True)
class Parallel(Composite):
    """All at the same time, in this order within each cycle."""

    kind: ClassVar[str] = "parallel"

    policy: Policy = Policy.FIRST_FAILURE

    def __post_init__(self) -> None:
        Composite.__post_init__(self)
        require(isinstance(self.policy, Policy), "parallel", "a policy such as Policy.ALL", self.policy)

    @classmethod
    def of(cls, *children: Behaviour, policy: Policy = Policy.FIRST_FAILURE) -> Parallel:
        """Makes one."""
        return cls(children, policy)

    @classmethod
    def from_data(cls, data: Mapping[str, Any], reader: Reader) -> Parallel:
        """Makes one from plain data."""
        policies = {policy.value: policy for policy in Policy}
        policy = data.get("policy", Policy.FIRST_FAILURE.value)
        if policy not in policies:
            raise DescriptionError(f"parallel: a policy is one of {', '.join(policies)}, not {policy!r:.100}")
        return cls(reader.field("children", data.get("children")), policies[policy])

    @property
    def title(self) -> str:
        """Its kind and policy."""
        return f"parallel, until {_UNTIL[self.policy]}"

    def uses(self) -> Uses:
        """Its children share devices in time."""
        return Uses(concurrent=True, needs="any" if self.policy is Policy.FIRST_SUCCESS else "all")

    def run(self, scope: Scope) -> Execution[Outcome]:
        """Runs the children until the policy says that it is over."""
        ended: dict[int, Outcome] = {}
        with scope.apart() as inner:
            branches = [inner.run(child, str(number)) for number, child in enumerate(self.children)]
            running = tuple(enumerate(branches))
            try:
                while running and not _tick_all(running, ended, self.policy):
                    if len(ended) + len(running) > len(branches):
                        running = tuple(one for one in running if one[0] not in ended)
                    if running:
                        yield
            finally:
                for branch in branches:
                    branch.close()
            yield from inner.recover()
        return _together(ended, self.policy)


def _tick_all(running: tuple[tuple[int, Execution[Outcome]], ...], ended: dict[int, Outcome], policy: Policy) -> bool:
    """Ticks the branches in turn; returns whether the outcome of one of them ends all."""
    for number, branch in running:
        try:
            next(branch)
        except StopIteration as end:
            outcome: Outcome = end.value
            ended[number] = outcome
            if _decided(outcome, policy):
                return True
    return False


def _decided(outcome: Outcome, policy: Policy) -> bool:
    """Tells whether one outcome ends all."""
    match policy:
        case Policy.FIRST_FAILURE:
            return isinstance(outcome, Failure)
        case Policy.FIRST_SUCCESS:
            return isinstance(outcome, Success)
        case Policy.ALL:
            return False


def _together(ended: Mapping[int, Outcome], policy: Policy) -> Outcome:
    in_order = [ended[number] for number in sorted(ended)]
    good = [outcome for outcome in in_order if isinstance(outcome, Success)]
    bad = [outcome for outcome in in_order if isinstance(outcome, Failure)]
    if policy is Policy.FIRST_SUCCESS:
        return good[0] if good else _all_of(bad)
    return _all_of(bad) if bad else Success("; ".join(o.message for o in good if o.message))


def _all_of(failures: list[Failure]) -> Failure:
    return Failure("; ".join(failure.reason for failure in failures), failures[0].code)
