"""Planning as one call: task, PDDL, planners one after the other, replay, explanation."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import islice

from skiros_py.errors import PlanningError
from skiros_py.messages import Message, all_of, listed
from skiros_py.planning.domain.numbers import endless_changes, number_needs
from skiros_py.planning.domain.pddl import PddlTexts, write_pddl
from skiros_py.planning.domain.sequencing import in_sequence, write_with_costs
from skiros_py.planning.domain.temporal import write_temporal
from skiros_py.planning.experience import Experience, timed
from skiros_py.planning.explanation.absent import AbsentSkill
from skiros_py.planning.explanation.causes import find_causes
from skiros_py.planning.explanation.explaining import explain
from skiros_py.planning.explanation.shortfalls import shortfall, uncounted
from skiros_py.planning.explanation.trial import Trial
from skiros_py.planning.plan import Cause, CauseKind, NoPlan, Plan, Repair
from skiros_py.planning.plan_validation import Wrong, validate
from skiros_py.planning.planners.planner import Planner, Planners, Unsolvable, wait_for
from skiros_py.planning.problem.stock import lacks_stock, with_stock
from skiros_py.planning.problem.task import Capability, PlanningTask, build_task
from skiros_py.planning.replay import replay
from skiros_py.planning.robots.allocation import deal
from skiros_py.planning.robots.chains import arranged, shared_out
from skiros_py.planning.robots.ordering import order
from skiros_py.planning.sequence import counts, without_numbers
from skiros_py.skills.conditions import Condition
from skiros_py.world.overlay import Overlay
from skiros_py.world.view import WorldView
from skiros_py.world.vocabulary import AT, FLOOR, ROBOT, SPATIAL_THING

_WIDTHS = (2, 16, None)
"""How many candidates are included per choice, before all of them are."""
_SMALL = 60
"""In a world with at most this many things the complete problem is as quick."""
_PATIENCE = 1.0
"""Delay until a proof that there is no plan is searched for beside the planner [s]; does not affect the result."""


@dataclass(frozen=True, slots=True)
class PlanningOptions:
    """Planning options.

    Attributes:
        name: Name of domain and problem.
        temporal: True for temporal planning, with a planner that supports durative actions.
        each: Wall time that one planner may take to try out a repair [s]. A safeguard only: the number of tries is
            counted, so that results do not depend on the clock.
        together: Wall time for all of them together [s].
        absent: Skills that are installed but cannot be used: they may be why there is no plan.
        tries: How often the first schedule of several robots is changed in order to improve it.
    """

    name: str = "skiros"
    temporal: bool = False
    each: float = 5.0
    together: float = 10.0
    absent: tuple[AbsentSkill, ...] = ()
    tries: int = 100


USUAL = PlanningOptions()
"""The default options."""


@dataclass(frozen=True, slots=True)
class Planned:
    """A planning result with everything it was made from.

    Attributes:
        outcome: The plan, or why there is none.
        texts: Domain and problem as given to the planner, or of the whole task if it was given parts of it; None if no
            planner was needed.
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
    several = planners if isinstance(planners, Planners) else Planners.only(planners)
    loop = SolverLoop(several, stocked, tuple(capabilities), tuple(goal), reached or {}, options, stopped)
    planned = loop.plan(with_stock(view, goal, whole=True) if lacks_stock(stocked) else None)
    return replace(planned, wall=time.perf_counter() - started)


@dataclass(frozen=True, slots=True)
class Found:
    """The planners' result for one task.

    Attributes:
        texts: The task as PDDL.
        planner: Name of the last planner tried.
        plan: The plan; None if there is none.
        doubts: Why the absence of a plan is not proved, if it is not.
        hurried: True if a planner that might have found one was stopped early.
    """

    texts: PddlTexts
    planner: str
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


@dataclass(eq=False)
class SolverLoop:
    """Solves the task of one goal in one world, in increasingly complete forms, until there is an answer.

    Attributes:
        planners: The planners to choose from.
        view: The world.
        capabilities: The available skills.
        goal: The conditions that must all hold.
        reached: The highest sequence number that each robot has visited in this task.
        options: How to plan.
        stopped: Returns True once planning is cancelled.
        hurry: Wall time limit of a planner for an incomplete task, or one whose numbers have no limits [s].
            Third-party planners support no other kind of limit; whether there is a plan does not depend on it.
        experience: What robots learned from their runs; read from the world if omitted.
        notes: Planner failures so far.
    """

    planners: Planners
    view: WorldView
    capabilities: tuple[Capability, ...]
    goal: tuple[Condition, ...]
    reached: Mapping[str, int] = field(default_factory=dict)
    options: PlanningOptions = USUAL
    stopped: Callable[[], bool] = lambda: False
    hurry: float = 10.0
    experience: Experience | None = None
    notes: list[str] = field(default_factory=list, init=False)

    def __post_init__(self) -> None:
        """Reads what was learned, once for all forms of the task."""
        if self.experience is None:
            self.experience = Experience(self.view)

    @cached_property
    def task(self) -> PlanningTask:
        """The complete task.

        Raises:
            PlanningError: It cannot be expressed in PDDL.
        """
        return build_task(self.view, self.capabilities, self.goal)

    @cached_property
    def is_hopeless(self) -> bool:
        """Whether causes prove, without search, that there is no plan; a planner might need minutes for that."""
        return bool(find_causes(self.task))

    def plan(self, whole: WorldView | None = None) -> Planned:
        """Plans, or explains why there is no plan.

        Only the complete form, or proven causes, can show that there is no plan. Causes are searched for as soon as
        planners take long or an attempt has failed. With many interchangeable things planners might search for
        minutes.

        Args:
            whole: The world with more of its stock than the goal mentions; None if there is no more.

        Raises:
            PlanningError: All planners failed, timed out, returned an invalid plan or gave up; and nothing else proves
                that there is no plan.
        """
        found = self._shared_out()
        if found is not None and found.plan is not None:
            return self._planned(found.plan, found.texts, found)
        for task, texts in self.attempts():
            if found is None or not found.is_about(texts):
                found = self.solve(task, texts)
            if found.plan is not None:
                plan = arranged(task, found.plan, self.reached, self.options.tries)
                return self._planned(order(task, plan), texts, found)
            is_proved = task.complete and not found.doubts
            if not is_proved and self.is_hopeless:
                found = replace(found, doubts=())
            elif not task.complete:
                continue
            if whole is not None:
                return replace(self, view=whole).plan()
            if found.doubts:
                raise PlanningError("; ".join(found.doubts))
            return self._planned(self._no_plan(can_ignore_numbers=is_proved), texts, found)
        raise AssertionError("the last attempt is complete")

    def attempts(self) -> Iterator[tuple[PlanningTask, PddlTexts]]:
        """Yields increasingly complete tasks with their texts; each is computed on demand.

        Raises:
            PlanningError: The task cannot be expressed in PDDL.
        """
        for width in self._widths:
            task = self._task(width)
            shared = deal(task)
            if shared is not task:
                yield replace(shared, complete=False), self._texts(shared)
            yield task, self._texts(task)
            if task.complete:
                return

    @cached_property
    def _widths(self) -> tuple[int | None, ...]:
        small = len(self.view.some_instances(SPATIAL_THING, _SMALL + 1)) <= _SMALL
        return _WIDTHS[-1:] if small else _WIDTHS

    def _task(self, width: int | None) -> PlanningTask:
        task = self.task if width is None else build_task(self.view, self.capabilities, self.goal, width=width)
        return in_sequence(timed(task, self.experience), self.reached)

    def _shared_out(self) -> Found | None:
        """Plans for several robots by parts of the goal; None if that does not lead to a plan."""
        if len({agent for c in self.capabilities for agent in c.agents}) < 2:
            return None
        task, planner = self._task(self._widths[0]), ""

        def plan_part(goal: Sequence[Condition]) -> Plan | None:
            nonlocal planner
            part = replace(self, view=_without_robots_in_the_way(self.view), goal=tuple(goal))
            try:
                found = part.guess()
            except PlanningError as error:
                self._check_goes_on(error)
                part.notes.append(str(error))
                return None
            finally:
                self.notes += part.notes
            planner = found.planner
            return found.plan

        plan = shared_out(task, plan_part, self.reached, self.options.tries)
        return None if plan is None else Found(self._texts(task), planner, order(task, plan))

    def guess(self) -> Found:
        """Solves only the first task, which is complete in a small world."""
        task = self._task(self._widths[0])
        return self.solve(task, self._texts(task))

    def solve(self, task: PlanningTask, texts: PddlTexts) -> Found:
        """Tries one planner after the other until one finds a plan or proves that there is none.

        Args:
            task: The task; if it is incomplete, planners get little time.
            texts: The task as PDDL.

        Raises:
            PlanningError: No planner supports it, all were closed, or planning was cancelled.
        """
        asked, hurried, known = "", False, len(self.notes)
        for planner in self.planners.fitting(texts.requirements):
            asked = planner.name
            try:
                outcome = self._outcome(planner, task, texts)
            except _Hopeless as error:
                return Found(texts, asked, None, (str(error),))
            except PlanningError as error:
                self._check_goes_on(error)
                hurried = hurried or isinstance(error, _GivenUp)
                self.notes.append(str(error))
                continue
            if isinstance(outcome, Plan):
                return Found(texts, asked, outcome)
            if isinstance(outcome, Unsolvable) and outcome.proven:
                return Found(texts, asked)
            self.notes.append(_doubt(asked, outcome))
        if not asked:
            because = "".join(f"; {why}" for why in islice(number_needs(task.domain.actions), 1))
            raise PlanningError(self.planners.why_none(texts.requirements) + because)
        return Found(texts, asked, None, tuple(self.notes[known:]), hurried)

    def _check_goes_on(self, error: PlanningError) -> None:
        """Raises an error again if all planners were closed, or planning was cancelled."""
        if self.planners.closed or self.stopped():
            raise error

    def _outcome(self, planner: Planner, task: PlanningTask, texts: PddlTexts) -> Plan | Wrong | Unsolvable:
        endless = next(endless_changes(task.domain.actions), "")

        def check(taken: float) -> None:
            if self.stopped():
                raise PlanningError("planning was stopped")
            if taken > _PATIENCE and self.is_hopeless:
                raise _Hopeless("there is no plan")
            if taken > self.hurry and not task.complete:
                raise _GivenUp(f"{planner.name} found no plan with what is nearest in {self.hurry:g} s")
            if taken > self.hurry and endless:
                raise _GivenUp(f"{planner.name} found no plan in {self.hurry:g} s, and may search for ever: {endless}")

        answer = wait_for(planner.solve(texts.domain, texts.problem), check)
        return answer if isinstance(answer, Unsolvable) else validate(task, texts, answer, self.reached)

    def _texts(self, task: PlanningTask) -> PddlTexts:
        write = write_temporal if self.options.temporal else write_with_costs
        return write(task, name=self.options.name)

    def _planned(self, outcome: Plan | NoPlan, texts: PddlTexts, found: Found) -> Planned:
        return Planned(outcome, texts, 0.0, found.planner, tuple(dict.fromkeys(self.notes)))

    def _no_plan(self, *, can_ignore_numbers: bool) -> Plan | NoPlan:
        """Explains why there certainly is no plan, and what would help.

        Args:
            can_ignore_numbers: True if there may be a plan that violates the sequence numbers: it is the explanation.
        """
        if can_ignore_numbers and counts(self.view):
            free = replace(self, view=without_numbers(self.view)).plan().outcome
            if isinstance(free, NoPlan):
                return free
            flaw = replay(self.view, free.steps, self.goal, self.task.skills, reached=self.reached)
            if flaw is None:
                return free
            reason = f"no plan keeps to the sequence numbers of this scene: {flaw.verdict.text}"
            return NoPlan((reason,), (Cause(CauseKind.CONFLICT, reason, self.goal),))
        options = self.options
        trial = Trial(self.planners, self.capabilities, options.each, options.together, self.stopped)
        answer = explain(self.task, trial, options.absent)
        return self._with_shortfall(answer)

    def _with_shortfall(self, answer: NoPlan) -> NoPlan:
        """Adds why numbers do not last, if nothing else was found, and there is a plan without them."""
        cause, *others = answer.causes
        if cause.kind is not CauseKind.CONFLICT:
            return answer
        task = build_task(self.view, self.capabilities, cause.conditions)
        free = uncounted(task)
        texts = write_pddl(free.domain, free.problem, name=self.options.name)
        for planner in self.planners.fitting(texts.requirements) if free is not task else ():
            try:
                outcome = self._outcome(planner, free, texts)
            except PlanningError as error:
                self._check_goes_on(error)
                continue
            if not isinstance(outcome, Wrong):
                break
            why, edits = shortfall(task, outcome.steps)
            text = Message(
                "{conditions} cannot be reached: {why}", conditions=listed(map(str, cause.conditions)), why=why
            )
            repairs = [Repair(all_of(list(map(str, edits))), edits)] if edits and cause.conditions == self.goal else []
            causes = (replace(cause, text=text, why=why), *others)
            return NoPlan(tuple(one.text for one in causes), causes, (*repairs, *answer.repairs))
        return answer


def _without_robots_in_the_way(view: WorldView) -> WorldView:
    """Returns the world with all robots on the floor, at no place."""
    overlay = Overlay(view)
    for floor in view.instances(FLOOR)[:1]:
        for robot in view.instances(ROBOT):
            overlay.place(robot, AT, floor)
    return overlay


def _doubt(planner: str, outcome: Wrong | Unsolvable) -> str:
    if isinstance(outcome, Wrong):
        return f"the plan of {planner} {outcome}"
    said = f": {outcome.reason}" if outcome.reason else ""
    return f"{planner} found no plan, and no proof that there is none{said}"
