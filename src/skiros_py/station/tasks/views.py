"""Tasks, as the API shows them."""

from __future__ import annotations

from dataclasses import asdict
from datetime import UTC, datetime

from skiros_py.api.tasks import TaskInfo, TaskQuestion, TaskReport, TaskStep, TaskTrace
from skiros_py.station.jobs.accounts import planned_steps
from skiros_py.station.tasks.book import KeptTask
from skiros_py.tasks.report import GoalReport
from skiros_py.tasks.trace import TraceEntry, TraceEventKind

_ENDS = (TraceEventKind.ENDED, TraceEventKind.FAILED, TraceEventKind.BROKEN_OFF)


def task_info(task: KeptTask, *, in_full: bool = True) -> TaskInfo:
    """Describes a task; callable in any thread; without ``in_full``, omits its plan and steps."""
    question, report, plan = task.question, task.report, task.plan
    return TaskInfo.view_of(
        task,
        begun=datetime.fromtimestamp(task.wall, UTC),
        plan=planned_steps(plan) if in_full and plan is not None else (),
        steps=_steps(tuple(task.entries)) if in_full else (),
        question=TaskQuestion.view_of(question) if question else None,
        report=_report(report) if report is not None else None,
    )


def _steps(entries: tuple[TraceEntry, ...]) -> tuple[TaskStep, ...]:
    """Combines the start and the end of each step."""
    found: dict[int, TaskStep] = {}
    for entry in entries:
        if entry.step is None:
            continue
        if entry.what is TraceEventKind.STARTED:
            found[entry.step] = _started(entry.step, entry)
        elif entry.what in _ENDS and entry.step in found:
            ended = {"end": entry.time, "ended": entry.what.value, "text": entry.text}
            found[entry.step] = found[entry.step].model_copy(update=ended)
    return tuple(found[number] for number in sorted(found))


def _started(number: int, entry: TraceEntry) -> TaskStep:
    return TaskStep.view_of(
        entry, number=number, arguments=dict(entry.arguments), start=entry.time, end=None, ended=None
    )


def _report(report: GoalReport) -> TaskReport:
    conditions = tuple(asdict(condition) for condition in report.conditions)
    return TaskReport.view_of(report, outcome=report.outcome.value, conditions=conditions)


def task_trace(task: KeptTask, limit: int) -> TaskTrace:
    """Returns the last entries of the trace of a task."""
    entries = tuple(task.entries)
    kept = entries[-limit:]
    forgotten = task.forgotten + len(entries) - len(kept)
    return TaskTrace(entries=tuple(entry.as_json() for entry in kept), forgotten=forgotten)
