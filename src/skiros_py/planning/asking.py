"""What planners say of one task: one after the other is asked, and no answer is believed before its replay."""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass

from skiros_py.errors import PlanningError
from skiros_py.planning.attempts import Wanted
from skiros_py.planning.domain.pddl import PddlTexts
from skiros_py.planning.pieces import T, Work, at_once, in_slices
from skiros_py.planning.plan import Plan
from skiros_py.planning.planners.choosing import Planners
from skiros_py.planning.planners.planner import Answer, Planner, Unsolvable, abandon
from skiros_py.planning.problem.task import PlanningTask
from skiros_py.planning.prospect import Prospect
from skiros_py.planning.proving import Wrong, proving
from skiros_py.ports.pending import Pending

__all__ = ["Asking", "Found"]

_GLANCE = 0.0005
"""Time between two looks for an answer while simulated time stands still [s]."""
_PATIENCE = 1.0
"""After so long it is looked whether there is any hope, while the planner works on; what comes of it does not depend on
when that is done [s]."""


@dataclass(frozen=True, slots=True)
class Found:
    """What planners say of one task.

    Attributes:
        texts: The task as written.
        planner: Name of the last that was asked; empty where none was.
        plan: The plan; None where there is none.
        doubts: Why that is not proved, where it is not.
        hurried: True where a planner was stopped that might have found one.
    """

    texts: PddlTexts
    planner: str = ""
    plan: Plan | None = None
    doubts: tuple[str, ...] = ()
    hurried: bool = False

    def is_about(self, texts: PddlTexts) -> bool:
        """Tells whether it is what planners would say of these texts, too."""
        return not self.hurried and (self.texts.domain, self.texts.problem) == (texts.domain, texts.problem)


class _GivenUp(PlanningError):
    """A planner was stopped, for there is something else to try."""


class _Hopeless(PlanningError):
    """A planner was stopped, for there is no plan."""


class Asking:
    """Asks planners.

    Args:
        planners: The planners to choose from.
        lockstep: True when simulated time stands still while a planner works.
        waiting: Says, for as long as it is entered, that a long wait for the planner is no fault.
        leaving: Tells whether somebody wants a stop: then simulated time goes on, for the stop to happen.
        hurry: How long a planner may take for a task from which something was left out; a limit of wall time, for
            planners of other people know no bound but time. It decides nothing about whether there is a plan [s].
    """

    def __init__(
        self,
        planners: Planners,
        *,
        lockstep: bool,
        waiting: Callable[[], AbstractContextManager[None]] = nullcontext,
        leaving: Callable[[], bool] = lambda: False,
        hurry: float = 10.0,
    ) -> None:
        self._planners = planners
        self._lockstep = lockstep
        self._waiting = waiting
        self._leaving = leaving
        self._hurry = hurry

    def found(
        self, wanted: Wanted, task: PlanningTask, texts: PddlTexts, prospect: Prospect, notes: list[str]
    ) -> Work[Found]:
        """Asks one planner after the other until one has a plan, or has proved that there is none.

        Args:
            wanted: What shall be planned.
            task: The task; where it is not complete, none may take long for it.
            texts: The same, as written.
            prospect: Whether there is any hope; where there is none, none is asked any longer.
            notes: What went wrong is added to these.

        Raises:
            PlanningError: No planner takes it, or all were closed.
        """
        doubts: list[str] = []
        asked, hurried = "", False
        for planner in self._planners.fitting(texts.requirements):
            asked = planner.name
            try:
                outcome = yield from self._outcome(planner, wanted, task, texts, prospect)
            except PlanningError as error:
                if self._planners.closed:
                    raise
                if isinstance(error, _Hopeless):
                    return Found(texts, asked, None, (str(error),))
                hurried = hurried or isinstance(error, _GivenUp)
                doubts.append(str(error))
                notes.append(str(error))
                continue
            if isinstance(outcome, Plan):
                return Found(texts, asked, outcome)
            if isinstance(outcome, Unsolvable) and outcome.proven:
                return Found(texts, asked)
            doubts.append(_doubt(asked, outcome))
            notes.append(doubts[-1])
        if not asked:
            raise PlanningError(self._planners.why_none(texts.requirements))
        return Found(texts, asked, None, tuple(doubts), hurried)

    def _outcome(
        self, planner: Planner, wanted: Wanted, task: PlanningTask, texts: PddlTexts, prospect: Prospect
    ) -> Work[Plan | Wrong | Unsolvable]:
        answer = yield from self._answer(planner, texts, prospect, None if task.complete else self._hurry)
        if isinstance(answer, Unsolvable):
            return answer
        return (yield from self.unhurried(proving(wanted.view, task, texts, answer, wanted.reached)))

    def unhurried(self, work: Work[T]) -> Work[T]:
        """Does work such that the control cycle can go on in between; at once while simulated time stands still."""
        if self._lockstep:
            return at_once(work)
        return (yield from in_slices(work))

    def _answer(self, planner: Planner, texts: PddlTexts, prospect: Prospect, limit: float | None) -> Work[Answer]:
        """Waits for a planner; whoever closes this meanwhile ends the call."""
        pending = planner.solve(texts.domain, texts.problem)
        try:
            yield from self._wait(pending, _PATIENCE)
            if not pending.done() and (yield from self.unhurried(prospect.is_hopeless())):
                raise _Hopeless("there is no plan")
            yield from self._wait(pending, limit)
            if not pending.done():
                raise _GivenUp(f"{planner.name} found no plan with what is nearest in {limit:g} s")
            return pending.result()
        finally:
            abandon(pending)

    def _wait(self, pending: Pending[Answer], limit: float | None) -> Work[None]:
        """Waits until an answer is there, no longer than it may take [s]."""
        end = float("inf") if limit is None else time.monotonic() + limit
        with self._waiting() if self._lockstep else nullcontext():
            while self._lockstep and not (pending.done() or self._leaving() or time.monotonic() > end):
                time.sleep(_GLANCE)
        while not (pending.done() or time.monotonic() > end):
            yield


def _doubt(planner: str, outcome: Wrong | Unsolvable) -> str:
    if isinstance(outcome, Wrong):
        return f"the plan of {planner} {outcome}"
    said = f": {outcome.reason}" if outcome.reason else ""
    return f"{planner} found no plan, and no proof that there is none{said}"
