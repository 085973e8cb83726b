"""The task manager: starts tasks and keeps them from conflicting; several can run concurrently."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import count

from skiros_py.errors import SkirosError, UsageError
from skiros_py.execution.runtime import Runtime
from skiros_py.messages import Message, joined
from skiros_py.planning.experience import Case, observe
from skiros_py.planning.explanation.absent import AbsentSkill
from skiros_py.planning.plan import Step
from skiros_py.planning.problem.task import Capability
from skiros_py.planning.requests import PlanningHost, PlanRequest, RuledOut
from skiros_py.planning.service import Planned, PlanningOptions
from skiros_py.skills.conditions import Condition
from skiros_py.skills.outcome import CANCELLED, Failure, Outcome
from skiros_py.skills.primitive import Execution
from skiros_py.skills.skill import SkillDescription
from skiros_py.tasks.context import TaskContext
from skiros_py.tasks.executor import TaskExecutor
from skiros_py.tasks.goal_executor import GoalExecutor
from skiros_py.tasks.handle import TaskHandle
from skiros_py.tasks.policy import Policy
from skiros_py.tasks.record import TaskRecord
from skiros_py.tasks.rehearsal import Rehearser
from skiros_py.tasks.report import GoalReport, StepReport
from skiros_py.tasks.sequence_executor import SequenceExecutor
from skiros_py.tasks.sequences import StepCheck, check_steps, read_step
from skiros_py.tasks.trace import StepRun, Trace, TraceEventKind

_TRIES = {False: (1.0, 4.0), True: (5.0, 10.0)}
"""Time limits for trying repairs (per planner, in total) [s], by whether simulated time stands still."""


class TaskManager:
    """Pursues goals with the available skill managers.

    Args:
        runtime: Runs the tasks.
        planning: The planning service; it is not closed by the task manager.
        name: Name used for the planner's files.
        on_plan: Called with every new plan.
        policy: How tasks proceed that are given none.
        leaving: Returns True once a shutdown is requested; planners are then no longer waited for.
        temporal: True for temporal planning, with a planner that supports durative actions.
        absent: Skills that are installed but cannot be used.
        rehearser: Starts rehearsals; None where there is no physics for them.
    """

    def __init__(
        self,
        runtime: Runtime,
        planning: PlanningHost,
        name: str,
        *,
        on_plan: Callable[[Planned], None] = lambda _planned: None,
        policy: Policy = Policy(),  # noqa: B008 - immutable
        leaving: Callable[[], bool] = lambda: False,
        temporal: bool = False,
        absent: tuple[AbsentSkill, ...] = (),
        rehearser: Rehearser | None = None,
    ) -> None:
        cycle = runtime.cycle
        lockstep = cycle.pace is None
        self._context = TaskContext(
            runtime.world,
            runtime.managers,
            planning,
            cycle,
            on_plan=on_plan,
            monitor=runtime.monitor,
            questions=runtime.questions,
            leaving=leaving,
            options=PlanningOptions(name, temporal, *_TRIES[lockstep], absent),
            lockstep=lockstep,
            rehearser=rehearser,
        )
        self._policy = policy
        self._names = count(1)
        self._active: dict[str, TaskHandle] = {}
        self._on_begin: list[Callable[[TaskHandle], None]] = []
        self._last: TaskRecord | None = None

    @property
    def steps(self) -> tuple[StepReport, ...]:
        """Every skill execution of the most recently started task, in the order in which they ended."""
        return () if self._last is None else tuple(self._last.steps)

    @property
    def capabilities(self) -> tuple[Capability, ...]:
        """The skills available according to the world model, with the agents that provide them."""
        return self._context.capabilities

    @property
    def skills(self) -> dict[str, SkillDescription]:
        """The descriptions of these skills by name."""
        return {capability.skill.name: capability.skill for capability in self.capabilities}

    @property
    def active(self) -> tuple[TaskHandle, ...]:
        """The running tasks, in the order in which they were started."""
        return tuple(self._active.values())

    def holds(self, name: str) -> frozenset[str]:
        """Returns the ids of the robots and things reserved by a task; call it in the control thread."""
        return self._context.reservations.of(name)

    def plan_request(self, goal: Sequence[Condition]) -> PlanRequest:
        """Returns the request that planning a goal would send now, without sending it."""
        busy, options = self._context.reservations.of_others(""), self._context.options
        return PlanRequest(tuple(goal), self.capabilities, busy=busy, options=options)

    # ------------------------------------------------------------------ tasks

    def on_begin(self, listener: Callable[[TaskHandle], None]) -> Callable[[], None]:
        """Calls the listener in the control thread with each task before its first cycle; returns an unsubscriber."""
        self._on_begin.append(listener)
        return lambda: self._on_begin.remove(listener)

    def begin(
        self,
        goal: Sequence[Condition],
        *,
        name: str = "",
        policy: Policy | None = None,
        ruled_out: Sequence[RuledOut] = (),
    ) -> TaskHandle:
        """Starts pursuing a goal and returns at once; the task runs in the control cycle, concurrently with others.

        Failed steps are retried or replanned a bounded number of times. Conditions that can no longer be reached are
        given up, and the rest of the goal is still pursued.

        Args:
            goal: Conditions that must hold together.
            name: Display name; defaults to "task 1" and so on.
            policy: What to do when part of the goal is unreachable.
            ruled_out: Attempts that are not planned, as a rehearsal has shown.

        Raises:
            UsageError: A task of that name is running, or the system was halted and not reset.
        """
        task = self._task(name, goal, policy, ruled_out)
        self._start(task, lambda: GoalExecutor(task, self._context))
        return task

    def execute(
        self,
        steps: Sequence[Step],
        *,
        iterate: int | None = 1,
        name: str = "",
        policy: Policy | None = None,
        anyway: bool = False,
    ) -> TaskHandle:
        """Starts running steps as given, without planning, and returns at once.

        Each round is checked before its first step; if it cannot work, the task ends with the reason in its report.

        Args:
            steps: The steps, in order; omitted arguments are inferred when a step starts.
            iterate: Number of rounds; None to repeat until stopped.
            name: Display name.
            policy: How often a step is tried.
            anyway: True to run steps that are known not to work, on the user's explicit request.

        Raises:
            UsageError: There are no steps, a step names something that does not exist, or the system was halted and
                not reset.
        """
        if iterate is not None and (isinstance(iterate, bool) or not isinstance(iterate, int) or iterate < 1):
            raise UsageError(f"iterate: a whole number from 1, or None for until it is stopped, not {iterate!r}")
        if not steps:  # an empty round takes no time: repeated forever, it would block the cycle
            raise UsageError(Message("the sequence has no steps: add one"))
        read = tuple(read_step(step, self._context.world, self.skills) for step in steps)
        task = self._task(name, (), policy)
        executor = SequenceExecutor(task, self._context, read, iterate, anyway=anyway)
        self._start(task, lambda: executor)
        return task

    def check(self, steps: Sequence[Step]) -> tuple[StepCheck, ...]:
        """Checks steps in turn from the current world; steps after a failing one are checked as if it had worked."""
        return check_steps(self._context.world, steps, self.skills)

    def _start(self, task: TaskHandle, make: Callable[[], TaskExecutor]) -> None:
        """Adds a task to the control cycle; its executor is made in its first cycle."""
        work = self._contained(task, make)
        next(work)  # run to the first yield, so that it is closed properly even if it ends before its first cycle
        try:
            self._context.cycle.start(work, task.name)
        except UsageError:
            work.close()
            raise
        self._active[task.name] = task

    def _contained(self, task: TaskHandle, make: Callable[[], TaskExecutor]) -> Execution[None]:
        """Runs a task and contains its exceptions: they are in its report, which it always has."""
        try:
            yield
            yield from self._execution(task, make())
        except SkirosError as error:
            task.error = error
        except Exception as error:
            task.error = error
            raise
        finally:
            self._active.pop(task.name, None)
            if task.report is None:  # the system was halted before its first cycle
                task.report = TaskRecord(self._context, task.goal, task.policy.attempts).report_cut_off()
                task.trace.write(TraceEventKind.BEGUN, task.name)
                task.trace.write(TraceEventKind.FINISHED, joined(": ", (task.name, task.report.outcome.value)))

    def _execution(self, task: TaskHandle, executor: TaskExecutor) -> Execution[GoalReport]:
        self._last = executor.record
        for listener in tuple(self._on_begin):
            listener(task)
        return (yield from executor.execute())

    def _task(
        self, name: str, goal: Sequence[Condition], policy: Policy | None, ruled_out: Sequence[RuledOut] = ()
    ) -> TaskHandle:
        """Returns a new task; without a name, it gets a free one.

        Raises:
            UsageError: A task of that name is running.
        """
        if name in self._active:
            raise UsageError("a task named '{name}' is under way already", name=name)
        taken = self._active
        name = name or next(free for n in self._names if (free := f"task {n}") not in taken)
        trace = Trace(name, lambda: self._context.now, self._context.monitor)
        return TaskHandle(name, goal, policy or self._policy, trace, ruled_out)


def learn_costs(tasks: TaskManager, runtime: Runtime) -> None:
    """Learns from how steps end; for real and simulated cells, not for fake devices."""
    known: dict[Case, str] = {}

    def learn(run: StepRun, outcome: Outcome) -> None:
        skill = tasks.skills.get(run.step.skill)
        is_cancelled = isinstance(outcome, Failure) and outcome.code == CANCELLED
        if skill is not None and not is_cancelled:
            seconds, is_success = runtime.context.board.now - run.start, not isinstance(outcome, Failure)
            observe(runtime.world, skill, run.agent, run.step.arguments, seconds, is_success=is_success, known=known)

    def follow(task: TaskHandle) -> None:
        task.after_step(learn)

    tasks.on_begin(follow)
