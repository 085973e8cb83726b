"""Plans for a task: without what failed too often, if possible without what other tasks use, with what runs done."""

from __future__ import annotations

from collections.abc import Sequence

from skiros_py.errors import PlanningError
from skiros_py.planning.plan import NoPlan, Plan, Step
from skiros_py.planning.requests import PlanRequest
from skiros_py.planning.service import Planned
from skiros_py.skills.conditions import Condition
from skiros_py.skills.primitive import Execution
from skiros_py.tasks.context import TaskContext
from skiros_py.tasks.control import Control
from skiros_py.tasks.history import History

_AGAIN = 4
"""How often it is planned again where there is no plan but others changed the world meanwhile."""


class Replanner:
    """Plans for one task.

    Args:
        context: World, skill managers and planning.
        history: What failed too often.
        task: Name of the task; what other tasks use is only planned with where there is no other way.
        control: What people want of the task.
    """

    def __init__(self, context: TaskContext, history: History, task: str, control: Control) -> None:
        self._context = context
        self._history = history
        self._task = task
        self._control = control

    def plan(self, goal: Sequence[Condition], running: Sequence[Step] = ()) -> Execution[Planned]:
        """Plans from what is believed now; others may go on changing it, a plan is of one state of the world.

        A plan may so be outdated when it is there, which the plan monitor sees before its first step. That there is no
        plan, or that planners broke, is looked into again where something has changed meanwhile.

        A planner that breaks while a goal is under way is an answer too: what was done so far has to be reported.

        Args:
            goal: What is wanted.
            running: Steps that run on, and will have ended well.

        Raises:
            PlanningError: The planner broke before anything was done.
        """
        try:
            return (yield from self._up_to_date(goal, running))
        except PlanningError as error:
            if not self._history.steps:
                raise
            return Planned(NoPlan((str(error),)), None, 0.0)

    def _up_to_date(self, goal: Sequence[Condition], running: Sequence[Step]) -> Execution[Planned]:
        """Plans until there is a plan, or an answer about the world as it is by now; a bounded number of times."""
        world = self._context.world
        for _ in range(_AGAIN):
            before = world.version
            try:
                planned = yield from self._plan(goal, running)
            except PlanningError:
                if world.version == before:
                    raise
            else:
                if isinstance(planned.outcome, Plan) or world.version == before:
                    return planned
        return (yield from self._plan(goal, running))

    def _plan(self, goal: Sequence[Condition], running: Sequence[Step]) -> Execution[Planned]:
        asked = self._context.planning.ask(self.request(goal, running))
        answer = yield from self._context.answer(asked, self._control)
        return answer.value

    def request(self, goal: Sequence[Condition], running: Sequence[Step] = ()) -> PlanRequest:
        """Returns what planning is asked.

        Args:
            goal: What is wanted.
            running: Steps that run on, and will have ended well.
        """
        return PlanRequest(
            tuple(goal),
            self._context.capabilities,
            self._history.reached,
            self._history.left_out,
            self._context.reservations.of_others(self._task),
            tuple(running),
            self._context.options,
        )
