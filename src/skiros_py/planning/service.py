"""Planning as one call: task, PDDL, planner, replay, explanation."""

from __future__ import annotations

import time
from collections.abc import Callable, Generator, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, replace

from skiros_py.errors import PlanningError
from skiros_py.planning.attempts import Wanted, attempts
from skiros_py.planning.domain.pddl import PddlTexts
from skiros_py.planning.explanation import Trial, explain, explaining, find_causes
from skiros_py.planning.plan import NoPlan, Plan
from skiros_py.planning.planners.choosing import Planners
from skiros_py.planning.planners.planner import Answer, Planner, Unsolvable, abandon
from skiros_py.planning.problem.stock import lacks_stock, with_stock
from skiros_py.planning.problem.task import Capability, PlanningTask
from skiros_py.planning.proving import Wrong, proved
from skiros_py.planning.reasons import Cause, CauseKind
from skiros_py.planning.robots.ordering import order
from skiros_py.planning.robots.rounds import arranged
from skiros_py.planning.sequence import counts, without_numbers
from skiros_py.planning.validation import out_of_sequence
from skiros_py.skills.conditions import Condition
from skiros_py.world.view import WorldView

__all__ = ["Planned", "PlanningService"]

_GLANCE = 0.0005
"""Time between two looks for an answer while simulated time stands still [s]."""


@dataclass(frozen=True, slots=True)
class Planned:
    """A planning result with everything it was made from.

    Attributes:
        outcome: The plan, or why there is none.
        texts: Domain and problem as given to the planner; None where none had to be asked.
        wall: Wall time from world model to replayed plan [s].
        planner: Name of the planner that gave the answer; empty where none had to be asked.
        notes: What went wrong with planners that were asked before it.
    """

    outcome: Plan | NoPlan
    texts: PddlTexts | None
    wall: float
    planner: str = ""
    notes: tuple[str, ...] = ()


class PlanningService:
    """Plans; the world given is never changed.

    Args:
        planners: What solves the PDDL: one planner, or several to choose from. Whoever made them closes them.
        name: Name of domain and problem.
        lockstep: True when simulated time stands still while the planner works.
        waiting: Says, for as long as it is entered, that a long wait for the planner is no fault.
        leaving: Tells whether somebody wants a stop: then simulated time goes on, for the stop to happen.
        temporal: True to plan in time, with a planner that takes durative actions.
    """

    def __init__(
        self,
        planners: Planner | Planners,
        name: str = "skiros",
        *,
        lockstep: bool = True,
        waiting: Callable[[], AbstractContextManager[None]] = nullcontext,
        leaving: Callable[[], bool] = lambda: False,
        temporal: bool = False,
    ) -> None:
        self.planners = planners if isinstance(planners, Planners) else Planners.only(planners)
        self._name = name
        self._lockstep = lockstep
        self._waiting = waiting
        self._leaving = leaving
        self._temporal = temporal

    def plan(
        self,
        view: WorldView,
        capabilities: Sequence[Capability],
        goal: Sequence[Condition],
        *,
        reached: Mapping[str, int] | None = None,
    ) -> Generator[None, None, Planned]:
        """Plans; yields while the planner works, unless in lockstep. Closed meanwhile, it kills the planner's call.

        Args:
            view: The world.
            capabilities: What can be done.
            goal: What shall hold, all of it.
            reached: The highest sequence number that each robot has visited in this task.

        Raises:
            PlanningError: The task cannot be written, no planner takes it, or all that do broke.
        """
        started = time.perf_counter()
        gone = sorted({a for c in goal for a in c.arguments if a not in view.ontology.classes and not view.has(a)})
        if gone:
            return Planned(NoPlan(tuple(f"there is no {name} any more" for name in gone)), None, 0.0)
        stocked = with_stock(view, goal)
        wanted = Wanted(stocked, tuple(capabilities), tuple(goal), reached or {}, self._temporal, self._name)
        planned = yield from self._planned(wanted, with_stock(view, goal, whole=True) if lacks_stock(stocked) else None)
        return replace(planned, wall=time.perf_counter() - started)

    def _planned(self, wanted: Wanted, whole: WorldView | None = None) -> Generator[None, None, Planned]:
        """Asks for a plan of the task in ever more complete forms; no plan is said of the complete one only.

        Args:
            wanted: What shall be planned.
            whole: The world with more of its stock than the goal speaks of; None where there is no more.
        """
        notes: list[str] = []
        found: _Found | None = None
        for task, texts in attempts(wanted):
            if found is None or not found.is_about(texts):
                found = yield from self._found(wanted, task, texts, notes)
            if found.plan is not None:
                plan = arranged(wanted.view, task, texts, found.plan, wanted.reached)
                plan = order(wanted.view, task, texts, plan)
                return Planned(plan, texts, 0.0, found.planner, tuple(dict.fromkeys(notes)))
            if task.complete and whole is not None:
                return (yield from self._planned(replace(wanted, view=whole)))
            if task.complete:
                outcome = yield from self._explained(wanted, task, found)
                return Planned(outcome, texts, 0.0, found.planner, tuple(dict.fromkeys(notes)))
        raise AssertionError("the last attempt is complete")

    def _found(
        self, wanted: Wanted, task: PlanningTask, texts: PddlTexts, notes: list[str]
    ) -> Generator[None, None, _Found]:
        """Asks one planner after the other until one has a plan, or has proved that there is none.

        Args:
            wanted: What shall be planned.
            task: The task.
            texts: The same, as written.
            notes: What went wrong is added to these.
        """
        doubts: list[str] = []
        asked = ""
        for planner in self.planners.fitting(texts.requirements):
            asked = planner.name
            try:
                answer = yield from self._answer(planner, texts)
                if isinstance(answer, Unsolvable):
                    outcome: Plan | Wrong | Unsolvable = answer
                else:
                    outcome = proved(wanted.view, task, texts, answer, wanted.reached)
            except PlanningError as error:
                if self.planners.closed:
                    raise
                notes.append(str(error))
                continue
            if isinstance(outcome, Plan):
                return _Found(texts, asked, outcome)
            if isinstance(outcome, Unsolvable) and outcome.proven:
                return _Found(texts, asked)
            doubts.append(_doubt(asked, outcome))
            notes.append(doubts[-1])
        if not doubts:
            raise PlanningError("; ".join(notes) if asked else self.planners.why_none(texts.requirements))
        return _Found(texts, asked, doubts=tuple(doubts))

    def _explained(self, wanted: Wanted, task: PlanningTask, found: _Found) -> Generator[None, None, Plan | NoPlan]:
        """Says why there is no plan, and what would help."""
        if counts(wanted.view):
            return (yield from self._without_numbers(wanted))
        if found.doubts:
            causes = tuple(found.cause for found in find_causes(task, wanted.view))
            return NoPlan(tuple(cause.text for cause in causes) or found.doubts, causes)
        trial = Trial(self.planners, task.capabilities)
        if self._lockstep:
            with self._waiting():
                explained = explain(task, wanted.view, trial)
        else:
            explained = yield from explaining(task, wanted.view, trial)
        return NoPlan(explained.reasons, explained.causes, explained.repairs)

    def _without_numbers(self, wanted: Wanted) -> Generator[None, None, Plan | NoPlan]:
        """Says how the plan that there would be without sequence numbers breaks them; else why there is none anyway."""
        free = yield from self._planned(replace(wanted, view=without_numbers(wanted.view)))
        if isinstance(free.outcome, NoPlan):
            return free.outcome
        skills = {c.skill.name: c.skill for c in wanted.capabilities}
        steps = free.outcome.steps
        reason = out_of_sequence(wanted.view, steps, wanted.goal, skills, reached=wanted.reached)
        return NoPlan((reason,), (Cause(CauseKind.CONFLICT, reason, wanted.goal),)) if reason else free.outcome

    def _answer(self, planner: Planner, texts: PddlTexts) -> Generator[None, None, Answer]:
        """Waits for a planner; whoever closes this meanwhile ends the call."""
        pending = planner.solve(texts.domain, texts.problem)
        try:
            with self._waiting() if self._lockstep else nullcontext():
                while self._lockstep and not (pending.done() or self._leaving()):
                    time.sleep(_GLANCE)
            while not pending.done():
                yield
            return pending.result()
        finally:
            abandon(pending)


@dataclass(frozen=True, slots=True)
class _Found:
    """What planners say of one task.

    Attributes:
        texts: The task as written.
        planner: Name of the last that was asked.
        plan: The plan; None where there is none.
        doubts: Why that is not proved, where it is not.
    """

    texts: PddlTexts
    planner: str
    plan: Plan | None = None
    doubts: tuple[str, ...] = ()

    def is_about(self, texts: PddlTexts) -> bool:
        """Tells whether it is what planners would say of these texts, too."""
        return (self.texts.domain, self.texts.problem) == (texts.domain, texts.problem)


def _doubt(planner: str, outcome: Wrong | Unsolvable) -> str:
    if isinstance(outcome, Wrong):
        return f"the plan of {planner} {outcome}"
    said = f": {outcome.reason}" if outcome.reason else ""
    return f"{planner} found no plan, and no proof that there is none{said}"
