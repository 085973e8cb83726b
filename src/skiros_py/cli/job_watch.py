"""``skiros job watch``: follows a job until it is over."""

from __future__ import annotations

import sys
from contextlib import nullcontext
from typing import TYPE_CHECKING

import click

from skiros_py.cli.job_text import job_lines, state_line, status_of
from skiros_py.cli.options import JSON
from skiros_py.cli.output import tell
from skiros_py.cli.reaching import with_client
from skiros_py.cli.text import escaped

if TYPE_CHECKING:
    from rich.status import Status

    from skiros_py.api.events import EventInfo
    from skiros_py.api.jobs import Job
    from skiros_py.client import Client


@click.command("watch", epilog="Example: skiros job watch kit-17 --data cell")
@click.argument("job")
@with_client()
@JSON
def watch(job: str, client: Client, as_json: bool) -> int:
    """Follows JOB until it is over, over broken connections and restarts of the server. Ctrl-C ends only the watching.

    Exit status as that of 'skiros run': 0 reached, 1 not reached, 3 no plan, 130 stopped or aborted.
    """
    return follow_job(client, job, as_json=as_json)


def follow_job(client: Client, name: str, *, as_json: bool) -> int:
    """Shows what happens for a job until it is over, then what came of it.

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
    """Returns the line that says what is going on, where a terminal shows one."""
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
    """Says where a job is, if that is news; returns what was said."""
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
