"""A planner with a fixed answer, to test the handling of wrong ones."""

from __future__ import annotations

from dataclasses import dataclass

from skiros_py.planning.planners.planner import Answer, Solved, Unsolvable


@dataclass(frozen=True, slots=True)
class _Given:
    """An answer that is available immediately."""

    answer: Answer
    latency: float = 0.0

    def done(self) -> bool:
        return True

    def result(self) -> Answer:
        return self.answer


class GivenPlanner:
    """A :class:`~skiros_py.planning.planners.planner.Planner` that does not read its task.

    Args:
        *steps: PDDL action with its objects, as one text each ("drive base_1 robot_1 box_a unknown_location"); none
            at all for the answer that there is no plan.
    """

    name = "given"
    supports = frozenset({":strips", ":typing", ":negative-preconditions", ":existential-preconditions"})

    def __init__(self, *steps: str) -> None:
        self._answer: Answer = Solved(tuple(tuple(step.split()) for step in steps)) if steps else Unsolvable()

    def solve(self, domain: str, problem: str) -> _Given:  # noqa: ARG002 - the port's signature
        """Answers."""
        return _Given(self._answer)

    def close(self) -> None:
        """Does nothing; there is nothing to kill."""
