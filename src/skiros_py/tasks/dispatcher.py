"""Hands the steps of a plan to the skill managers, and breaks off when the plan no longer leads to the goal."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from skiros_py.errors import UnknownName, UsageError
from skiros_py.execution.cycle import ControlCycle
from skiros_py.execution.running import Running
from skiros_py.execution.skill_manager import Transport
from skiros_py.planning.plan import Plan, Step
from skiros_py.planning.validation import Flaw, replay_rest
from skiros_py.skills.conditions import Condition
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
    """

    def __init__(
        self,
        world: World,
        managers: Mapping[str, Transport],
        skills: Mapping[str, SkillDescription],
        cycle: ControlCycle,
        history: History,
    ) -> None:
        self._world = world
        self._managers = managers
        self._skills = skills
        self._cycle = cycle
        self._history = history

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
            running = yield from self._started(step, step.arguments[skill.agent])
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

    def _started(self, step: Step, agent: str) -> Execution[Running]:
        """Hands a step to who shall do it, when whatever else of that name runs there has ended.

        Raises:
            UsageError: It cannot be started there.
        """
        while agent in self._managers and step.skill in self._managers[agent].running:
            yield
        if agent not in self._managers:
            raise UnknownName("skill manager", agent, self._managers)
        return self._managers[agent].start(step.skill, step.arguments)

    def _flaw(self, current: Step | None, rest: Sequence[Step], goal: Sequence[Condition]) -> Flaw | None:
        return replay_rest(self._world, current, rest, goal, self._skills)

    @property
    def _now(self) -> float:
        return self._cycle.board.snapshot.time
