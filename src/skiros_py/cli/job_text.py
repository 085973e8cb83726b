"""How jobs are shown on a terminal, and what exit status an outcome is."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from datetime import datetime
from typing import TYPE_CHECKING, Any

from skiros_py.cli.exit_status import NO_PLAN, NOT_REACHED, REACHED, STOPPED
from skiros_py.cli.text import escaped

if TYPE_CHECKING:
    from skiros_py.api.jobs import Job, JobPlan, JobStep, JobTransition

_STATUS = {
    "succeeded": REACHED,
    "goal already satisfied": REACHED,
    "no plan": NO_PLAN,
    "stopped": STOPPED,
    "aborted": STOPPED,
}


def status_of(job: Job) -> int:
    """Returns the exit status that tells what came of a job: the same as that of ``skiros run``."""
    return _STATUS.get(job.outcome or "", NOT_REACHED)


def state_line(job: Job) -> str:
    """Returns where a job is, in one line."""
    if job.outcome is not None:
        return f"{job.id}: {job.outcome}"
    detail = f": {job.detail}" if job.detail else ""
    choices = f" [{'/'.join(job.choices)}]" if job.choices else ""
    return f"{job.id}: {_state(job)}{detail}{choices}"


def job_lines(job: Job) -> Iterator[str]:
    """Yields what is known of a job."""
    yield state_line(job)
    if job.order.description:
        yield f"  {job.order.description}"
    if job.order.work_master:
        values = ", ".join(f"{name}={value}" for name, value in job.order.parameters.items())
        yield f"  template  {job.order.work_master}{f' ({values})' if values else ''}"
    yield from (f"  goal      {goal}" for goal in job.order.goal)
    yield from _times(job)
    if job.choices:
        yield f"  waits for: skiros job answer {job.id} ({' | '.join(job.choices)})"
    for actual in job.conditions:
        yield f"  {'reached' if actual.reached else 'not    '}   {actual.condition}{_because(actual.reason)}"
    yield from (f"  moved     {one.element} from {one.origin} to {one.place or 'nowhere'}" for one in job.materials)
    yield from (f"  why not   {reason}" for reason in job.reasons)


def _times(job: Job) -> Iterator[str]:
    order = job.order
    if order.priority:
        yield f"  priority  {order.priority}"
    moments = (
        ("not before", order.not_before), ("deadline", order.deadline), ("ordered", job.ordered),
        ("started", job.started), ("ended", job.ended),
    )  # fmt: skip
    for what, when in moments:
        if when is not None:
            yield f"  {what:9} {_shown(when)}{', late' if what == 'deadline' and job.late else ''}"


def plan_lines(plan: JobPlan) -> Iterator[str]:
    """Yields the steps of a plan, numbered."""
    if not plan.steps:
        yield "there is no plan (yet)"
    for number, step in enumerate(plan.steps, start=1):
        yield f"{number:3}. {step.text}"


def trace_lines(entries: Sequence[Mapping[str, Any]]) -> Iterator[str]:
    """Yields what happened for a job."""
    for entry in entries:
        time = entry.get("time")
        yield f"{time:8.1f} s  {_entry(entry)}" if isinstance(time, int | float) else _entry(entry)


def _entry(entry: Mapping[str, Any]) -> str:
    return " ".join(str(entry[part]) for part in ("what", "text") if entry.get(part))


def response_lines(steps: Sequence[JobStep], transitions: Sequence[JobTransition]) -> Iterator[str]:
    """Yields the skills that were run, and the changes of state."""
    for step in steps:
        yield f"{step.number:3}. {step.skill} {' '.join(step.arguments.values())}: {step.ended or 'nobody knows'}"
    for change in transitions:
        yield f"{_shown(change.at)}  {change.trigger}: {change.state.text}{_because(change.comment)}"


def print_jobs(jobs: Sequence[Job]) -> None:
    """Prints a table of jobs."""
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    table = Table(box=None, pad_edge=False)
    for column in ("job", "state", "priority", "ordered", "goal"):
        table.add_column(column, justify="right" if column == "priority" else "left", overflow="fold")
    for job in jobs:
        state = job.outcome or f"{_state(job)}{f' ({job.detail})' if job.detail else ''}"
        ordered = _shown(job.ordered) if job.ordered else ""
        cells = (job.id, state, str(job.order.priority), ordered, "; ".join(job.order.goal))
        table.add_row(*(Text(escaped(cell)) for cell in cells))
    console = Console(highlight=False)
    if not console.is_terminal:
        console.width = 200
    console.print(table)


def _state(job: Job) -> str:
    return " ".join((job.state.text, *job.state.substates[-1:]))


def _because(reason: str) -> str:
    return f": {reason}" if reason else ""


def _shown(when: datetime) -> str:
    return when.astimezone().strftime("%Y-%m-%d %H:%M:%S %z")
