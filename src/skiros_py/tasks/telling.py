"""Tells what happens in a task: to its trace in sentences and as data, and what waits to the monitor as well."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from skiros_py.execution.monitor import ModuleEvent, Status
from skiros_py.planning.plan import Step
from skiros_py.skills.parameters import Kind
from skiros_py.skills.skill import SkillDescription
from skiros_py.tasks.context import TaskContext
from skiros_py.tasks.handle import StepRun
from skiros_py.tasks.trace import Happening, Trace, TraceEntry, step_id


class Telling:
    """The voice of one task.

    Args:
        task: Its name.
        trace: Takes everything.
        context: Its time, and who else listens.
        skills: The skills there are, by name.
    """

    def __init__(self, task: str, trace: Trace, context: TaskContext, skills: Mapping[str, SkillDescription]) -> None:
        self._task = task
        self._trace = trace
        self._context = context
        self._skills = skills
        self._waits: set[str] = set()

    def tell(self, what: Happening, text: str, data: Mapping[str, Any] | None = None) -> None:
        """Tells what is about no single step."""
        self._trace.add(TraceEntry(self._context.now, what, text, data=data or {}, id=self._task))

    def tell_of(self, what: Happening, text: str, run: StepRun, data: Mapping[str, Any] | None = None) -> None:
        """Tells what is about one step."""
        step, arguments = run.step, dict(run.step.arguments)
        now, number = self._context.now, run.number or None
        own, parent = (step_id(self._task, run.number), self._task) if run.number else (self._task, "")
        entry = TraceEntry(now, what, text, number, step.skill, arguments, run.agent, data or {}, own, parent)
        self._trace.add(entry)

    def waits(self, step: Step, why: str) -> None:
        """Tells that a step has to wait; once for each reason."""
        said = f"{self.said(step)} waits: {why}"
        if said in self._waits:
            return
        self._waits.add(said)
        run = StepRun(0, step, self.agent(step), self._context.now)
        self.tell_of(Happening.WAITS, said, run)
        if self._context.monitor is not None:
            text = f"waits: {why}"
            status, agent = Status.RUNNING, run.agent
            event = ModuleEvent(
                run.start, "skill", step.skill, status, 0, text, agent=agent, task=self._task, id=self._task
            )
            self._context.monitor.publish(event)

    def forget_waits(self) -> None:
        """Tells of waits again: there is another plan."""
        self._waits.clear()

    def agent(self, step: Step) -> str:
        """Returns who does a step."""
        return step.arguments[self._skills[step.skill].agent]

    def said(self, step: Step) -> str:
        """Returns a step as people say it: who does what to what."""
        return f"{self.agent(step)}: {short_step(step, self._skills[step.skill])}"


def short_step(step: Step, skill: SkillDescription) -> str:
    """Returns a step as people say it: the skill and what people specify of it, without devices and what follows."""
    said = [
        str(step.arguments[p.key])
        for p in skill.params
        if p.key in step.arguments and p.kind not in (Kind.HARDWARE, Kind.PLANNING)
    ]
    return " ".join((step.skill, *said))
