"""Tries whether a goal has a plan in a changed world: task, planner, replay."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence

from skiros_py.errors import PlanningError
from skiros_py.planning.domain.pddl import PddlTexts, write_pddl
from skiros_py.planning.plan import Plan
from skiros_py.planning.plan_validation import validate
from skiros_py.planning.planners.planner import Answer, Planner, Planners, Solved, wait_for
from skiros_py.planning.problem.task import Capability, build_task
from skiros_py.skills.conditions import Condition
from skiros_py.world.view import WorldView

_QUICK = "kairos"
"""The planner that answers in milliseconds: used if available and suitable."""


class Trial:
    """Runs a quick planner; the ``solve`` argument of :func:`skiros_py.planning.explanation.explain`.

    Slow trials are given up, since a late explanation is useless; this can only omit something from it. The caller
    bounds the number of trials; planners support no bound but time, so these limits are wall time.

    Args:
        planners: The planners to choose from.
        capabilities: The available skills.
        each: Wall time for one answer [s].
        together: Wall time for all planners' answers together [s].
        stopped: Returns True once the explanation is cancelled.
    """

    def __init__(
        self,
        planners: Planners,
        capabilities: Sequence[Capability],
        *,
        each: float = 1.0,
        together: float = 4.0,
        stopped: Callable[[], bool] = lambda: False,
    ) -> None:
        self._planners = planners
        self._capabilities = capabilities
        self._each = each
        self._left = together
        self._stopped = stopped

    def __call__(self, view: WorldView, goal: Sequence[Condition]) -> bool | None:
        """Returns whether there is a plan that survives its replay; None if the planner failed or took too long."""
        task = build_task(view, self._capabilities, goal)
        texts = write_pddl(task.domain, task.problem, name="trial")
        planner = self._planner_for(texts.requirements)
        if planner is None:
            return None
        try:
            answer = self._answer(planner, texts)
            if isinstance(answer, Solved):
                plan = validate(task, texts, answer)
                return True if isinstance(plan, Plan) else None
        except PlanningError:
            return None
        return False if answer.proven else None

    def _answer(self, planner: Planner, texts: PddlTexts) -> Answer:
        started = time.perf_counter()
        try:
            return wait_for(planner.solve(texts.domain, texts.problem), self._check)
        finally:
            self._left -= time.perf_counter() - started

    def _check(self, taken: float) -> None:
        if self._stopped() or taken > min(self._each, self._left):
            raise PlanningError("an explanation needs no more")

    def _planner_for(self, requirements: Sequence[str]) -> Planner | None:
        first: Planner | None = None
        for planner in self._planners.fitting(requirements):
            if planner.name == _QUICK:
                return planner
            first = first or planner
        return first
