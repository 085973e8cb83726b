"""Whether there is any hope for a plan: causes that prove without any search that there is none."""

from __future__ import annotations

from skiros_py.planning.attempts import Wanted
from skiros_py.planning.explanation import finding_causes
from skiros_py.planning.pieces import Work
from skiros_py.planning.problem.task import build_task

__all__ = ["Prospect"]


class Prospect:
    """What can be said of a task before any planner has an answer; looked for once, when it is first asked.

    It is a proof: a planner would come to the same, though perhaps after minutes. So it may be looked for at any time.

    Args:
        wanted: What shall be planned.
    """

    def __init__(self, wanted: Wanted) -> None:
        self._wanted = wanted
        self._is_hopeless: bool | None = None

    def is_hopeless(self) -> Work[bool]:
        """Tells whether there certainly is no plan; False where that is not known."""
        if self._is_hopeless is None:
            task = build_task(self._wanted.view, self._wanted.capabilities, self._wanted.goal)
            yield
            self._is_hopeless = bool((yield from finding_causes(task, self._wanted.view)))
        return self._is_hopeless
