"""The task manager: goal → plan → done, or the rest of the goal done and why something is missing (paper §3.4)."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from contextlib import closing

from skiros_py.execution.cycle import ControlCycle
from skiros_py.execution.skill_manager import Transport
from skiros_py.planning.plan import NoPlan, Plan, Step
from skiros_py.planning.service import Planned, PlanningService
from skiros_py.planning.task import Capability
from skiros_py.planning.validation import replay_rest
from skiros_py.skills.conditions import Condition
from skiros_py.skills.outcome import BROKEN_OFF, Failure, Outcome
from skiros_py.skills.primitive import Execution
from skiros_py.skills.skill import SkillDescription
from skiros_py.tasks.report import ConditionReport, GoalReport, StepReport
from skiros_py.world.view import WorldView
from skiros_py.world.vocabulary import DEVICE, HAS_SKILL, ROBOT
from skiros_py.world.without import Without
from skiros_py.world.world import World

__all__ = ["TaskManager"]


class TaskManager:
    """Pursues goals with the skill managers that are there.

    Args:
        world: The live world model.
        managers: Skill managers by agent id.
        planning: Plans.
        cycle: Runs everything.
        on_plan: Told of every new plan.
        attempts: How often a skill may fail on one target before that target is left out of further plans.
    """

    def __init__(
        self,
        world: World,
        managers: Mapping[str, Transport],
        planning: PlanningService,
        cycle: ControlCycle,
        *,
        on_plan: Callable[[Planned], None] = lambda _planned: None,
        attempts: int = 3,
    ) -> None:
        self._world = world
        self._managers = managers
        self._planning = planning
        self._cycle = cycle
        self._on_plan = on_plan
        self._attempts = attempts
        self._forget()

    def _forget(self) -> None:
        """Starts a goal with a clean slate: what failed for the last one may work for this one."""
        self.steps: list[StepReport] = []
        self._failures: Counter[tuple[str, str]] = Counter()
        self._reasons: dict[str, str] = {}
        self._since: dict[Condition, tuple[float, float]] = {}
        self._noted = -1

    @property
    def capabilities(self) -> tuple[Capability, ...]:
        """The skills that the world model says are there, with who has them."""
        found: dict[str, tuple[SkillDescription, list[str]]] = {}
        for agent, manager in sorted(self._managers.items()):
            registered = {self._world.element(s).label for s in self._world.objects(agent, HAS_SKILL)}
            for name, description in manager.descriptions.items():
                if name in registered:
                    found.setdefault(name, (description, []))[1].append(agent)
        return tuple(Capability(d, tuple(agents)) for _, (d, agents) in sorted(found.items()))

    def plan(self, goal: Sequence[Condition]) -> Execution[Planned]:
        """Plans from what is believed now, leaving out targets on which skills failed too often."""
        return self._planning.plan(self._view(), self.capabilities, goal)

    def pursue(self, goal: Sequence[Condition]) -> Execution[GoalReport]:
        """Pursues a goal to its end.

        What fails is tried again or planned anew a bounded number of times; what can no longer be reached is given up,
        and the rest of the goal is still done.
        """
        self._forget()
        started = self._cycle.board.snapshot.time, time.perf_counter()
        self._note_what_holds(goal, started)
        wanted = [c for c in goal if not c.evaluate(self._world)]
        held = set(goal) - set(wanted)
        given_up: dict[Condition, str] = {}
        no_plan: tuple[str, ...] = ()
        plans = 0
        while wanted and plans < self._attempts * (len(goal) + 2):
            plans += 1
            planned = yield from self.plan(self._keep(goal, given_up))
            if isinstance(planned.outcome, Plan):
                self._on_plan(planned)
                with closing(self._dispatch(planned.outcome, self._keep(goal, given_up))) as dispatch:
                    for _ in dispatch:
                        self._note_what_holds(goal, started)
                        yield
                given_up |= self._hopeless(self._keep(goal, given_up))
            elif not self.steps:
                no_plan = planned.outcome.reasons
                self._on_plan(planned)
                break
            else:
                given_up |= yield from self._unreachable(self._keep(goal, given_up), planned.outcome)
            wanted = [c for c in self._keep(goal, given_up) if not c.evaluate(self._world)]
        self._note_what_holds(goal, started)
        reports = tuple(self._condition_report(c, given_up, c in held) for c in goal)
        return GoalReport(reports, tuple(self.steps), *self._used(started), no_plan)

    def _used(self, started: tuple[float, float]) -> tuple[float, float]:
        """Returns simulated and wall time since the start [s]."""
        return self._cycle.board.snapshot.time - started[0], time.perf_counter() - started[1]

    def _note_what_holds(self, goal: Sequence[Condition], started: tuple[float, float]) -> None:
        """Notes when each condition came to be believed, whenever the world has changed."""
        if self._noted == self._world.version:
            return
        self._noted = self._world.version
        for condition in goal:
            if not condition.evaluate(self._world):
                self._since.pop(condition, None)
            elif condition not in self._since:
                self._since[condition] = self._used(started)

    @staticmethod
    def _keep(goal: Sequence[Condition], given_up: Mapping[Condition, str]) -> tuple[Condition, ...]:
        return tuple(c for c in goal if c not in given_up)

    @property
    def _left_out(self) -> frozenset[str]:
        """Targets on which a skill failed too often."""
        return frozenset(target for (_, target), count in self._failures.items() if count >= self._attempts)

    def _view(self) -> WorldView:
        return Without(self._world, self._left_out) if self._left_out else self._world

    def _hopeless(self, goal: Sequence[Condition]) -> dict[Condition, str]:
        """Returns conditions that name a target left out and do not hold, with the reason."""
        out = self._left_out
        return {
            c: f"gave up after {self._attempts} tries"
            for c in goal
            if out.intersection(c.arguments) and not c.evaluate(self._world)
        }

    def _dispatch(self, plan: Plan, goal: Sequence[Condition]) -> Execution[None]:
        """Runs a plan until it is done or something is not as planned."""
        for index, step in enumerate(plan.steps):
            rest = plan.steps[index + 1 :]
            outcome = yield from self._run(step, rest, goal)
            if isinstance(outcome, Failure):
                return
            if self._flaw(rest, goal):
                return

    def _run(self, step: Step, rest: Sequence[Step], goal: Sequence[Condition]) -> Execution[Outcome]:
        capability = next(c for c in self.capabilities if c.skill.name == step.skill)
        manager = self._managers[step.arguments[capability.skill.agent]]
        start = self._cycle.board.snapshot.time
        running = manager.start(step.skill, step.arguments)
        seen = self._world.version
        try:
            while not running.done:
                if self._world.version != seen:
                    seen = self._world.version
                    reason = self._obsolete(step, rest, goal)
                    if reason:
                        running.break_off(reason)
                yield
        finally:
            running.stop()
        self._record(step, capability.skill, start, running.result)
        return running.result

    def _record(self, step: Step, skill: SkillDescription, start: float, outcome: Outcome) -> None:
        reason = outcome.reason if isinstance(outcome, Failure) else ""
        self.steps.append(StepReport(step.skill, dict(step.arguments), start, self._cycle.board.snapshot.time, reason))
        if isinstance(outcome, Failure) and outcome.code != BROKEN_OFF:
            target = step.arguments[skill.target]
            self._failures[step.skill, target] += 1
            self._reasons[target] = reason

    def _obsolete(self, step: Step, rest: Sequence[Step], goal: Sequence[Condition]) -> str | None:
        """Says why going on makes no sense after the world changed, if it does not."""
        flaw = replay_rest(self._world, step, rest, goal, self._skills())
        return f"the plan no longer leads to the goal: {flaw.verdict.text}" if flaw else None

    def _flaw(self, rest: Sequence[Step], goal: Sequence[Condition]) -> bool:
        return replay_rest(self._world, None, rest, goal, self._skills()) is not None

    def _skills(self) -> dict[str, SkillDescription]:
        return {c.skill.name: c.skill for c in self.capabilities}

    def _unreachable(self, goal: Sequence[Condition], answer: NoPlan) -> Execution[dict[Condition, str]]:
        """Finds a subset of the goal that can be reached together and returns the rest with reasons."""
        kept: list[Condition] = []
        dropped: dict[Condition, str] = {}
        for condition in goal:
            planned = yield from self.plan((*kept, condition))
            if isinstance(planned.outcome, Plan):
                kept.append(condition)
            else:
                dropped[condition] = "; ".join(planned.outcome.reasons)
        if not dropped:  # each was reachable in turn, so the whole is: only a planner that errs gets here
            dropped = {condition: "; ".join(answer.reasons) for condition in goal}
        return dropped

    def _condition_report(self, c: Condition, given_up: Mapping[Condition, str], held: bool) -> ConditionReport:
        verdict = c.evaluate(self._world)
        tries = 0 if held else self._tries(c, holds=bool(verdict))
        reason = "" if verdict else self._why_missing(c, given_up)
        return ConditionReport(str(c), bool(verdict), None, tries, reason, *self._since.get(c, (None, None)))

    def _tries(self, condition: Condition, *, holds: bool) -> int:
        """Counts the tries it took: each failed step that was for this condition is one, and so is the success."""
        own = [step for step in self.steps if self._is_for(step, condition)]
        failed = sum(bool(step.reason) for step in own)
        return failed + 1 if own and holds else failed

    def _is_for(self, step: StepReport, condition: Condition) -> bool:
        """Tells whether what a step is done to, or what it moves, is what the condition speaks of."""
        skill = self._skills()[step.skill]
        if self._names_another_target(condition, step.arguments[skill.target], skill.param(skill.target).type):
            return False
        moved = {a for post in skill.post for a in post.arguments if not self._is_hardware(skill.param(a).type)}
        subjects = {step.arguments[key] for key in moved | {skill.target}}
        return any(self._fits(subject, argument) for subject in subjects for argument in condition.arguments)

    def _names_another_target(self, condition: Condition, target: str, class_: str) -> bool:
        """Tells whether the condition is about one element of the kind of target, and not about this one."""
        named = [a for a in condition.arguments if self._world.has(a)]
        return target not in named and any(
            self._world.ontology.is_a(self._world.element(a).type, class_) for a in named
        )

    def _is_hardware(self, class_: str) -> bool:
        return any(self._world.ontology.is_a(class_, own) for own in (ROBOT, DEVICE))

    def _fits(self, element: str, argument: str) -> bool:
        if not self._world.has(element):
            return False
        is_class = argument in self._world.ontology.classes
        return (
            self._world.ontology.is_a(self._world.element(element).type, argument) if is_class else element == argument
        )

    def _why_missing(self, condition: Condition, given_up: Mapping[Condition, str]) -> str:
        """Says what went wrong last; only where nothing did, why there is no plan."""
        failed = [(t, r) for t, r in self._reasons.items() if any(self._fits(t, a) for a in condition.arguments)]
        if not failed:
            return given_up.get(condition, "")
        target, reason = failed[-1]
        gave_up = f"; gave up on {target} after {self._attempts} failed tries" if target in self._left_out else ""
        return reason + gave_up
