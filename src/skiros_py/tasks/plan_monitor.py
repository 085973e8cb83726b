"""Watches one plan: whether it still leads to the goal, what of it is in question, and going over to another."""

from __future__ import annotations

import threading
from collections.abc import Mapping, Sequence

from skiros_py.errors import SkirosError
from skiros_py.planning.plan import Plan, Step
from skiros_py.planning.plan_validation import Flaw
from skiros_py.planning.requests import Asked, Check, Checked
from skiros_py.skills.conditions import Condition, Verdict
from skiros_py.skills.conditions.reads import Key, touched_by
from skiros_py.skills.primitive import Execution
from skiros_py.skills.skill import SkillDescription
from skiros_py.tasks.agenda import Agenda
from skiros_py.tasks.context import TaskContext
from skiros_py.tasks.control import Control
from skiros_py.tasks.dispatcher import Active, Dispatcher
from skiros_py.tasks.history import History
from skiros_py.world.change import Change
from skiros_py.world.world import World


class Staleness:
    """Tells whether anything changed that an answer depends on. One thread uses it; any may write the world.

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
        """Forgets what was asked: no answer to that will come."""
        self._stale = True

    def asked(self) -> None:
        """Notes that it is being looked into: only later changes count."""
        self._stale = False

    def read(self, keys: frozenset[Key], version: int) -> None:
        """Notes what the answer depends on.

        Args:
            keys: What was read.
            version: Of which state of the world.
        """
        with self._guard:
            self._keys = keys
            self._stale = self._stale or self._heard > version

    def close(self) -> None:
        """Hears of no more changes."""
        self._unsubscribe()

    def _hear(self, change: Change) -> None:
        """Called in the thread that wrote, so it does no more than to compare."""
        with self._guard:
            self._heard = change.number
            touched = (key for edit in change.edits for key in touched_by(edit, self._world.ontology))
            self._stale = self._stale or any(key in self._keys for key in touched)


class PlanMonitor:
    """The present plan of one task, and whether it still leads to the goal.

    The rest of the plan is replayed where planning is done, again only when something changed that the last replay
    read. No step starts before the answer is there.

    Args:
        context: World, skill managers and planning.
        dispatcher: Runs the plan.
        history: Which targets failed too often, and how far robots have come.
        skills: The skills there are, by name; filled in as managers come.
        control: What people want of the task.

    Attributes:
        trouble: What is not as planned, in words; empty before anything is.
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
        """True when there was a plan before."""
        return self._stale is not None

    @property
    def undoubted(self) -> tuple[Step, ...]:
        """The steps that run and are not in question, whatever is planned."""
        active = self._dispatcher.active
        return tuple(one.step for one in active if one not in self._misled and not one.leaving)

    @property
    def is_sure(self) -> bool:
        """True when nothing that the plan depends on has changed since it was found right."""
        return self._asked is None and not self._stale

    def is_misled(self) -> bool:
        """Tells whether the rest of the plan is known not to lead to the goal any more; asks where something changed.

        In lockstep the answer is waited for; else it is there in a later cycle, see :attr:`is_sure`.
        """
        if self._stale is None or self._dispatcher.idle:
            return False
        flaw = self._lost() or self._look(self._stale)
        if flaw is None:
            return False
        self.trouble, self._misled = flaw.verdict.why, self._leading_to(flaw.step)
        return True

    def is_right_for(self, goal: tuple[Condition, ...]) -> Execution[bool]:
        """Tells whether the plan, with what failed done once more, still leads to a goal."""
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
        """Goes over to another plan; what runs for the old one runs on where it is right for the new one, too."""
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
        """Ends what is in question.

        Args:
            going_on: What of it runs on.
        """
        for one in self._misled:
            if one not in going_on:
                self._dispatcher.break_off(one, f"the plan no longer leads to the goal: {self.trouble}")
        self._misled = ()

    def close(self) -> None:
        """Looks at the world no more."""
        self._drop()
        if self._stale is not None:
            self._stale.close()

    # ------------------------------------------------------------------ checking

    def _look(self, stale: Staleness) -> Flaw | None:
        """Returns the flaw that is known by now; asks again where something changed."""
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
        """Reads an answer; a plan that cannot be checked does not lead to the goal."""
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
        """Returns the first step of the rest whose skill is gone."""
        for index, step in enumerate(self._dispatcher.rest):
            agent = step.arguments[self._skills[step.skill].agent]
            if not self._context.offers(agent, step.skill):
                return Flaw(index, Verdict(False, f"{agent} has no skill {step.skill} any more"))
        return None

    def _leading_to(self, at: int | None) -> tuple[Active, ...]:
        """Returns what runs for the sake of a step of the rest: that is what is in question, nothing else."""
        if at is None:
            return ()
        agenda = self._dispatcher.agenda
        later = agenda.waiting[at]
        return tuple(one for one in self._dispatcher.active if agenda.leads_to(one.index, later))
