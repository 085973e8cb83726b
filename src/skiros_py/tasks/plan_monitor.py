"""Monitors one plan: whether it still leads to the goal, which steps are affected, and switching to another plan."""

from __future__ import annotations

import threading
from collections.abc import Mapping, Sequence

from skiros_py.errors import SkirosError
from skiros_py.planning.plan import Plan, Step
from skiros_py.planning.plan_validation import Flaw
from skiros_py.planning.requests import Asked, Check, Checked
from skiros_py.skills.conditions import Condition, Verdict
from skiros_py.skills.conditions.watch import Key, touched_by
from skiros_py.skills.primitive import Execution
from skiros_py.skills.skill import SkillDescription
from skiros_py.tasks.context import Control, TaskContext
from skiros_py.tasks.dispatcher import Active, Agenda, Dispatcher
from skiros_py.tasks.history import History
from skiros_py.world.change import Change
from skiros_py.world.world import World


class Staleness:
    """Detects changes that invalidate an answer. Used by one thread; any thread may write the world.

    Args:
        world: The live world model.
    """

    def __init__(self, world: World) -> None:
        self._world = world
        self._keys: frozenset[Key] = frozenset()
        self._stale = True
        self._heard = world.version
        self._guard = threading.Lock()
        self._unsubscribe = world.subscribe(self._hear)

    def __bool__(self) -> bool:
        return self._stale

    def again(self) -> None:
        """Discards the pending request: no answer to it will come."""
        self._stale = True

    def asked(self) -> None:
        """Records that a check was requested: only later changes count."""
        self._stale = False

    def read(self, keys: frozenset[Key], version: int) -> None:
        """Records what the answer depends on.

        Args:
            keys: What was read.
            version: The world version that was read.
        """
        with self._guard:
            self._keys = keys
            self._stale = self._stale or self._heard > version

    def close(self) -> None:
        """Unsubscribes from world changes."""
        self._unsubscribe()

    def _hear(self, change: Change) -> None:
        """Called in the writing thread, so it only compares keys."""
        with self._guard:
            self._heard = change.number
            touched = (key for edit in change.edits for key in touched_by(edit, self._world.ontology))
            self._stale = self._stale or any(key in self._keys for key in touched)


class PlanMonitor:
    """The current plan of one task, and whether it still leads to the goal.

    The rest of the plan is replayed by the planning service whenever something changed that the last replay read. No
    step starts before the answer has arrived.

    Args:
        context: World, skill managers and planning.
        dispatcher: Runs the plan.
        history: Which targets failed too often, and the sequence numbers reached by the robots.
        skills: The available skills by name; extended as managers appear.
        control: Control requests of the task.

    Attributes:
        trouble: Description of the deviation from the plan; empty if there is none.
    """

    def __init__(
        self,
        context: TaskContext,
        dispatcher: Dispatcher,
        history: History,
        skills: Mapping[str, SkillDescription],
        control: Control,
    ) -> None:
        self.trouble = ""
        self._control = control
        self._context = context
        self._dispatcher = dispatcher
        self._history = history
        self._skills = skills
        self._stale: Staleness | None = None
        self._asked: tuple[Asked[Checked], tuple[Step, ...]] | None = None
        self._goal: tuple[Condition, ...] = ()
        self._misled: tuple[Active, ...] = ()

    @property
    def began(self) -> bool:
        """True if there has been a plan."""
        return self._stale is not None

    @property
    def undoubted(self) -> tuple[Step, ...]:
        """The running steps that stay valid regardless of replanning."""
        active = self._dispatcher.active
        return tuple(one.step for one in active if one not in self._misled and not one.leaving)

    @property
    def is_sure(self) -> bool:
        """True if nothing the plan depends on has changed since it was last validated."""
        return self._asked is None and not self._stale

    def is_misled(self) -> bool:
        """Returns True if the rest of the plan is known to no longer lead to the goal; requests a check after changes.

        In lockstep the answer is waited for; otherwise it arrives in a later cycle, see :attr:`is_sure`.
        """
        if self._stale is None or self._dispatcher.idle:
            return False
        flaw = self._lost() or self._look(self._stale)
        if flaw is None:
            return False
        self.trouble, self._misled = flaw.verdict.why, self._leading_to(flaw.step)
        return True

    def is_right_for(self, goal: tuple[Condition, ...]) -> Execution[bool]:
        """Returns True if the plan, with failed steps repeated, still leads to a goal."""
        agenda = self._dispatcher.agenda
        if self._stale is None or goal != self._goal or agenda.done or self._misled:
            return False
        targets = {step.arguments[self._skills[step.skill].target] for step in self._dispatcher.rest}
        if self._lost() is not None or targets & self._history.left_out:
            return False
        self._drop()
        asked = self._ask(self._stale)
        yield from self._context.answer(asked, self._control)
        return self._flaw(asked, self._stale) is None

    def adopt(self, plan: Plan, goal: tuple[Condition, ...]) -> None:
        """Switches to another plan; running steps continue if they are part of the new plan, too."""
        agenda = Agenda(plan.steps, plan.order)
        going_on: dict[int, Active] = {}
        for one in self._misled:
            same = [i for i in agenda.ready if i not in going_on and agenda.steps[i] == one.step]
            if same and one in self._dispatcher.active:
                going_on[same[0]] = one
        self.break_off(list(going_on.values()))
        self._dispatcher.adopt(agenda, going_on)
        self.close()
        self._stale = Staleness(self._context.world)
        self._goal = goal

    def break_off(self, going_on: Sequence[Active] = ()) -> None:
        """Cancels the affected steps.

        Args:
            going_on: Those that continue.
        """
        for one in self._misled:
            if one not in going_on:
                self._dispatcher.break_off(one, f"the plan no longer leads to the goal: {self.trouble}")
        self._misled = ()

    def close(self) -> None:
        """Stops monitoring the world."""
        self._drop()
        if self._stale is not None:
            self._stale.close()

    # ------------------------------------------------------------------ checking

    def _look(self, stale: Staleness) -> Flaw | None:
        """Returns the flaw known so far; requests a new check if something changed."""
        if self._asked is not None and self._asked[1] != self._dispatcher.rest:
            self._drop()
            stale.again()
        if self._asked is None and stale:
            self._asked = self._ask(stale), self._dispatcher.rest
            self._context.wait_in_lockstep(self._asked[0], self._control)
        if self._asked is None or not self._asked[0].done():
            return None
        asked, self._asked = self._asked[0], None
        return self._flaw(asked, stale)

    def _ask(self, stale: Staleness) -> Asked[Checked]:
        running = tuple(one.step for one in self._dispatcher.active)
        rest = self._dispatcher.rest
        skills = {step.skill: self._skills[step.skill] for step in (*running, *rest)}
        stale.asked()
        return self._context.planning.ask(Check(self._goal, running, rest, skills, self._history.reached))

    def _flaw(self, asked: Asked[Checked], stale: Staleness) -> Flaw | None:
        """Reads an answer; a plan that cannot be checked counts as flawed."""
        try:
            answer = asked.result()
        except SkirosError as error:
            return Flaw(None, Verdict(False, f"the replay: {error}"))
        stale.read(answer.value.keys, answer.version)
        return answer.value.flaw

    def _drop(self) -> None:
        if self._asked is not None:
            self._asked[0].cancel()
            self._asked = None

    def _lost(self) -> Flaw | None:
        """Returns a flaw for the first remaining step whose skill is no longer available."""
        for index, step in enumerate(self._dispatcher.rest):
            agent = step.arguments[self._skills[step.skill].agent]
            if not self._context.offers(agent, step.skill):
                return Flaw(index, Verdict(False, f"{agent} has no skill {step.skill} any more"))
        return None

    def _leading_to(self, at: int | None) -> tuple[Active, ...]:
        """Returns the running steps that a remaining step depends on: only those are affected."""
        if at is None:
            return ()
        agenda = self._dispatcher.agenda
        later = agenda.waiting[at]
        return tuple(one for one in self._dispatcher.active if agenda.leads_to(one.index, later))
