"""Shows jobs on a terminal and follows them until they end."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import nullcontext
from datetime import datetime
from typing import TYPE_CHECKING, Any

import click

from skiros_py.cli.commands import Found
from skiros_py.cli.output import NO_PLAN, NOT_REACHED, REACHED, STOPPED, console, table_lines
from skiros_py.errors import escaped

if TYPE_CHECKING:
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
    if not plan.items:
        yield "there is no plan (yet)"
    for number, step in enumerate(plan.items, start=1):
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


def job_table(jobs: Sequence[Job]) -> list[str]:
    """Returns a table of jobs."""
    rows = [
        (
            job.id,
            job.outcome or f"{_state(job)}{f' ({job.detail})' if job.detail else ''}",
            str(job.order.priority),
            _shown(job.ordered) if job.ordered else "",
            "; ".join(job.order.goal),
        )
        for job in jobs
    ]
    return table_lines(("job", "state", "priority", "ordered", "goal"), rows, right=("priority",))


def _state(job: Job) -> str:
    return " ".join((job.state.text, *job.state.substates[-1:]))


def _because(reason: str) -> str:
    return f": {reason}" if reason else ""


def _shown(when: datetime) -> str:
    return when.astimezone().strftime("%Y-%m-%d %H:%M:%S %z")


def follow_job(client: Client, name: str) -> Found:
    """Shows the events of a job until it is over; returns its outcome.

    With ``--json`` the events go to stderr.

    Args:
        client: Reaches its server.
        name: Its id.
    """
    from skiros_py.api.events import EventInfo
    from skiros_py.client.streams import stream_job_events

    shown = console(file=sys.stdout)
    said = ""
    with shown.status("") if shown.is_terminal else nullcontext() as live:
        job = client.jobs.get(name)
        for event in client.follow(stream_job_events(name)):
            if isinstance(event, EventInfo) and event.kind != "job":
                if text := str(event.data.get("text") or ""):
                    click.echo(escaped(f"{event.time:8.1f} s  {text}"))
                    sys.stdout.flush()
                continue
            job = client.jobs.get(name)
            if (line := state_line(job)) != said:
                click.echo(escaped(line))
                said = line
            if live is not None:
                live.update(f"{job.state.text} {job.detail}".replace("[", "\\["))
            if job.outcome is not None:
                break
    return job, job_lines(job), status_of(job)
