"""What a task plans with: the world without what failed too often, without what others use, with what runs done."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import closing
from dataclasses import replace

from skiros_py.errors import PlanningError, SkirosError
from skiros_py.execution.contained import words
from skiros_py.interruptions import Interruption
from skiros_py.planning.plan import NoPlan, Plan, Step
from skiros_py.planning.problem.task import Capability
from skiros_py.planning.service import Planned
from skiros_py.skills.conditions import Condition
from skiros_py.skills.primitive import Execution
from skiros_py.skills.skill import SkillDescription
from skiros_py.tasks.context import TaskContext
from skiros_py.tasks.history import History
from skiros_py.tasks.plan_checker import supposing
from skiros_py.tasks.reservations import robot_of
from skiros_py.world.overlay import FilteredView
from skiros_py.world.view import WorldView

__all__ = ["Replanner"]

_PLANNING_LIMIT = 30.0
"""How long what is worked out around the planner may hold the control cycle: a large world takes seconds [s]."""
_AGAIN = 4
"""How often it is looked into again that there is no plan, where others changed the world meanwhile."""


class Replanner:
    """Plans for one task.

    Args:
        context: World, skill managers and planner.
        history: What failed too often.
        who: Name of the task; what other tasks use is only planned with where there is no other way.
    """

    def __init__(self, context: TaskContext, history: History, who: str) -> None:
        self._context = context
        self._history = history
        self._who = who

    def plan(
        self,
        goal: Sequence[Condition],
        running: Sequence[Step] = (),
        skills: Mapping[str, SkillDescription] | None = None,
    ) -> Execution[Planned]:
        """Plans from what is believed now; others may go on changing it, a plan is of one state of the world.

        A plan may so be outdated when it is there: whoever follows it sees that before its first step. That there is no
        plan, or that planners broke, is looked into again where something has changed meanwhile.

        A planner that breaks while a goal is under way is an answer too: what was done so far has to be reported.

        Args:
            goal: What is wanted.
            running: Steps that run on, and will have ended well.
            skills: The skills of these steps, by name.

        Raises:
            PlanningError: The planner broke before anything was done.
        """
        try:
            return (yield from self._up_to_date(goal, running, skills or {}))
        except PlanningError as error:
            if not self._history.steps:
                raise
            return Planned(NoPlan((str(error),)), None, 0.0)

    def _up_to_date(
        self, goal: Sequence[Condition], running: Sequence[Step], skills: Mapping[str, SkillDescription]
    ) -> Execution[Planned]:
        """Plans until there is a plan, or an answer about the world as it is by now; a bounded number of times."""
        world = self._context.world
        for _ in range(_AGAIN):
            before = world.version
            try:
                planned = yield from self._unhurried(self._plan(goal, running, skills))
            except PlanningError:
                if world.version == before:
                    raise
            else:
                if isinstance(planned.outcome, Plan) or world.version == before:
                    return planned
        return (yield from self._unhurried(self._plan(goal, running, skills)))

    def _plan(
        self, goal: Sequence[Condition], running: Sequence[Step], skills: Mapping[str, SkillDescription]
    ) -> Execution[Planned]:
        context = self._context
        left_out, others = self._history.left_out, context.reservations.of_others(self._who)
        if others:
            able = [self._without(capability, others) for capability in context.capabilities]
            view, reached = self._view(left_out | others, running, skills)
            free = [capability for capability in able if capability.agents]
            planned = yield from context.planning.plan(view, free, goal, reached=reached)
            if isinstance(planned.outcome, Plan):
                return planned
        view, reached = self._view(left_out, running, skills)
        return (yield from context.planning.plan(view, context.capabilities, goal, reached=reached))

    def _view(
        self, without: frozenset[str], running: Sequence[Step], skills: Mapping[str, SkillDescription]
    ) -> tuple[WorldView, Mapping[str, int]]:
        """Returns what to plan with, and the sequence numbers that robots have reached there."""
        now = self._context.world.snapshot()
        view: WorldView = FilteredView(now, without) if without else now
        reached = self._history.reached
        return supposing(view, running, skills, reached) if running else (view, reached)

    def _without(self, capability: Capability, others: frozenset[str]) -> Capability:
        """Returns a capability of those subsystems only whose robots nobody else uses."""
        free = (agent for agent in capability.agents if robot_of(self._context.world, agent) not in others)
        return replace(capability, agents=tuple(free))

    def _unhurried(self, planning: Execution[Planned]) -> Execution[Planned]:
        """Passes planning through, whose ticks may take long; what authors' conditions raise in it is a fault of it.

        Raises:
            PlanningError: It broke.
        """
        with closing(planning):
            while True:
                with self._context.cycle.pulse.allowing(_PLANNING_LIMIT):
                    try:
                        next(planning)
                    except StopIteration as end:
                        result: Planned = end.value
                        return result
                    except (SkirosError, KeyboardInterrupt, Interruption):
                        raise
                    except BaseException as error:
                        raise PlanningError(f"planning broke: {words(error)}") from error
                yield
