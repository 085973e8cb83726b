"""The record of one task: executed steps, failures per target, and what became of each condition of its goal."""

from __future__ import annotations

import time
from collections import Counter, defaultdict, deque
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress

from skiros_py.errors import WorldError
from skiros_py.messages import Message, joined
from skiros_py.planning.domain.actions import with_defaults
from skiros_py.planning.plan import Step
from skiros_py.planning.problem.stock import believed
from skiros_py.planning.requests import RuledOut
from skiros_py.planning.sequence import Round
from skiros_py.skills.conditions import Condition
from skiros_py.skills.context import Tried
from skiros_py.skills.outcome import CANCELLED, OBSTRUCTED, Failure
from skiros_py.skills.skill import SkillDescription
from skiros_py.skills.surroundings import robot_of
from skiros_py.tasks.context import TaskContext
from skiros_py.tasks.report import ConditionReport, GoalReport, StepReport
from skiros_py.tasks.trace import StepEnd
from skiros_py.world.change import Edit, PlacementEdit
from skiros_py.world.view import WorldView
from skiros_py.world.vocabulary import DEVICE, ROBOT, ROOT

_LONGEST = 10_000
"""Maximum number of steps kept per task: a sequence may run for months."""


class TaskRecord:
    """The record of one task.

    Args:
        context: The task's environment.
        goal: The conditions of the goal; empty for a sequence of steps.
        attempts: How often a skill may fail on one target before that target is left out of further plans.
        longest: How many steps are kept; the oldest are dropped first.

    Attributes:
        steps: The most recent executed steps, in the order in which they ended.
        forgotten: How many earlier steps were dropped.
        reached: The highest sequence number that each robot has visited in this task.
        left_out: Targets on which a skill failed too often, each with its last failure.
        ruled_out: Attempts that failed for a reason that does not change by itself, the latest of each kind.
        tried: What was tried in vain, over retries and new plans, by what it was for (:func:`purpose`).
        worn_out: Conditions about something that failed too often, wherever it was tried.
        given_up: Conditions that were given up, with the reason.
        no_plan: Why there was no initial plan.
        stopped: True if it was stopped by a command.
        fault: Why it ended early without being stopped.
    """

    def __init__(
        self, context: TaskContext, goal: Sequence[Condition], attempts: int, *, longest: int = _LONGEST
    ) -> None:
        self.steps: deque[StepReport] = deque(maxlen=longest)
        self.forgotten = 0
        self.reached: Mapping[str, int] = {}
        self.left_out: dict[str, str] = {}
        self.ruled_out: dict[tuple[object, ...], RuledOut] = {}
        self.tried: defaultdict[tuple[str, ...], Tried] = defaultdict(Tried)
        self.worn_out: set[Condition] = set()
        self.given_up: dict[Condition, str] = {}
        self.no_plan: tuple[str, ...] = ()
        self.stopped = False
        self.fault = ""
        self._context = context
        self._first = context.world.version
        self._view = context.world
        self._goal = tuple(goal)
        self._attempts = attempts
        self._skills: dict[str, SkillDescription] = {}
        self._failures: Counter[tuple[str, ...]] = Counter()
        self._reasons: dict[str, tuple[str, Tried]] = {}
        self._round = Round(context.world)
        self._start = context.now, time.perf_counter()
        self._since: dict[Condition, tuple[float, float]] = {}
        self._version = -1
        self._note_conditions()
        self._held = frozenset(self._since)

    def update(self, ended: Iterable[StepEnd]) -> None:
        """Adds steps that have ended, and notes which conditions hold by now."""
        for end in ended:
            self._add(end)
        self._note_conditions()

    def _add(self, end: StepEnd) -> None:
        """Adds one step; being cancelled because the world changed, or obstructed, is no failure at its target."""
        step, skill, outcome = end.run.step, end.skill, end.outcome
        reason = outcome.reason if isinstance(outcome, Failure) else ""
        self._skills[step.skill] = skill
        self.forgotten += len(self.steps) == self.steps.maxlen
        arguments = dict(step.arguments)
        self.steps.append(StepReport(step.skill, arguments, end.run.start, end.time, reason, arguments[skill.agent]))
        target = arguments.get(skill.target)  # the user may have left it open
        if target is not None and isinstance(outcome, Failure) and outcome.code not in (CANCELLED, OBSTRUCTED):
            self._reasons.pop(target, None)  # the latest failure is the last entry
            self._reasons[target] = reason, self.tried[purpose(step, skill, self._view)]
            self._count_failure(step, skill, reason)
            if outcome.is_final:
                self._rule_out(step, skill, outcome)
        if not reason:
            self._round.take(self._view, skill, with_defaults(skill, step.arguments))
            self.reached = dict(self._round.reached)

    def _count_failure(self, step: Step, skill: SkillDescription, reason: str) -> None:
        """Counts a failure: at the target, of what is moved, and of the same cause, whatever the target is.

        So a part that fits nowhere is not tried in every compartment, nor a base that cannot leave at every location.
        """
        target, agent = step.arguments[skill.target], step.arguments[skill.agent]
        moved = purpose(step, skill, self._view)
        keys = {(step.skill, target), moved, *([(step.skill, agent, reason)] if self._goal else [])}
        self._failures.update(keys)
        if any(self._failures[key] >= self._attempts for key in keys):
            self.left_out[target] = reason
        if target not in moved and self._failures[moved] >= self._attempts:
            self.worn_out.update(c for c in self._goal if self._is_for(self.steps[-1], c))

    def _rule_out(self, step: Step, skill: SkillDescription, failure: Failure) -> None:
        """Notes attempts that would fail again."""
        for thing in failure.values.get("out_of_reach", ()):
            self._reasons[thing] = self._reasons[step.arguments[skill.target]]
        self.avoid(would_fail_again(step, skill, failure, self._view))

    def avoid(self, attempts: Iterable[RuledOut]) -> None:
        """Notes attempts that are not planned again."""
        self.ruled_out.update({(one.skill, one.agent, one.target, one.place, one.blocker): one for one in attempts})

    def is_ruled_out(self, step: Step, skill: SkillDescription) -> bool:
        """Returns whether a step is one of the attempts that failed for good, wherever the robot was."""
        agent, target = step.arguments[skill.agent], step.arguments.get(skill.target)
        agents = (agent, robot_of(self._view, agent))
        always = (one for one in self.ruled_out.values() if one.blocker is None)
        return any(one.is_of(step.skill, agents, target) for one in always)

    def forgive(self, condition: Condition) -> None:
        """Clears the excluded targets, and why a condition was not reached: the situation has changed."""
        self._failures.clear()
        self.tried.clear()
        self.worn_out.clear()
        self.left_out.clear()
        self.ruled_out.clear()
        self._reasons = {t: why for t, why in self._reasons.items() if not self._concerns(condition, t)}

    # ------------------------------------------------------------------ conditions

    def _note_conditions(self) -> None:
        """Evaluates the conditions if the world has changed."""
        if self._version == self._view.version:
            return
        self._version = self._view.version
        for condition in self._goal:
            if not believed(condition, self._view):
                self._since.pop(condition, None)
            elif condition not in self._since:
                self._since[condition] = self._used()

    def _used(self) -> tuple[float, float]:
        """Returns simulated and wall time since the start [s]."""
        return self._context.now - self._start[0], time.perf_counter() - self._start[1]

    # ------------------------------------------------------------------ the report

    def report(self) -> GoalReport:
        """Returns the report at the end."""
        self._note_conditions()
        steps = tuple(self.steps)
        no_plan = () if steps else self.no_plan
        why = "; ".join(no_plan) or self.fault or ("stopped before it was reached" if self.stopped else "")
        given_up = (dict.fromkeys(self._goal, why) if why else {}) | self.given_up
        holds = {c: bool(believed(c, self._view)) for c in self._goal}
        conditions = tuple(
            self._condition(c, holds=h, reason="" if h else self.why_missing(c, given_up)) for c, h in holds.items()
        )
        stopped = self.stopped and not (conditions and all(c.believed for c in conditions))
        return GoalReport(
            conditions, steps, *self._used(), no_plan, stopped=stopped, fault=self.fault, forgotten=self.forgotten
        )

    def report_cut_off(self) -> GoalReport:
        """Returns the report without further queries: the state when the world was last evaluated."""
        why = self._context.cycle.halted
        held = {c: c in self._since for c in self._goal}
        conditions = tuple(self._condition(c, holds=h, reason="" if h else why or "stopped") for c, h in held.items())
        return GoalReport(conditions, tuple(self.steps), *self._used(), stopped=not why, fault=why)

    def _condition(self, c: Condition, *, holds: bool, reason: str) -> ConditionReport:
        """Returns the report of a condition; since when it holds is known if the world was evaluated then."""
        since = self._since.get(c, (None, None))
        return ConditionReport(str(c), holds, None, self._tries(c, holds=holds), reason, *since)

    def _tries(self, condition: Condition, *, holds: bool) -> int:
        """Counts the attempts at this condition: each failed step made for it, and the success."""
        if condition in self._held:
            return 0
        own = [step for step in self.steps if self._is_for(step, condition)]
        failed = sum(bool(step.reason) for step in own)
        return failed + 1 if own and holds else failed

    def why_missing(self, condition: Condition, given_up: Mapping[Condition, str]) -> str:
        """Returns the last failure; if there was none, why there is no plan."""
        failed = [(target, why) for target, why in self._reasons.items() if self._concerns(condition, target)]
        if not failed:
            reason = given_up.get(condition, Message("it does not hold any more"))
            return joined("; ", filter(None, (self._why_lost(condition), reason)))
        target, (reason, tried) = failed[-1]
        if target not in self.left_out:
            return reason
        said = {"reason": reason, "thing": target, "count": self._attempts}
        text = Message("{reason}; gave up on {thing} after {count} failed tries", **said)
        return Message("{text} (tried: {tried})", text=text, tried=joined(", ", tried.texts)) if tried.texts else text

    def _why_lost(self, condition: Condition) -> str:
        """Returns how the last thing that this condition is about was lost in this task; an empty text if none was."""
        with suppress(WorldError):  # the journal was compacted since
            for change in reversed(self._context.world.changes_since(self._first)):
                if any(self._is_loss(edit, condition) for edit in change.edits):
                    return change.reason
        return ""

    def _is_loss(self, edit: Edit, condition: Condition) -> bool:
        if not isinstance(edit, PlacementEdit) or edit.old is None or edit.new is None:
            return False
        lost = self._view.has(edit.new.place) and self._is_a(edit.new.place, ROOT)
        return lost and self._concerns(condition, edit.element)

    def _is_for(self, step: StepReport, condition: Condition) -> bool:
        """Returns True if the step's target, or an element it moves, occurs in the condition."""
        skill = self._skills[step.skill]
        if self._names_another_target(condition, step.arguments[skill.target], skill.param(skill.target).element_class):
            return False
        values = with_defaults(skill, step.arguments)
        return any(
            self._concerns(condition, values[key])
            for key in (*_moved(skill, self._view), skill.target)
            if key in values
        )

    def _names_another_target(self, condition: Condition, target: str, class_: str) -> bool:
        """Returns True if the condition names an element of the target's class other than this target."""
        named = [a for a in condition.arguments if self._view.has(a)]
        return target not in named and any(self._is_a(a, class_) for a in named)

    def _concerns(self, condition: Condition, element: str) -> bool:
        """Returns True if a condition names an element or a class of it."""
        classes = [a for a in condition.arguments if a in self._view.ontology.classes]
        named = set(condition.arguments).difference(classes)
        return element in named or (self._view.has(element) and any(self._is_a(element, c) for c in classes))

    def _is_a(self, element: str, class_: str) -> bool:
        return self._view.ontology.is_a(self._view.element(element).type, class_)


def would_fail_again(step: Step, skill: SkillDescription, failure: Failure, view: WorldView) -> tuple[RuledOut, ...]:
    """Returns which attempts would fail as one did that is final.

    They are all to which a thing is out of reach, those at the same target from the same place, or all for which a
    device is needed that has failed.
    """
    agent, target, place = step.arguments[skill.agent], None, None
    robot = robot_of(view, agent)
    if missing := failure.values.get("out_of_reach", ()):
        return tuple(RuledOut(None, robot, thing, None, failure.reason) for thing in missing)
    if failure.is_out_of_reach:
        target = step.arguments[skill.target]
        placement = view.placement(robot) if view.has(robot) else None
        place = placement.place if placement is not None else None
    return (RuledOut(step.skill, agent, target, place, failure.reason),)


def purpose(step: Step, skill: SkillDescription, view: WorldView) -> tuple[str, ...]:
    """Returns a skill with what it moves: whatever its target is, that is tried again."""
    moved = [key for key in _moved(skill, view) if key != skill.target] or [skill.target]
    values = with_defaults(skill, step.arguments)
    return (step.skill, *(str(values[key]) for key in moved if key in values))


def _moved(skill: SkillDescription, view: WorldView) -> list[str]:
    """Returns the parameters of what a skill changes, other than robots and devices."""
    is_a, changed = view.ontology.is_a, dict.fromkeys(key for post in skill.post for key in post.arguments)
    return [key for key in changed if not any(is_a(skill.param(key).element_class, c) for c in (ROBOT, DEVICE))]
