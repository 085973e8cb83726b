"""Children that run at the same time."""

from __future__ import annotations

import enum
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar

from skiros_py.behaviours.children import Composite
from skiros_py.errors import DescriptionError
from skiros_py.messages import joined
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


_ENDS: Mapping[Policy, tuple[str, tuple[type[Outcome], ...]]] = {
    Policy.FIRST_FAILURE: ("one fails", (Failure,)),
    Policy.FIRST_SUCCESS: ("one succeeds", (Success,)),
    Policy.ALL: ("all have ended", ()),
}
"""When it is over, in words, and the outcome of one child that ends all."""


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
        return f"parallel, until {_ENDS[self.policy][0]}"

    def uses(self) -> Uses:
        """Its children share devices in time."""
        return Uses(concurrent=True, needs="any" if self.policy is Policy.FIRST_SUCCESS else "all")

    def run(self, scope: Scope) -> Execution[Outcome]:
        """Runs the children until the policy says that it is over."""
        ended: dict[int, Outcome] = {}
        decisive = _ENDS[self.policy][1]
        with scope.apart() as inner:
            branches = [inner.run(child, str(number)) for number, child in enumerate(self.children)]
            running = tuple(enumerate(branches))
            try:
                while running and not _tick_all(running, ended, decisive):
                    if len(ended) + len(running) > len(branches):
                        running = tuple(one for one in running if one[0] not in ended)
                    if running:
                        yield
            finally:
                for branch in branches:
                    branch.close()
            yield from inner.recover()
        in_order = [ended[number] for number in sorted(ended)]
        good = [outcome for outcome in in_order if isinstance(outcome, Success)]
        bad = [outcome for outcome in in_order if isinstance(outcome, Failure)]
        if good and self.policy is Policy.FIRST_SUCCESS:
            return good[0]
        if bad:
            return replace(bad[0], reason=joined("; ", [failure.reason for failure in bad]))
        return Success(joined("; ", [outcome.message for outcome in good if outcome.message]))


def _tick_all(
    running: tuple[tuple[int, Execution[Outcome]], ...], ended: dict[int, Outcome], decisive: tuple[type[Outcome], ...]
) -> bool:
    """Ticks the branches in turn; returns whether the outcome of one of them ends all."""
    for number, branch in running:
        try:
            next(branch)
        except StopIteration as end:
            ended[number] = end.value
            if isinstance(end.value, decisive):
                return True
    return False
