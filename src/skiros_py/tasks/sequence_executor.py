"""Executes a sequence of steps as given, for a number of rounds, without planning."""

from __future__ import annotations

from itertools import count, islice

from skiros_py.messages import Message, joined
from skiros_py.planning.plan import Plan, Step
from skiros_py.skills.outcome import Failure
from skiros_py.skills.primitive import Execution
from skiros_py.tasks.context import TaskContext
from skiros_py.tasks.executor import TaskExecutor
from skiros_py.tasks.handle import TaskHandle
from skiros_py.tasks.sequences import StepCheck, StepsCheck
from skiros_py.tasks.trace import TraceEventKind, describe_step, short_step


class SequenceExecutor(TaskExecutor):
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
        super().__init__(task, context)
        self._steps = steps
        self._iterate = iterate
        self._anyway = anyway
        self._skills = {c.skill.name: c.skill for c in context.capabilities}

    def _title(self) -> str:
        return Message("{count} steps", count=len(self._steps))

    def _work(self) -> Execution[None]:
        self._task.plan, self._task.phase = Plan(self._steps), "running"
        for number in islice(count(1), self._iterate):
            if not (yield from self._once(number)):
                return

    def _once(self, number: int) -> Execution[bool]:
        """Runs all steps once; returns whether that worked."""
        checks = yield from self._checks()
        broken = [c for c in checks if not c.agent or (c.problems and not self._anyway)]
        if broken:
            self.record.fault = Message("round {number} cannot work: {why}", number=number, why=self._said(broken[0]))
            return False
        plan = Plan(tuple(self._with_agent(check) for check in checks))
        self._task.plan = plan
        self._noted(self._dispatcher.adopt(plan, self._skills))
        return (yield from self._carry_out())

    def _checks(self) -> Execution[tuple[StepCheck, ...]]:
        """Has the planning service check all steps against the current world."""
        able = {c.skill.name: c.agents for c in self._context.capabilities}
        asked = self._context.planning.ask(StepsCheck(self._steps, dict(self._skills), able))
        answer = yield from self._meanwhile(self._context.answer(asked, self._task.control))
        return answer.value

    def _with_agent(self, check: StepCheck) -> Step:
        """Returns a step with its agent filled in, so that its robot is known; the rest is inferred at its start."""
        agent = {self._skills[check.step.skill].agent: check.agent}
        return Step(check.step.skill, {**check.step.arguments, **agent})

    def _said(self, check: StepCheck) -> str:
        skill = self._skills.get(check.step.skill)  # gone with its manager before the first cycle
        step = check.step.skill if skill is None else short_step(check.step, skill)
        return joined(": ", (step, joined("; ", check.problems)))

    def _carry_out(self) -> Execution[bool]:
        failures = 0
        while True:
            progress = self._attend()
            if progress.done:
                return True
            self._look_after()
            failed = progress.failed or self._noted(self._dispatcher.start_ready()).failed
            failures += len(failed)
            if failed and self._is_too_much(failures, *failed[-1]):
                return False
            yield

    def _is_too_much(self, failures: int, step: Step, failure: Failure) -> bool:
        if failures < self._task.policy.attempts and not failure.is_final:
            trouble = Message("{step} failed: {reason}", step=step.skill, reason=failure.reason)
            self._trace.write(TraceEventKind.RETRIED, Message("{trouble}: it is tried again", trouble=trouble))
            return False
        said = describe_step(step, self._skills[step.skill])
        failed = {"step": said, "count": failures, "reason": failure.reason}
        times = Message("{step} failed {count} times: {reason}", **failed)
        self.record.fault = times if failures > 1 else Message("{step} failed: {reason}", **failed)
        return True
