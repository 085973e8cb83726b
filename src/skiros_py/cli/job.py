"""``skiros job``: order jobs, follow and command them."""

from __future__ import annotations

from contextlib import AbstractContextManager
from pathlib import Path
from typing import TYPE_CHECKING

import click

from skiros_py.cli.lazy import LazyGroup
from skiros_py.cli.options import JSON
from skiros_py.cli.output import REACHED, tell
from skiros_py.cli.reaching import reach, server_options, with_client

if TYPE_CHECKING:
    from skiros_py.cli.job_files import JobFiles
    from skiros_py.cli.job_server import JobServer
    from skiros_py.client import Client

_STATES = ("NotAllowedToStart", "AllowedToStart", "Running", "Interrupted", "Ended", "Aborted")

_ELSEWHERE = {
    "submit": ("job_order:submit", "Orders a job."),
    "preview": ("job_order:preview", "Shows what would be done for a goal, without doing it."),
    "watch": ("job_watch:watch", "Follows a job until it is over."),
    "start": ("job_commands:start", "Gives a job leave to start."),
    "revoke-start": ("job_commands:revoke_start", "Takes back the leave to start."),
    "pause": ("job_commands:pause", "Lets a job stand for a while."),
    "resume": ("job_commands:resume", "Goes on with a job that stands."),
    "stop": ("job_commands:stop", "Ends a job in good order."),
    "abort": ("job_commands:abort", "Gives a job up."),
    "cancel": ("job_commands:cancel", "Removes a job that has not begun."),
    "clear": ("job_commands:clear", "Removes a job that is over."),
    "answer": ("job_commands:reply", "Answers what a job waits for."),
}
"""Commands of other modules, imported when they are used."""


@click.group("job", cls=LazyGroup, elsewhere=_ELSEWHERE)
def command() -> None:
    """Orders jobs of a server, follows and commands them.

    The server is that of a data directory of yours (--data), or named by --url with a key in --key-file or SKIROS_KEY.
    Without a server, --data shows the jobs that are kept there.
    """


@command.command("list", epilog="Example: skiros job list --data cell --state Running --state Interrupted")
@click.option("--state", "states", multiple=True, type=click.Choice(_STATES), help="In this state only; repeatable.")
@click.option("--limit", type=click.IntRange(1, 1000), default=100, show_default=True, help="How many at most.")
@server_options
@JSON
def list_jobs(
    states: tuple[str, ...], limit: int, data: Path | None, url: str | None, key_file: Path | None, as_json: bool
) -> int:
    """Lists jobs in the order in which they were ordered."""
    from skiros_py.cli.job_text import print_jobs

    with _jobs(data, url, key_file) as jobs:
        found = jobs.list(states, limit)
    if not as_json:
        print_jobs(found)
        return REACHED
    return tell({"jobs": found}, as_json=True)


@command.command("show", epilog="Example: skiros job show kit-17 --data cell")
@click.argument("job")
@server_options
@JSON
def show(job: str, data: Path | None, url: str | None, key_file: Path | None, as_json: bool) -> int:
    """Shows what is known of JOB."""
    from skiros_py.cli.job_text import job_lines

    with _jobs(data, url, key_file) as jobs:
        found = jobs.get(job)
    return tell(found, job_lines(found), as_json=as_json)


@command.command("plan", epilog="Example: skiros job plan kit-17 --data cell")
@click.argument("job")
@server_options
@JSON
def plan(job: str, data: Path | None, url: str | None, key_file: Path | None, as_json: bool) -> int:
    """Shows the last plan of JOB."""
    from skiros_py.cli.job_text import plan_lines

    with _jobs(data, url, key_file) as jobs:
        found = jobs.plan(job)
    return tell(found, plan_lines(found), as_json=as_json)


@command.command("trace", epilog="Example: skiros job trace kit-17 --data cell")
@click.argument("job")
@server_options
@JSON
def trace(job: str, data: Path | None, url: str | None, key_file: Path | None, as_json: bool) -> int:
    """Shows what happened for JOB, oldest first."""
    from skiros_py.cli.job_text import trace_lines

    with _jobs(data, url, key_file) as jobs:
        entries = jobs.trace(job)
    return tell({"entries": entries}, trace_lines(entries), as_json=as_json)


@command.command("response", epilog="Example: skiros job response kit-17 --data cell --json")
@click.argument("job")
@with_client()
@JSON
def response(job: str, client: Client, as_json: bool) -> int:
    """Shows what JOB has come to: skills that were run, changes of state (ISA-95: job response)."""
    from skiros_py.cli.job_text import response_lines

    found = client.jobs.response(job)
    return tell(found, response_lines(found.job_response_data, found.transitions), as_json=as_json)


def _jobs(data: Path | None, url: str | None, key_file: Path | None) -> AbstractContextManager[JobFiles | JobServer]:
    """Opens the jobs of a server; where none runs on a data directory, what is kept there."""
    from skiros_py.cli.job_files import JobFiles
    from skiros_py.cli.job_server import JobServer
    from skiros_py.client.client import find_server

    if data is not None and find_server(data) is None:
        files = JobFiles(data)
        click.echo(f"no server runs on {data}: these are the jobs that are kept there", err=True)
        return files
    return JobServer(reach(data, url, key_file))
