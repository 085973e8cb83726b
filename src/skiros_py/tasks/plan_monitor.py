"""PlanMonitor one plan: whether it still leads to the goal, what of it is in question, and going over to another."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from skiros_py.planning.plan import Plan, Step
from skiros_py.planning.validation import Flaw
from skiros_py.skills.conditions import Condition, Verdict
from skiros_py.skills.skill import SkillDescription
from skiros_py.tasks.active import Active
from skiros_py.tasks.agenda import Agenda
from skiros_py.tasks.context import TaskContext
from skiros_py.tasks.dispatcher import Dispatcher
from skiros_py.tasks.history import History
from skiros_py.tasks.plan_checker import PlanChecker

__all__ = ["PlanMonitor"]


class PlanMonitor:
    """The present plan of one task, and how right it still is.

    Args:
        context: World and skill managers.
        dispatcher: Runs the plan.
        history: Who failed too often, and how far robots have come.
        skills: The skills there are, by name; filled in as managers come.

    Attributes:
        trouble: What is not as planned, in words; empty before anything is.
    """

    def __init__(
        self, context: TaskContext, dispatcher: Dispatcher, history: History, skills: Mapping[str, SkillDescription]
    ) -> None:
        self.trouble = ""
        self._context = context
        self._dispatcher = dispatcher
        self._history = history
        self._skills = skills
        self._checker: PlanChecker | None = None
        self._goal: tuple[Condition, ...] = ()
        self._misled: tuple[Active, ...] = ()

    @property
    def began(self) -> bool:
        """True when there was a plan before."""
        return self._checker is not None

    @property
    def undoubted(self) -> tuple[Step, ...]:
        """The steps that run and are not in question, whatever is planned."""
        active = self._dispatcher.active
        return tuple(one.step for one in active if one not in self._misled and not one.leaving)

    def is_misled(self) -> bool:
        """Tells whether the rest of the plan leads to the goal no longer; looks only where something changed."""
        if self._checker is None or self._dispatcher.idle:
            return False
        flaw = self._lost() or (self._look(self._checker) if self._checker.stale else None)
        if flaw is None:
            return False
        self.trouble, self._misled = flaw.verdict.why, self._leading_to(flaw.step)
        return True

    def is_right_for(self, goal: tuple[Condition, ...]) -> bool:
        """Tells whether the plan, with what failed done once more, still leads to a goal."""
        agenda = self._dispatcher.agenda
        if self._checker is None or goal != self._goal or agenda.done or self._misled:
            return False
        targets = {step.arguments[self._skills[step.skill].target] for step in self._dispatcher.rest}
        if self._lost() is not None or targets & self._history.left_out:
            return False
        return self._look(self._checker) is None

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
        self._checker = PlanChecker(self._context.world, goal, self._skills)
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
        if self._checker is not None:
            self._checker.close()

    def _look(self, checker: PlanChecker) -> Flaw | None:
        running = [one.step for one in self._dispatcher.active]
        return checker.look(running, self._dispatcher.rest, self._history.reached)

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
