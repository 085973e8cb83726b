"""Planning as one call: task, PDDL, planner, replay, explanation."""

from __future__ import annotations

import time
from collections.abc import Callable, Generator, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, replace

from skiros_py.errors import PlanningError
from skiros_py.planning.asking import Asking, Found
from skiros_py.planning.attempts import Wanted, attempts
from skiros_py.planning.domain.pddl import PddlTexts
from skiros_py.planning.explanation import Trial, explaining
from skiros_py.planning.pieces import Work, at_once
from skiros_py.planning.plan import NoPlan, Plan
from skiros_py.planning.planners.choosing import Planners
from skiros_py.planning.planners.planner import Planner
from skiros_py.planning.problem.stock import lacks_stock, with_stock
from skiros_py.planning.problem.task import Capability, PlanningTask, build_task
from skiros_py.planning.prospect import Prospect
from skiros_py.planning.reasons import Cause, CauseKind
from skiros_py.planning.robots.ordering import ordering
from skiros_py.planning.robots.rounds import arranging
from skiros_py.planning.sequence import counts, without_numbers
from skiros_py.planning.validation import out_of_sequence
from skiros_py.skills.conditions import Condition
from skiros_py.world.view import WorldView

__all__ = ["Planned", "PlanningService"]

_TRIES = {False: (1.0, 4.0), True: (5.0, 10.0)}
"""How long one planner, and all together, may try out what would help, by whether simulated time stands still [s].

Where it does, what is found must not depend on the clock: there it is only a guard, and what is tried is counted.
"""


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
        self._asking = Asking(self.planners, lockstep=lockstep, waiting=waiting, leaving=leaving)
        self._temporal = temporal

    def plan(
        self,
        view: WorldView,
        capabilities: Sequence[Capability],
        goal: Sequence[Condition],
        *,
        reached: Mapping[str, int] | None = None,
    ) -> Generator[None, None, Planned]:
        """Plans; yields now and then, unless in lockstep. Closed meanwhile, it kills the planner's call.

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

    def _planned(self, wanted: Wanted, whole: WorldView | None = None) -> Work[Planned]:
        """Asks for a plan of the task in ever more complete forms.

        That there is none is said of the complete one only, or where causes prove it. Those are looked for as soon as
        planners take long or something was tried in vain: they might search for minutes in what there is in plenty.

        Args:
            wanted: What shall be planned.
            whole: The world with more of its stock than the goal speaks of; None where there is no more.
        """
        notes: list[str] = []
        found: Found | None = None
        prospect = Prospect(wanted)
        for attempt in attempts(wanted):
            if attempt is None:
                yield from self._pause()
                continue
            task, texts = attempt
            if found is None or not found.is_about(texts):
                found = yield from self._asking.found(wanted, task, texts, prospect, notes)
            if found.plan is not None:
                plan = yield from self._asking.unhurried(self._improved(wanted, task, texts, found.plan))
                return Planned(plan, texts, 0.0, found.planner, _once(notes))
            is_proved = task.complete and not found.doubts
            is_hopeless = not is_proved and (yield from self._asking.unhurried(prospect.is_hopeless()))
            if (task.complete or is_hopeless) and whole is not None:
                return (yield from self._planned(replace(wanted, view=whole)))
            if task.complete or is_hopeless:
                outcome = yield from self._unplanned(wanted, () if is_hopeless else found.doubts, is_hopeless)
                return Planned(outcome, texts, 0.0, found.planner, _once(notes))
        raise AssertionError("the last attempt is complete")

    def _improved(self, wanted: Wanted, task: PlanningTask, texts: PddlTexts, plan: Plan) -> Work[Plan]:
        """Arranges what several robots do, and says what may be done side by side."""
        plan = yield from arranging(wanted.view, task, texts, plan, wanted.reached)
        return (yield from ordering(wanted.view, task, texts, plan))

    def _unplanned(self, wanted: Wanted, doubts: Sequence[str], is_hopeless: bool) -> Work[Plan | NoPlan]:
        """Says why there is no plan of the complete task.

        Args:
            wanted: What should be planned.
            doubts: Why it is not proved that there is none.
            is_hopeless: True where there is none whatever the numbers say.

        Raises:
            PlanningError: All planners broke, took too long, answered with what is no plan or gave up; and nothing else
                proves that there is none.
        """
        if doubts:
            raise PlanningError("; ".join(doubts))
        if counts(wanted.view) and not is_hopeless:
            return (yield from self._without_numbers(wanted))
        return (yield from self._explained(wanted))

    def _explained(self, wanted: Wanted) -> Work[NoPlan]:
        """Says why there certainly is no plan, and what would help."""
        task = build_task(wanted.view, wanted.capabilities, wanted.goal)
        yield from self._pause()
        each, together = _TRIES[self._lockstep]
        trial = Trial(self.planners, task.capabilities, each=each, together=together, lockstep=self._lockstep)
        with self._waiting() if self._lockstep else nullcontext():
            work = explaining(task, wanted.view, trial)
            explained = at_once(work) if self._lockstep else (yield from work)
        return NoPlan(explained.reasons, explained.causes, explained.repairs)

    def _without_numbers(self, wanted: Wanted) -> Work[Plan | NoPlan]:
        """Says how a plan that there would be without sequence numbers breaks them; else why there is none anyway.

        To be asked where it is proved that there is none with them.
        """
        free = yield from self._planned(replace(wanted, view=without_numbers(wanted.view)))
        if isinstance(free.outcome, NoPlan):
            return free.outcome
        skills = {c.skill.name: c.skill for c in wanted.capabilities}
        steps = free.outcome.steps
        reason = out_of_sequence(wanted.view, steps, wanted.goal, skills, reached=wanted.reached)
        return NoPlan((reason,), (Cause(CauseKind.CONFLICT, reason, wanted.goal),)) if reason else free.outcome

    def _pause(self) -> Work[None]:
        """Lets others go on, unless simulated time stands still."""
        if not self._lockstep:
            yield


def _once(notes: Sequence[str]) -> tuple[str, ...]:
    return tuple(dict.fromkeys(notes))
