"""Planning as one call: task, PDDL, planner, replay, explanation."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

from skiros_py.errors import PlanningError
from skiros_py.planning.attempts import Wanted, attempts
from skiros_py.planning.domain.pddl import PddlTexts
from skiros_py.planning.explanation import Trial, explain
from skiros_py.planning.plan import NoPlan, Plan
from skiros_py.planning.plan_validation import out_of_sequence
from skiros_py.planning.planners.choosing import Planners
from skiros_py.planning.planners.planner import Planner
from skiros_py.planning.problem.stock import lacks_stock, with_stock
from skiros_py.planning.problem.task import Capability, build_task
from skiros_py.planning.reasons import Cause, CauseKind
from skiros_py.planning.robots.ordering import order
from skiros_py.planning.robots.rounds import arranged
from skiros_py.planning.sequence import counts, without_numbers
from skiros_py.planning.solver_loop import Found, SolverLoop
from skiros_py.skills.conditions import Condition
from skiros_py.world.view import WorldView


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
                plan = arranged(wanted.view, task, texts, found.plan, wanted.reached)
                plan = order(wanted.view, task, texts, plan)
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
