"""Writes the trace of a task, in sentences and as data."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from skiros_py.execution.monitor import ModuleEvent, Status
from skiros_py.planning.plan import Step
from skiros_py.skills.parameters import Kind
from skiros_py.skills.skill import SkillDescription
from skiros_py.tasks.context import TaskContext
from skiros_py.tasks.handle import StepRun
from skiros_py.tasks.trace import Trace, TraceEntry, TraceEventKind, step_id


class TraceWriter:
    """Writes the trace of one task; steps that wait are published to the monitor as well.

    Args:
        task: Its name.
        trace: Receives the entries.
        context: Provides the time and the monitor.
        skills: The available skills by name.
    """

    def __init__(self, task: str, trace: Trace, context: TaskContext, skills: Mapping[str, SkillDescription]) -> None:
        self._task = task
        self._trace = trace
        self._context = context
        self._skills = skills
        self._waits: set[str] = set()

    def write(self, what: TraceEventKind, text: str, data: Mapping[str, Any] | None = None) -> None:
        """Adds an entry that concerns no single step."""
        self._trace.add(TraceEntry(self._context.now, what, text, data=data or {}, id=self._task))

    def write_step(self, what: TraceEventKind, text: str, run: StepRun, data: Mapping[str, Any] | None = None) -> None:
        """Adds an entry about one step."""
        step, arguments = run.step, dict(run.step.arguments)
        now, number = self._context.now, run.number or None
        own, parent = (step_id(self._task, run.number), self._task) if run.number else (self._task, "")
        entry = TraceEntry(now, what, text, number, step.skill, arguments, run.agent, data or {}, own, parent)
        self._trace.add(entry)

    def write_wait(self, step: Step, why: str) -> None:
        """Adds an entry that a step has to wait; once per reason."""
        text = f"{self.describe(step)} waits: {why}"
        if text in self._waits:
            return
        self._waits.add(text)
        run = StepRun(0, step, self.agent(step), self._context.now)
        self.write_step(TraceEventKind.WAITS, text, run)
        if self._context.monitor is not None:
            waits = f"waits: {why}"
            status, agent = Status.RUNNING, run.agent
            event = ModuleEvent(
                run.start, "skill", step.skill, status, 0, waits, agent=agent, task=self._task, id=self._task
            )
            self._context.monitor.publish(event)

    def forget_waits(self) -> None:
        """Allows waits to be reported again, for a new plan."""
        self._waits.clear()

    def agent(self, step: Step) -> str:
        """Returns the name of the agent that runs a step."""
        return step.arguments[self._skills[step.skill].agent]

    def describe(self, step: Step) -> str:
        """Returns a step as text: agent, skill and arguments."""
        return f"{self.agent(step)}: {short_step(step, self._skills[step.skill])}"


def short_step(step: Step, skill: SkillDescription) -> str:
    """Returns a step in short: the skill and its user-specified arguments, without devices and derived ones."""
    said = [
        str(step.arguments[p.key])
        for p in skill.params
        if p.key in step.arguments and p.kind not in (Kind.HARDWARE, Kind.PLANNING)
    ]
    return " ".join((step.skill, *said))
