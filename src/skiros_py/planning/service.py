"""Planning as one call: task, PDDL, planners one after the other, replay, explanation."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

from skiros_py.errors import PlanningError
from skiros_py.planning.domain.pddl import PddlTexts
from skiros_py.planning.domain.sequencing import in_sequence, write_with_costs
from skiros_py.planning.domain.temporal import write_temporal
from skiros_py.planning.durations import timed
from skiros_py.planning.explanation import Trial, explain, find_causes
from skiros_py.planning.plan import Cause, CauseKind, NoPlan, Plan
from skiros_py.planning.plan_validation import Wrong, validate
from skiros_py.planning.planners.planner import Answer, Planner, Planners, Unsolvable, wait_for
from skiros_py.planning.problem.stock import lacks_stock, with_stock
from skiros_py.planning.problem.task import Capability, PlanningTask, build_task
from skiros_py.planning.replay import out_of_sequence
from skiros_py.planning.robots.allocation import deal
from skiros_py.planning.robots.ordering import order
from skiros_py.planning.robots.rounds import arranged
from skiros_py.planning.sequence import counts, without_numbers
from skiros_py.skills.conditions import Condition
from skiros_py.world.view import WorldView
from skiros_py.world.vocabulary import SPATIAL_THING

_WIDTHS = (2, 16)
"""How many candidates are included per choice, before all of them are."""
_SMALL = 60
"""In a world with at most this many things the complete problem is as quick."""


@dataclass(frozen=True, slots=True)
class Wanted:
    """What to plan.

    Attributes:
        view: The world.
        capabilities: The available skills.
        goal: The conditions that must all hold.
        reached: The highest sequence number that each robot has visited in this task.
        temporal: True for temporal planning, with durative actions.
        name: Name of domain and problem.
    """

    view: WorldView
    capabilities: tuple[Capability, ...]
    goal: tuple[Condition, ...]
    reached: Mapping[str, int] = field(default_factory=dict)
    temporal: bool = False
    name: str = "skiros"


def attempts(wanted: Wanted) -> Iterator[tuple[PlanningTask, PddlTexts]]:
    """Yields increasingly complete tasks with their texts; each is computed on demand.

    Raises:
        PlanningError: The task cannot be expressed in PDDL.
    """
    for width in _widths(wanted.view):
        task = _task(wanted, width)
        shared = deal(task)
        if shared is not task:
            yield replace(shared, complete=False), _texts(wanted, shared)
        yield task, _texts(wanted, task)
        if task.complete:
            return


def _widths(view: WorldView) -> tuple[int | None, ...]:
    small = len(view.some_instances(SPATIAL_THING, _SMALL + 1)) <= _SMALL
    return (None,) if small else (*_WIDTHS, None)


def _task(wanted: Wanted, width: int | None) -> PlanningTask:
    task = build_task(wanted.view, wanted.capabilities, wanted.goal, width=width)
    return in_sequence(timed(task), wanted.reached)


def _texts(wanted: Wanted, task: PlanningTask) -> PddlTexts:
    if wanted.temporal:
        return write_temporal(task, name=wanted.name)
    return write_with_costs(task, name=wanted.name)


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
        return validate(task, texts, answer, self._wanted.reached)

    def _answer(self, planner: Planner, texts: PddlTexts, limit: float | None) -> Answer:
        def check(taken: float) -> None:
            if self._stopped():
                raise PlanningError("planning was stopped")
            if taken > _PATIENCE and self.is_hopeless():
                raise _Hopeless("there is no plan")
            if limit is not None and taken > limit:
                raise _GivenUp(f"{planner.name} found no plan with what is nearest in {limit:g} s")

        return wait_for(planner.solve(texts.domain, texts.problem), check)


def _doubt(planner: str, outcome: Wrong | Unsolvable) -> str:
    if isinstance(outcome, Wrong):
        return f"the plan of {planner} {outcome}"
    said = f": {outcome.reason}" if outcome.reason else ""
    return f"{planner} found no plan, and no proof that there is none{said}"


@dataclass(frozen=True, slots=True)
class PlanningOptions:
    """Planning options.

    Attributes:
        name: Name of domain and problem.
        temporal: True for temporal planning, with a planner that supports durative actions.
        each: Wall time that one planner may take to try out a repair [s]. A safeguard only: the number of tries is
            counted, so that results do not depend on the clock.
        together: Wall time for all of them together [s].
    """

    name: str = "skiros"
    temporal: bool = False
    each: float = 5.0
    together: float = 10.0


USUAL = PlanningOptions()
"""The default options."""


@dataclass(frozen=True, slots=True)
class Planned:
    """A planning result with everything it was made from.

    Attributes:
        outcome: The plan, or why there is none.
        texts: Domain and problem as given to the planner; None if no planner was needed.
        wall: Wall time from world model to replayed plan [s].
        planner: Name of the planner that gave the answer; empty if no planner was needed.
        notes: Failures of planners that were tried before it.
    """

    outcome: Plan | NoPlan
    texts: PddlTexts | None
    wall: float
    planner: str = ""
    notes: tuple[str, ...] = ()


def plan(
    planners: Planner | Planners,
    view: WorldView,
    capabilities: Sequence[Capability],
    goal: Sequence[Condition],
    *,
    reached: Mapping[str, int] | None = None,
    options: PlanningOptions = USUAL,
    stopped: Callable[[], bool] = lambda: False,
) -> Planned:
    """Plans; the given world is never changed.

    Args:
        planners: What solves the PDDL: one planner, or several to choose from. They are not closed.
        view: The world.
        capabilities: The available skills.
        goal: The conditions that must all hold.
        reached: The highest sequence number that each robot has visited in this task.
        options: How to plan.
        stopped: Polled while a planner works; returns True once planning is cancelled.

    Raises:
        PlanningError: The task cannot be expressed in PDDL, no planner supports it, all planners failed, or it was
            cancelled.
    """
    started = time.perf_counter()
    gone = sorted({a for c in goal for a in c.arguments if a not in view.ontology.classes and not view.has(a)})
    if gone:
        return Planned(NoPlan(tuple(f"there is no {name} any more" for name in gone)), None, 0.0)
    stocked = with_stock(view, goal)
    wanted = Wanted(stocked, tuple(capabilities), tuple(goal), reached or {}, options.temporal, options.name)
    several = planners if isinstance(planners, Planners) else Planners.only(planners)
    planning = _Planning(several, options, stopped)
    planned = planning.plan(wanted, with_stock(view, goal, whole=True) if lacks_stock(stocked) else None)
    return replace(planned, wall=time.perf_counter() - started)


class _Planning:
    def __init__(self, planners: Planners, options: PlanningOptions, stopped: Callable[[], bool]) -> None:
        self._planners = planners
        self._options = options
        self._stopped = stopped

    def plan(self, wanted: Wanted, whole: WorldView | None = None) -> Planned:
        """Solves the task in increasingly complete forms.

        Only the complete form, or proven causes, can show that there is no plan. Causes are searched for as soon as
        planners take long or an attempt has failed. With many interchangeable things planners might search for
        minutes.

        Args:
            wanted: The planning task.
            whole: The world with more of its stock than the goal mentions; None if there is no more.
        """
        solver = SolverLoop(self._planners, wanted, self._stopped)
        found: Found | None = None
        for task, texts in attempts(wanted):
            if found is None or not found.is_about(texts):
                found = solver.solve(task, texts)
            if found.plan is not None:
                plan = order(task, arranged(task, found.plan, wanted.reached))
                return Planned(plan, texts, 0.0, found.planner, _once(solver.notes))
            is_proved = task.complete and not found.doubts
            is_hopeless = not is_proved and solver.is_hopeless()
            if (task.complete or is_hopeless) and whole is not None:
                return self.plan(replace(wanted, view=whole))
            if task.complete or is_hopeless:
                outcome = self._unplanned(wanted, () if is_hopeless else found.doubts, is_hopeless)
                return Planned(outcome, texts, 0.0, found.planner, _once(solver.notes))
        raise AssertionError("the last attempt is complete")

    def _unplanned(self, wanted: Wanted, doubts: Sequence[str], is_hopeless: bool) -> Plan | NoPlan:
        """Explains why the complete task has no plan.

        Args:
            wanted: The planning task.
            doubts: Why it is not proved that there is no plan.
            is_hopeless: True if there is no plan even without the numbers.

        Raises:
            PlanningError: All planners failed, timed out, returned an invalid plan or gave up; and nothing else proves
                that there is no plan.
        """
        if doubts:
            raise PlanningError("; ".join(doubts))
        if counts(wanted.view) and not is_hopeless:
            return self._without_numbers(wanted)
        return self._explained(wanted)

    def _explained(self, wanted: Wanted) -> NoPlan:
        """Explains why there certainly is no plan, and what would help."""
        task = build_task(wanted.view, wanted.capabilities, wanted.goal)
        options = self._options
        trial = Trial(
            self._planners, task.capabilities, each=options.each, together=options.together, stopped=self._stopped
        )
        explained = explain(task, wanted.view, trial)
        return NoPlan(explained.reasons, explained.causes, explained.repairs)

    def _without_numbers(self, wanted: Wanted) -> Plan | NoPlan:
        """Explains how a plan without sequence numbers violates them; otherwise why there is no plan at all.

        To be called if it is proved that there is no plan with them.
        """
        free = self.plan(replace(wanted, view=without_numbers(wanted.view)))
        if isinstance(free.outcome, NoPlan):
            return free.outcome
        skills = {c.skill.name: c.skill for c in wanted.capabilities}
        steps = free.outcome.steps
        reason = out_of_sequence(wanted.view, steps, wanted.goal, skills, reached=wanted.reached)
        return NoPlan((reason,), (Cause(CauseKind.CONFLICT, reason, wanted.goal),)) if reason else free.outcome


def _once(notes: Sequence[str]) -> tuple[str, ...]:
    return tuple(dict.fromkeys(notes))
