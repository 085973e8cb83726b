"""Tries whether a goal has a plan in a changed world: task, planner, replay."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from skiros_py.errors import PlanningError
from skiros_py.planning.domain.pddl import write_pddl
from skiros_py.planning.plan import Plan
from skiros_py.planning.plan_validation import validate
from skiros_py.planning.planners.planner import Planners, Solved, wait_for
from skiros_py.planning.problem.task import Capability, build_task
from skiros_py.skills.conditions import Condition
from skiros_py.world.view import WorldView

_QUICK = "kairos"
"""The planner that answers in milliseconds: used if available and suitable."""


@dataclass(slots=True, eq=False)
class Trial:
    """Runs a quick planner; the ``solve`` argument of :func:`skiros_py.planning.explanation.explain`.

    Slow trials are given up, since a late explanation is useless; this can only omit something from it. The caller
    bounds the number of trials; planners support no bound but time, so these limits are wall time.

    Attributes:
        planners: The planners to choose from.
        capabilities: The available skills.
        each: Wall time for one answer [s].
        together: Wall time that is left for all planners' answers together [s].
        stopped: Returns True once the explanation is cancelled.
    """

    planners: Planners
    capabilities: Sequence[Capability]
    each: float = 1.0
    together: float = 4.0
    stopped: Callable[[], bool] = lambda: False

    def __call__(self, view: WorldView, goal: Sequence[Condition]) -> bool | None:
        """Returns whether there is a plan that survives its replay; None if the planner failed or took too long.

        Raises:
            PlanningError: The explanation was cancelled, or the planners were closed.
        """
        task = build_task(view, self.capabilities, goal)
        texts = write_pddl(task.domain, task.problem, name="trial")
        quick = (planner for planner in self.planners.fitting(texts.requirements) if planner.name == _QUICK)
        planner = next(quick, None) or next(self.planners.fitting(texts.requirements), None)
        if planner is None:
            return None
        started = time.perf_counter()
        try:
            answer = wait_for(planner.solve(texts.domain, texts.problem), self._check)
            if isinstance(answer, Solved):
                return True if isinstance(validate(task, texts, answer), Plan) else None
        except PlanningError:
            if self.stopped() or self.planners.closed:
                raise
            return None
        finally:
            self.together -= time.perf_counter() - started
        return False if answer.proven else None

    def _check(self, taken: float) -> None:
        if self.stopped() or taken > min(self.each, self.together):
            raise PlanningError("an explanation needs no more")
