"""Hands the steps of a plan to the skill managers, and breaks off when the plan no longer leads to the goal."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from skiros_py.errors import UnknownName, UsageError
from skiros_py.execution.contained import contained
from skiros_py.execution.cycle import ControlCycle
from skiros_py.execution.monitor import ModuleEvent, Monitor, Status
from skiros_py.execution.running import Running
from skiros_py.execution.skill_manager import Transport
from skiros_py.planning.plan import Plan, Step
from skiros_py.planning.validation import Flaw, replay_rest
from skiros_py.skills.conditions import Condition, Verdict
from skiros_py.skills.outcome import BROKEN_OFF, Failure, Outcome
from skiros_py.skills.primitive import Execution
from skiros_py.skills.skill import SkillDescription
from skiros_py.tasks.history import History
from skiros_py.world.world import World

__all__ = ["Dispatcher"]


class Dispatcher:
    """Runs plans for one goal.

    Args:
        world: The live world model.
        managers: Skill managers by agent id.
        skills: What they offer, by name.
        cycle: Gives the time.
        history: Takes every step that ran.
        monitor: Hears of what has to wait; None where nobody listens.
    """

    def __init__(
        self,
        world: World,
        managers: Mapping[str, Transport],
        skills: Mapping[str, SkillDescription],
        cycle: ControlCycle,
        history: History,
        monitor: Monitor | None = None,
    ) -> None:
        self._world = world
        self._managers = managers
        self._skills = skills
        self._cycle = cycle
        self._history = history
        self._monitor = monitor

    def run(self, plan: Plan, goal: Sequence[Condition]) -> Execution[None]:
        """Runs a plan until it is done or something is not as planned."""
        for index, step in enumerate(plan.steps):
            rest = plan.steps[index + 1 :]
            outcome = yield from self._run_step(step, rest, goal)
            if isinstance(outcome, Failure) or self._flaw(None, rest, goal):
                return

    def _run_step(self, step: Step, rest: Sequence[Step], goal: Sequence[Condition]) -> Execution[Outcome]:
        skill = self._skills[step.skill]
        start = self._now
        try:
            running = yield from self._started(step, rest, goal)
        except UsageError as refusal:
            failure = Failure(str(refusal), BROKEN_OFF)  # not the target's fault
            self._history.record(step, skill, start, self._now, failure)
            return failure
        seen = self._world.version
        try:
            while not running.done:
                if self._world.version != seen:
                    seen = self._world.version
                    flaw = self._flaw(step, rest, goal)
                    if flaw is not None:
                        running.break_off(f"the plan no longer leads to the goal: {flaw.verdict.text}")
                yield
        finally:
            running.stop()
        self._history.record(step, skill, start, self._now, running.result)
        return running.result

    def _started(self, step: Step, rest: Sequence[Step], goal: Sequence[Condition]) -> Execution[Running]:
        """Hands a step to who shall do it, when whatever else of that name runs there has ended.

        Raises:
            UsageError: It cannot be started there, or the plan leads to the goal no longer.
        """
        agent, seen = step.arguments[self._skills[step.skill].agent], -1
        while agent in self._managers and step.skill in self._managers[agent].running:
            if seen < 0:
                self._tell(step, agent, f"waits: {step.skill} of {agent} is running already")
            if self._world.version != seen:
                seen = self._world.version
                flaw = self._flaw(None, (step, *rest), goal)
                if flaw is not None:
                    raise UsageError(f"the plan no longer leads to the goal: {flaw.verdict.text}")
            yield
        if agent not in self._managers:
            raise UnknownName("skill manager", agent, self._managers)
        return self._managers[agent].start(step.skill, step.arguments)

    def _tell(self, step: Step, agent: str, text: str) -> None:
        if self._monitor is not None:
            self._monitor.publish(ModuleEvent(self._now, "skill", step.skill, Status.RUNNING, 0, text, agent=agent))

    def _flaw(self, current: Step | None, rest: Sequence[Step], goal: Sequence[Condition]) -> Flaw | None:
        """Looks whether the rest still leads to the goal; when nobody can tell, it does not."""
        found = contained("the replay", lambda: replay_rest(self._world, current, rest, goal, self._skills))
        return Flaw(None, Verdict(False, found.reason)) if isinstance(found, Failure) else found

    @property
    def _now(self) -> float:
        return self._cycle.board.snapshot.time
