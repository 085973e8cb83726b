"""Writes the trace of a task, in sentences and as data."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
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
    """

    def __init__(self, task: str, trace: Trace, context: TaskContext) -> None:
        self._task = task
        self._trace = trace
        self._context = context

    def write(
        self, what: TraceEventKind, text: str, data: Mapping[str, Any] | None = None, run: StepRun | None = None
    ) -> None:
        """Adds an entry.

        Args:
            what: The kind of event.
            text: The event in one sentence.
            data: Further details as plain data.
            run: The step; number 0 if it has not started. None for the whole task.
        """
        entry = TraceEntry(self._context.now, what, text, data=data or {}, id=self._task)
        if run is not None:
            step = run.step
            entry = replace(entry, skill=step.skill, arguments=dict(step.arguments), agent=run.agent)
            if run.number:
                own = step_id(self._task, run.number)
                entry = replace(entry, step=run.number, id=own, parent=self._task)
        self._trace.add(entry)
        if what is TraceEventKind.WAITS and self._context.monitor is not None:
            waits, own = f"waits: {entry.data['reason']}", self._task
            event = ModuleEvent(
                entry.time, "skill", entry.skill, Status.RUNNING, 0, waits, agent=entry.agent, task=own, id=own
            )
            self._context.monitor.publish(event)


def describe_step(step: Step, skill: SkillDescription) -> str:
    """Returns a step as text: agent, skill and arguments."""
    return f"{step.arguments[skill.agent]}: {short_step(step, skill)}"


def short_step(step: Step, skill: SkillDescription) -> str:
    """Returns a step in short: the skill and its user-specified arguments, without devices and derived ones."""
    said = [
        str(step.arguments[p.key])
        for p in skill.params
        if p.key in step.arguments and p.kind not in (Kind.HARDWARE, Kind.PLANNING)
    ]
    return " ".join((step.skill, *said))
