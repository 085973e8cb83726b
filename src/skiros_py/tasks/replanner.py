"""Plans for a task: excludes failing targets, avoids elements other tasks use, assumes running steps succeed."""

from __future__ import annotations

from collections.abc import Sequence

from skiros_py.errors import PlanningError
from skiros_py.planning.plan import NoPlan, Plan, Step
from skiros_py.planning.requests import PlanRequest
from skiros_py.planning.service import Planned
from skiros_py.skills.conditions import Condition
from skiros_py.skills.primitive import Execution
from skiros_py.tasks.context import TaskContext
from skiros_py.tasks.handle import TaskHandle
from skiros_py.tasks.record import TaskRecord

_TRIES = 5
"""How often planning is tried if there is no plan but the world changed meanwhile."""


class Replanner:
    """Plans for one task.

    Args:
        context: World, skill managers and planning.
        record: Which targets failed too often.
        task: The task; elements that other tasks use are planned with only as a last resort.
    """

    def __init__(self, context: TaskContext, record: TaskRecord, task: TaskHandle) -> None:
        self._context = context
        self._record = record
        self._task = task

    def plan(self, goal: Sequence[Condition], running: Sequence[Step] = ()) -> Execution[Planned]:
        """Plans from the current world model; the plan is for that one state, even if the world changes meanwhile.

        A plan may thus be outdated on arrival, which the plan monitor detects before its first step. If there is no
        plan, or the planners failed, planning is repeated if something has changed meanwhile.

        A planner failure while a goal is being pursued is returned as an answer: the work so far has to be reported.

        Args:
            goal: The conditions to reach.
            running: Running steps, assumed to succeed.

        Raises:
            PlanningError: The planner failed before any step was run.
        """
        world = self._context.world
        for tries_left in reversed(range(_TRIES)):
            before = world.version
            try:
                planned = yield from self._plan(goal, running)
            except PlanningError as error:
                if tries_left and world.version != before:
                    continue
                if not self._record.steps:
                    raise
                return Planned(NoPlan((str(error),)), None, 0.0)
            if isinstance(planned.outcome, Plan) or not tries_left or world.version == before:
                break
        return planned

    def _plan(self, goal: Sequence[Condition], running: Sequence[Step]) -> Execution[Planned]:
        busy = self._context.reservations.of_others(self._task.name)
        request = PlanRequest(
            tuple(goal),
            self._context.capabilities,
            self._record.reached,
            dict(self._record.left_out),
            tuple(self._record.ruled_out.values()),
            busy,
            tuple(running),
            self._context.options,
        )
        answer = yield from self._context.answer(self._context.planning.ask(request), self._task.control)
        return answer.value
