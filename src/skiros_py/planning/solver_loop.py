"""Tries planners on one task, one after the other; answers are accepted only after a replay."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass

from skiros_py.errors import PlanningError
from skiros_py.planning.attempts import Wanted
from skiros_py.planning.domain.pddl import PddlTexts
from skiros_py.planning.explanation import find_causes
from skiros_py.planning.plan import Plan
from skiros_py.planning.plan_validation import Wrong, validate
from skiros_py.planning.planners.choosing import Planners
from skiros_py.planning.planners.planner import Answer, Planner, Unsolvable, abandon
from skiros_py.planning.problem.task import PlanningTask, build_task

_POLL = 0.0005
"""Poll interval for an answer [s]."""
_PATIENCE = 1.0
"""Delay until a proof that there is no plan is searched for beside the planner [s]; does not affect the result."""


@dataclass(frozen=True, slots=True)
class Found:
    """The planners' result for one task.

    Attributes:
        texts: The task as PDDL.
        planner: Name of the last planner tried; empty if none was.
        plan: The plan; None if there is none.
        doubts: Why the absence of a plan is not proved, if it is not.
        hurried: True if a planner that might have found one was stopped early.
    """

    texts: PddlTexts
    planner: str = ""
    plan: Plan | None = None
    doubts: tuple[str, ...] = ()
    hurried: bool = False

    def is_about(self, texts: PddlTexts) -> bool:
        """Returns whether planners would give the same result for these texts."""
        return not self.hurried and (self.texts.domain, self.texts.problem) == (texts.domain, texts.problem)


class _GivenUp(PlanningError):
    """A planner was stopped because there is something else to try."""


class _Hopeless(PlanningError):
    """A planner was stopped because there is no plan."""


class SolverLoop:
    """Runs planners on the tasks of one goal.

    Args:
        planners: The planners to choose from.
        wanted: The goal to plan for.
        stopped: Returns True once planning is cancelled.
        hurry: Wall time limit of a planner for an incomplete task [s]. Third-party planners support no other kind of
            limit; whether there is a plan does not depend on it.

    Attributes:
        notes: Planner failures so far.
    """

    def __init__(
        self,
        planners: Planners,
        wanted: Wanted,
        stopped: Callable[[], bool] = lambda: False,
        hurry: float = 10.0,
    ) -> None:
        self.notes: list[str] = []
        self._planners = planners
        self._wanted = wanted
        self._stopped = stopped
        self._hurry = hurry
        self._is_hopeless: bool | None = None

    def is_hopeless(self) -> bool:
        """Returns whether causes prove, without search, that there is no plan; computed once.

        A planner would reach the same conclusion, but perhaps after minutes.
        """
        if self._is_hopeless is None:
            task = build_task(self._wanted.view, self._wanted.capabilities, self._wanted.goal)
            self._is_hopeless = bool(find_causes(task, self._wanted.view))
        return self._is_hopeless

    def solve(self, task: PlanningTask, texts: PddlTexts) -> Found:
        """Tries one planner after the other until one finds a plan or proves that there is none.

        Args:
            task: The task; if it is incomplete, planners get little time.
            texts: The task as PDDL.

        Raises:
            PlanningError: No planner supports it, all were closed, or planning was cancelled.
        """
        doubts: list[str] = []
        asked, hurried = "", False
        for planner in self._planners.fitting(texts.requirements):
            asked = planner.name
            try:
                outcome = self._outcome(planner, task, texts)
            except PlanningError as error:
                if self._planners.closed or self._stopped():
                    raise
                if isinstance(error, _Hopeless):
                    return Found(texts, asked, None, (str(error),))
                hurried = hurried or isinstance(error, _GivenUp)
                doubts.append(str(error))
                self.notes.append(str(error))
                continue
            if isinstance(outcome, Plan):
                return Found(texts, asked, outcome)
            if isinstance(outcome, Unsolvable) and outcome.proven:
                return Found(texts, asked)
            doubts.append(_doubt(asked, outcome))
            self.notes.append(doubts[-1])
        if not asked:
            raise PlanningError(self._planners.why_none(texts.requirements))
        return Found(texts, asked, None, tuple(doubts), hurried)

    def _outcome(self, planner: Planner, task: PlanningTask, texts: PddlTexts) -> Plan | Wrong | Unsolvable:
        answer = self._answer(planner, texts, None if task.complete else self._hurry)
        if isinstance(answer, Unsolvable):
            return answer
        return validate(self._wanted.view, task, texts, answer, self._wanted.reached)

    def _answer(self, planner: Planner, texts: PddlTexts, limit: float | None) -> Answer:
        pending = planner.solve(texts.domain, texts.problem)
        started = time.monotonic()
        try:
            while not pending.done():
                taken = time.monotonic() - started
                if self._stopped():
                    raise PlanningError("planning was stopped")
                if taken > _PATIENCE and self.is_hopeless():
                    raise _Hopeless("there is no plan")
                if limit is not None and taken > limit:
                    raise _GivenUp(f"{planner.name} found no plan with what is nearest in {limit:g} s")
                time.sleep(_POLL)
            return pending.result()
        finally:
            abandon(pending)


def _doubt(planner: str, outcome: Wrong | Unsolvable) -> str:
    if isinstance(outcome, Wrong):
        return f"the plan of {planner} {outcome}"
    said = f": {outcome.reason}" if outcome.reason else ""
    return f"{planner} found no plan, and no proof that there is none{said}"
