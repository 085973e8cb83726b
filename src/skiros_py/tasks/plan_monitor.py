"""Monitors one plan: whether it still leads to the goal."""

from __future__ import annotations

from collections.abc import Mapping

from skiros_py.errors import SkirosError
from skiros_py.messages import Message
from skiros_py.planning.plan import Step
from skiros_py.planning.replay import Flaw
from skiros_py.planning.requests import Asked, Check, Checked
from skiros_py.skills.conditions import Condition, Verdict
from skiros_py.skills.conditions.watch import Reads, Watches
from skiros_py.skills.primitive import Execution
from skiros_py.skills.skill import SkillDescription
from skiros_py.tasks.context import Control, TaskContext
from skiros_py.tasks.dispatcher import Progress


class PlanMonitor:
    """Monitors whether a plan still leads to the goal.

    The rest of the plan is replayed by the planning service whenever something changed that the last replay read.

    Args:
        context: World, skill managers and planning.
        control: Control requests of the task.
        goal: What the plan leads to.
        skills: The skills of the plan by name.

    Attributes:
        goal: What the plan leads to.
        is_valid: True if nothing it depends on has changed since it was last validated; steps may start only then.
    """

    def __init__(
        self,
        context: TaskContext,
        control: Control,
        goal: tuple[Condition, ...],
        skills: Mapping[str, SkillDescription],
    ) -> None:
        self.goal = goal
        self.is_valid = False
        self._context = context
        self._control = control
        self._skills = skills
        self._reads = Reads()
        self._watches = Watches(context.world)
        self._asked: tuple[Asked[Checked], tuple[Step, ...]] | None = None

    def check(self, progress: Progress, reached: Mapping[str, int]) -> Flaw | None:
        """Returns why the rest of a plan no longer leads to the goal; requests a replay after changes.

        In lockstep the answer is waited for; otherwise it arrives in a later cycle.

        Args:
            progress: The steps of the plan.
            reached: The highest sequence number that each robot has visited in this task.

        Returns:
            The flaw; None if nothing is known against it.
        """
        flaw = None if progress.is_idle else self._lost(progress) or self._look(progress, reached)
        self.is_valid = not progress.is_idle and self._asked is None and not self._reads.stale
        return flaw

    def recheck(self, progress: Progress, reached: Mapping[str, int]) -> Execution[bool]:
        """Returns True if the rest of the plan, with failed steps repeated, still leads to the goal."""
        if self._lost(progress) is not None:
            return False
        self._drop()
        asked = self._ask(progress, reached)
        yield from self._context.answer(asked, self._control)
        return self._flaw(asked) is None

    def close(self) -> None:
        """Stops monitoring the world."""
        self._drop()
        self._watches.close()

    def _look(self, progress: Progress, reached: Mapping[str, int]) -> Flaw | None:
        """Returns the flaw known so far; requests a new check if something changed."""
        if self._asked is not None and self._asked[1] != progress.rest:
            self._drop()
            self._reads.stale = True
        if self._asked is None and self._reads.stale:
            self._asked = self._ask(progress, reached), progress.rest
            self._context.wait_in_lockstep(self._asked[0], self._control)
        if self._asked is None or not self._asked[0].done():
            return None
        asked, self._asked = self._asked[0], None
        return self._flaw(asked)

    def _ask(self, progress: Progress, reached: Mapping[str, int]) -> Asked[Checked]:
        running = tuple(one.step for one in progress.running if not one.leaving)  # what was cancelled does not succeed
        skills = {step.skill: self._skills[step.skill] for step in (*running, *progress.rest)}
        self._reads.stale = False
        return self._context.planning.ask(Check(self.goal, running, progress.rest, skills, reached))

    def _flaw(self, asked: Asked[Checked]) -> Flaw | None:
        """Reads an answer; a plan that cannot be checked counts as flawed."""
        try:
            answer = asked.result()
        except SkirosError as error:
            return Flaw(None, Verdict(False, Message("the replay: {error}", error=error)))
        self._watches.note(self._reads, answer.value.keys, answer.version)
        return answer.value.flaw

    def _drop(self) -> None:
        if self._asked is not None:
            self._asked[0].cancel()
            self._asked = None

    def _lost(self, progress: Progress) -> Flaw | None:
        """Returns a flaw for the first remaining step whose skill is no longer available."""
        for index, step in enumerate(progress.rest):
            agent = step.arguments[self._skills[step.skill].agent]
            if not self._context.offers(agent, step.skill):
                return Flaw(
                    index,
                    Verdict(False, Message("{agent} has no skill {skill} any more", agent=agent, skill=step.skill)),
                )
        return None
