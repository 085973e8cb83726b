"""The task manager: begins tasks and keeps them apart; several may be under way at once (paper §3.4)."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from itertools import count
from typing import Self

from skiros_py.errors import SkirosError, UsageError
from skiros_py.execution.cycle import ControlCycle
from skiros_py.execution.monitor import Monitor
from skiros_py.execution.runtime import Runtime
from skiros_py.execution.skill_manager import Transport
from skiros_py.planning.problem.task import Capability
from skiros_py.planning.requests import PlanningHost, PlanRequest
from skiros_py.planning.service import USUAL, Planned, PlanningOptions
from skiros_py.skills.conditions import Condition
from skiros_py.skills.primitive import Execution
from skiros_py.skills.questions import Questions
from skiros_py.tasks.context import TaskContext
from skiros_py.tasks.control import Control
from skiros_py.tasks.goal_executor import GoalExecutor
from skiros_py.tasks.handle import TaskHandle
from skiros_py.tasks.history import History
from skiros_py.tasks.policy import Policy
from skiros_py.tasks.replanner import Replanner
from skiros_py.tasks.report import GoalReport, StepReport
from skiros_py.tasks.report_builder import end_before_beginning
from skiros_py.tasks.sequence_run import SequenceRun
from skiros_py.tasks.sequences import StepSequence
from skiros_py.world.world import World

_TRIES = {False: (1.0, 4.0), True: (5.0, 10.0)}
"""How long one planner, and all together, may try out repairs, by whether simulated time stands still [s]."""


class TaskManager:
    """Pursues goals with the skill managers that are there.

    Args:
        world: The live world model.
        managers: Skill managers by agent id.
        planning: Where it is planned.
        cycle: Runs everything.
        on_plan: Told of every new plan.
        attempts: How often a skill may fail on one target, where nobody says otherwise.
        monitor: Hears of steps that have to wait; None where nobody listens.
        questions: Where a person is asked; None where nobody is.
        leaving: Tells whether somebody wants everything to stop: then no planner is waited for.
        options: How to plan.
        lockstep: True where simulated time stands still while it is planned.
    """

    def __init__(
        self,
        world: World,
        managers: Mapping[str, Transport],
        planning: PlanningHost,
        cycle: ControlCycle,
        *,
        on_plan: Callable[[Planned], None] = lambda _planned: None,
        attempts: int = 3,
        monitor: Monitor | None = None,
        questions: Questions | None = None,
        leaving: Callable[[], bool] = lambda: False,
        options: PlanningOptions = USUAL,
        lockstep: bool = True,
    ) -> None:
        self._context = TaskContext(
            world,
            managers,
            planning,
            cycle,
            on_plan,
            monitor,
            questions or Questions(),
            leaving=leaving,
            options=options,
            lockstep=lockstep,
        )
        self._policy = Policy(attempts=attempts)
        self._names = count(1)
        self._active: dict[str, TaskHandle] = {}
        self._on_begin: list[Callable[[TaskHandle], None]] = []
        self._last: History = History(world, attempts)

    @classmethod
    def of(
        cls,
        runtime: Runtime,
        planning: PlanningHost,
        name: str,
        *,
        on_plan: Callable[[Planned], None] = lambda _planned: None,
        attempts: int = 3,
        leaving: Callable[[], bool] = lambda: False,
        temporal: bool = False,
    ) -> Self:
        """Makes the task manager of a runtime.

        Args:
            runtime: Runs everything.
            planning: Where it is planned; it is not closed.
            name: Name of what is planned for, for the planner's files.
            on_plan: Told of every new plan.
            attempts: How often a skill may fail on one target before that target is left out of further plans.
            leaving: Tells whether somebody wants everything to stop: then no planner is waited for.
            temporal: True to plan in time, with a planner that takes durative actions.
        """
        cycle = runtime.cycle
        return cls(
            runtime.world,
            runtime.managers,
            planning,
            cycle,
            on_plan=on_plan,
            attempts=attempts,
            monitor=runtime.monitor,
            questions=runtime.questions,
            leaving=leaving,
            options=PlanningOptions(name, temporal, *_TRIES[cycle.pace is None]),
            lockstep=cycle.pace is None,
        )

    @property
    def steps(self) -> tuple[StepReport, ...]:
        """Every skill that was run for the task that was begun last, in the order in which they ended."""
        return tuple(self._last.steps)

    @property
    def capabilities(self) -> tuple[Capability, ...]:
        """The skills that the world model says are there, with who has them."""
        return self._context.capabilities

    @property
    def active(self) -> tuple[TaskHandle, ...]:
        """The tasks that are under way, in the order in which they were begun."""
        return tuple(self._active.values())

    def holds(self, name: str) -> frozenset[str]:
        """Returns the ids of the robots and things that a task has and others may not use; for the control thread."""
        return self._context.reservations.of(name)

    def plan_request(self, goal: Sequence[Condition]) -> PlanRequest:
        """Returns what planning would be asked for a goal now, without doing anything."""
        return Replanner(self._context, History(self._context.world, 1), "", Control()).request(goal)

    # ------------------------------------------------------------------ tasks

    def on_begin(self, listener: Callable[[TaskHandle], None]) -> Callable[[], None]:
        """Calls the listener in the control thread with each task before its first cycle; returns how to end that."""
        self._on_begin.append(listener)
        return lambda: self._on_begin.remove(listener)

    def begin(self, goal: Sequence[Condition], *, name: str = "", policy: Policy | None = None) -> TaskHandle:
        """Begins to pursue a goal, and returns at once; it runs in the control cycle, beside what is under way.

        What fails is tried or planned again a bounded number of times. What can no longer be reached is given up, and
        the rest of the goal is still pursued.

        Args:
            goal: Conditions that shall hold together.
            name: What people call it; "task 1" and so on where left out.
            policy: What to do when something is out of reach.

        Raises:
            UsageError: A task of that name is under way, or everything was halted and not reset.
        """
        task = TaskHandle(self._free(name), goal, policy or self._policy)
        self._start(task, self._pursuing(task))
        return task

    def execute(
        self,
        sequence: StepSequence,
        *,
        iterate: int | None = 1,
        name: str = "",
        policy: Policy | None = None,
        anyway: bool = False,
    ) -> TaskHandle:
        """Begins to run a sequence of steps as it is, and returns at once.

        Args:
            sequence: The steps.
            iterate: How often; None for until it is stopped.
            name: What people call it.
            policy: How often a step is tried.
            anyway: True to run what cannot work as far as anybody knows: somebody has asked for it in so many words.

        Raises:
            UsageError: The sequence is empty or cannot work, or everything was halted and not reset.
        """
        if iterate is not None and (isinstance(iterate, bool) or not isinstance(iterate, int) or iterate < 1):
            raise UsageError(f"iterate: a whole number from 1, or None for until it is stopped, not {iterate!r}")
        sequence.require_steps()  # an empty round takes no time: repeated for ever, it would hold the cycle
        if not anyway:
            sequence.require_works()
        task = TaskHandle(self._free(name), (), policy or self._policy)
        run = SequenceRun(task, self._context, sequence.steps, iterate, anyway=anyway)
        self._last = run.history
        self._start(task, self._listed(task, run.execute()))
        return task

    def sequence(self) -> StepSequence:
        """Returns an empty sequence to be filled with steps: checked against the world as believed now."""
        return StepSequence(self._context.world, {c.skill.name: c.skill for c in self.capabilities})

    def _pursuing(self, task: TaskHandle) -> Execution[GoalReport]:
        run = GoalExecutor(task, self._context)  # begins with a clean slate: what failed before may work now
        self._last = run.history
        return (yield from self._listed(task, run.execute()))

    def _listed(self, task: TaskHandle, run: Execution[GoalReport]) -> Execution[GoalReport]:
        self._active[task.name] = task
        for listener in tuple(self._on_begin):
            listener(task)
        try:
            return (yield from run)
        finally:
            del self._active[task.name]

    def _start(self, task: TaskHandle, run: Execution[GoalReport]) -> None:
        """Gives a task a place in the control cycle."""
        work = self._contained(task, run)
        next(work)  # so far that it hears of its end, even where that comes before its first cycle
        try:
            self._context.cycle.start(work, task.name)
        except UsageError:
            work.close()
            raise
        self._active[task.name] = task

    def _contained(self, task: TaskHandle, run: Execution[GoalReport]) -> Execution[None]:
        """Passes a task through whose faults are in its report; that it has in any case."""
        try:
            yield
            yield from run
        except SkirosError as error:
            task.error = error
        except Exception as error:
            task.error = error
            raise
        finally:
            self._active.pop(task.name, None)
            if task.report is None:
                end_before_beginning(task, self._context)

    def _free(self, name: str) -> str:
        """Returns the name of a new task.

        Raises:
            UsageError: A task of that name is under way.
        """
        if name in self._active:
            raise UsageError(f"a task named '{name}' is under way already")
        taken = self._active
        return name or next(free for n in self._names if (free := f"task {n}") not in taken)
