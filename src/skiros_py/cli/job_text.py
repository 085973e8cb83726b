"""Shows jobs on a terminal and follows them until they end."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import nullcontext
from datetime import datetime
from typing import TYPE_CHECKING, Any

import click

from skiros_py.cli.output import NO_PLAN, NOT_REACHED, REACHED, STOPPED, escaped, tell

if TYPE_CHECKING:
    from rich.status import Status

    from skiros_py.api.events import EventInfo
    from skiros_py.api.jobs import Job, JobPlan, JobStep, JobTransition
    from skiros_py.client import Client


_STATUS = {
    "succeeded": REACHED,
    "goal already satisfied": REACHED,
    "no plan": NO_PLAN,
    "stopped": STOPPED,
    "aborted": STOPPED,
}


def status_of(job: Job) -> int:
    """Returns the exit status for the outcome of a job: the same as that of ``skiros run``."""
    return _STATUS.get(job.outcome or "", NOT_REACHED)


def state_line(job: Job) -> str:
    """Returns the state of a job in one line."""
    if job.outcome is not None:
        return f"{job.id}: {job.outcome}"
    detail = f": {job.detail}" if job.detail else ""
    choices = f" [{'/'.join(job.choices)}]" if job.choices else ""
    return f"{job.id}: {_state(job)}{detail}{choices}"


def job_lines(job: Job) -> Iterator[str]:
    """Yields the description of a job."""
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
    """Yields the trace of a job."""
    for entry in entries:
        time = entry.get("time")
        yield f"{time:8.1f} s  {_entry(entry)}" if isinstance(time, int | float) else _entry(entry)


def _entry(entry: Mapping[str, Any]) -> str:
    return " ".join(str(entry[part]) for part in ("what", "text") if entry.get(part))


def response_lines(steps: Sequence[JobStep], transitions: Sequence[JobTransition]) -> Iterator[str]:
    """Yields the executed skills and the changes of state."""
    for step in steps:
        yield f"{step.number:3}. {step.skill} {' '.join(step.arguments.values())}: {step.ended or 'unknown'}"
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


def follow_job(client: Client, name: str, *, as_json: bool) -> int:
    """Shows the events of a job until it is over, then its outcome.

    Args:
        client: Reaches its server.
        name: Its id.
        as_json: Whether what came of it is shown as JSON on stdout, and all else on stderr.

    Returns:
        The exit status that tells what came of it.
    """
    with _live(to_stderr=as_json) as live:
        job = _follow(client, name, live, to_stderr=as_json)
    tell(job, job_lines(job), as_json=as_json)
    return status_of(job)


def _live(*, to_stderr: bool) -> Status | nullcontext[None]:
    """Returns the status line of a terminal."""
    from rich.console import Console

    console = Console(stderr=to_stderr, highlight=False)
    return console.status("") if console.is_terminal else nullcontext()


def _follow(client: Client, name: str, live: Status | None, *, to_stderr: bool) -> Job:
    from skiros_py.api.events import EventInfo
    from skiros_py.client.calls.events import stream_job_events

    job, said = client.jobs.get(name), ""
    for event in client.follow(stream_job_events(name)):
        if isinstance(event, EventInfo) and event.kind != "job":
            _tell(event, to_stderr=to_stderr)
            continue
        job = client.jobs.get(name)
        said = _say_state(job, said, live, to_stderr=to_stderr)
        if job.outcome is not None:
            break
    return job


def _say_state(job: Job, said: str, live: Status | None, *, to_stderr: bool) -> str:
    """Prints the state of a job if it has changed; returns the printed line."""
    line = state_line(job)
    if line != said:
        click.echo(escaped(line), err=to_stderr)
    if live is not None:
        live.update(f"{job.state.text} {job.detail}".replace("[", "\\["))
    return line


def _tell(event: EventInfo, *, to_stderr: bool) -> None:
    text = str(event.data.get("text") or "")
    if text:
        click.echo(escaped(f"{event.time:8.1f} s  {text}"), err=to_stderr)
        (sys.stderr if to_stderr else sys.stdout).flush()
