"""Monitors one plan: whether it still leads to the goal."""

from __future__ import annotations

import threading
from collections.abc import Mapping
from dataclasses import dataclass

from skiros_py.errors import SkirosError
from skiros_py.messages import Message
from skiros_py.planning.plan import Step
from skiros_py.planning.replay import Flaw
from skiros_py.planning.requests import Asked, Check, Checked
from skiros_py.skills.conditions import Condition, Verdict
from skiros_py.skills.conditions.watch import Key, touched_by
from skiros_py.skills.primitive import Execution
from skiros_py.skills.skill import SkillDescription
from skiros_py.tasks.context import Control, TaskContext
from skiros_py.tasks.dispatcher import Progress
from skiros_py.world.change import Change
from skiros_py.world.world import World


class Staleness:
    """Detects changes that invalidate an answer. Used by one thread; any thread may write the world.

    Args:
        world: The live world model.

    Attributes:
        stale: True if something has changed that the answer depends on, or there is no answer. False is set before
            a check is requested, so that later changes count.
    """

    def __init__(self, world: World) -> None:
        self.stale = True
        self._world = world
        self._keys: frozenset[Key] = frozenset()
        self._heard = world.version
        self._guard = threading.Lock()
        self._unsubscribe = world.subscribe(self._hear)

    def read(self, keys: frozenset[Key], version: int) -> None:
        """Records what the answer depends on.

        Args:
            keys: What was read.
            version: The world version that was read.
        """
        with self._guard:
            self._keys = keys
            self.stale = self.stale or self._heard > version

    def close(self) -> None:
        """Unsubscribes from world changes."""
        self._unsubscribe()

    def _hear(self, change: Change) -> None:
        """Called in the writing thread, so it only compares keys."""
        with self._guard:
            self._heard = change.number
            touched = (key for edit in change.edits for key in touched_by(edit, self._world.ontology))
            self.stale = self.stale or any(key in self._keys for key in touched)


@dataclass(frozen=True, slots=True)
class PlanState:
    """What is known about a plan.

    Attributes:
        flaw: Why the rest of it no longer leads to the goal; None if nothing is known against it.
        is_valid: True if nothing it depends on has changed since it was last validated; steps may start only then.
    """

    flaw: Flaw | None = None
    is_valid: bool = False


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
    """

    def __init__(
        self,
        context: TaskContext,
        control: Control,
        goal: tuple[Condition, ...],
        skills: Mapping[str, SkillDescription],
    ) -> None:
        self.goal = goal
        self._context = context
        self._control = control
        self._skills = skills
        self._staleness = Staleness(context.world)
        self._asked: tuple[Asked[Checked], tuple[Step, ...]] | None = None

    def check(self, progress: Progress, reached: Mapping[str, int]) -> PlanState:
        """Returns what is known about the rest of a plan; requests a replay after changes.

        In lockstep the answer is waited for; otherwise it arrives in a later cycle.

        Args:
            progress: The steps of the plan.
            reached: The highest sequence number that each robot has visited in this task.
        """
        if progress.is_idle:
            return PlanState()
        flaw = self._lost(progress) or self._look(progress, reached)
        return PlanState(flaw, self._asked is None and not self._staleness.stale)

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
        self._staleness.close()

    def _look(self, progress: Progress, reached: Mapping[str, int]) -> Flaw | None:
        """Returns the flaw known so far; requests a new check if something changed."""
        if self._asked is not None and self._asked[1] != progress.rest:
            self._drop()
            self._staleness.stale = True
        if self._asked is None and self._staleness.stale:
            self._asked = self._ask(progress, reached), progress.rest
            self._context.wait_in_lockstep(self._asked[0], self._control)
        if self._asked is None or not self._asked[0].done():
            return None
        asked, self._asked = self._asked[0], None
        return self._flaw(asked)

    def _ask(self, progress: Progress, reached: Mapping[str, int]) -> Asked[Checked]:
        running = tuple(one.step for one in progress.running)
        skills = {step.skill: self._skills[step.skill] for step in (*running, *progress.rest)}
        self._staleness.stale = False
        return self._context.planning.ask(Check(self.goal, running, progress.rest, skills, reached))

    def _flaw(self, asked: Asked[Checked]) -> Flaw | None:
        """Reads an answer; a plan that cannot be checked counts as flawed."""
        try:
            answer = asked.result()
        except SkirosError as error:
            return Flaw(None, Verdict(False, Message("the replay: {error}", error=error)))
        self._staleness.read(answer.value.keys, answer.version)
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
