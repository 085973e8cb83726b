"""Runs a sequence of steps as given, for a number of rounds, without planning."""

from __future__ import annotations

from contextlib import suppress
from itertools import count, islice
from typing import TypeVar

from skiros_py.errors import SkirosError
from skiros_py.execution.pulse import words
from skiros_py.planning.plan import Plan, Step
from skiros_py.skills.outcome import Failure
from skiros_py.skills.primitive import Execution
from skiros_py.skills.skill import SkillDescription
from skiros_py.tasks.context import StopWanted, TaskContext
from skiros_py.tasks.dispatcher import Agenda, Dispatcher
from skiros_py.tasks.handle import TaskHandle
from skiros_py.tasks.history import History
from skiros_py.tasks.report import GoalReport
from skiros_py.tasks.report_builder import Moments
from skiros_py.tasks.sequences import StepCheck, StepsCheck
from skiros_py.tasks.trace import TraceEventKind
from skiros_py.tasks.trace_writer import short_step

T = TypeVar("T")


class SequenceRun:
    """Runs the steps of one sequence.

    Args:
        task: The task.
        context: The task's environment: world, managers, planning.
        steps: The steps, in order.
        iterate: Number of rounds; None to repeat until stopped.
        anyway: True to try steps that are known not to work.
    """

    def __init__(
        self,
        task: TaskHandle,
        context: TaskContext,
        steps: tuple[Step, ...],
        iterate: int | None,
        *,
        anyway: bool = False,
    ) -> None:
        self.history = History(context.world, task.policy.attempts)
        self._task = task
        self._context = context
        self._steps = steps
        self._iterate = iterate
        self._anyway = anyway
        self._skills: dict[str, SkillDescription] = {c.skill.name: c.skill for c in context.capabilities}
        self._dispatcher = Dispatcher(task, context, self.history, self._skills)
        self._moments = Moments(context.world, (), context.cycle)
        self._stopped = False
        self._fault = ""

    def execute(self) -> Execution[GoalReport]:
        """Runs the sequence to its end; the task always gets a report."""
        task = self._task
        task.plan, task.phase = Plan(self._steps), "running"
        self._dispatcher.trace.write(TraceEventKind.BEGUN, f"{task.name}: {len(self._steps)} steps")
        try:
            yield from self._until_it_ends()
            task.report = self._report()
        except Exception as error:
            self._fault = str(error) if isinstance(error, SkirosError) else f"it broke: {words(error)}"
            with suppress(Exception):  # ignore further errors: the first one counts
                yield from self._dispatcher.halt(self._fault)
            raise
        finally:
            self._dispatcher.leave()
            if task.report is None:
                self._fault = self._fault or self._context.cycle.halted or "stopped"
                task.report = self._report()
            self._dispatcher.trace.write(TraceEventKind.FINISHED, f"{task.name}: {task.report.outcome}")
        return task.report

    def _until_it_ends(self) -> Execution[None]:
        try:
            for number in islice(count(1), self._iterate):
                if not (yield from self._once(number)):
                    return
        except StopWanted as wish:
            self._stopped = True
            self._dispatcher.trace.write(TraceEventKind.STOPPED, f"is stopped{f': {wish}' if str(wish) else ''}")
            yield from self._dispatcher.halt(str(wish) or "stopped")

    def _once(self, number: int) -> Execution[bool]:
        """Runs all steps once; returns whether that worked."""
        checks = yield from self._checks()
        broken = [c for c in checks if not c.agent or (c.problems and not self._anyway)]
        if broken:
            self._fault = f"round {number} cannot work: {self._said(broken[0])}"
            return False
        plan = Plan(tuple(self._with_agent(check) for check in checks))
        self._task.plan = plan
        self._dispatcher.adopt(Agenda(plan.steps, plan.order), {})
        return (yield from self._carry_out())

    def _checks(self) -> Execution[tuple[StepCheck, ...]]:
        """Has the planning service check all steps against the current world."""
        able = {c.skill.name: c.agents for c in self._context.capabilities}
        asked = self._context.planning.ask(StepsCheck(self._steps, dict(self._skills), able))
        answer = yield from self._until_stopped(self._context.answer(asked, self._task.control))
        return answer.value

    def _until_stopped(self, work: Execution[T]) -> Execution[T]:
        while True:
            try:
                next(work)
            except StopIteration as end:
                result: T = end.value
                return result
            if (wish := self._task.control.stop) is not None:
                raise StopWanted(wish)
            yield

    def _with_agent(self, check: StepCheck) -> Step:
        """Returns a step with its agent filled in, so that its robot is known; the rest is inferred at its start."""
        agent = {self._skills[check.step.skill].agent: check.agent}
        return Step(check.step.skill, {**check.step.arguments, **agent})

    def _said(self, check: StepCheck) -> str:
        skill = self._skills.get(check.step.skill)  # gone with its manager before the first cycle
        step = check.step.skill if skill is None else short_step(check.step, skill)
        return f"{step}: {'; '.join(check.problems)}"

    def _carry_out(self) -> Execution[bool]:
        failures = 0
        while True:
            wish = self._task.control.stop
            failed = self._dispatcher.attend()
            if self._dispatcher.agenda.done:
                return True
            if wish is not None:
                raise StopWanted(wish)
            failed = failed or self._dispatcher.start_ready()
            failures += len(failed)
            if failed and self._is_too_much(failures, *failed[-1]):
                return False
            yield

    def _is_too_much(self, failures: int, step: Step, failure: Failure) -> bool:
        if failures < self._task.policy.attempts:
            self._dispatcher.trace.write(
                TraceEventKind.RETRIED, f"{step.skill} failed: {failure.reason}: it is tried again"
            )
            return False
        self._fault = f"{self._dispatcher.trace.describe(step)} failed {failures} times: {failure.reason}"
        return True

    def _report(self) -> GoalReport:
        steps, forgotten = tuple(self.history.steps), self.history.forgotten
        return GoalReport((), steps, *self._moments.used, stopped=self._stopped, fault=self._fault, forgotten=forgotten)
