"""``skiros job``: order jobs, follow and command them."""

from __future__ import annotations

from contextlib import AbstractContextManager
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING

import click

from skiros_py.cli.exit_status import REACHED
from skiros_py.cli.options import JSON
from skiros_py.cli.output import answer
from skiros_py.cli.reaching import reach, server_options

if TYPE_CHECKING:
    from skiros_py.cli.job_files import JobFiles
    from skiros_py.cli.job_server import JobServer

_STATES = ("NotAllowedToStart", "AllowedToStart", "Running", "Interrupted", "Ended", "Aborted")

_ELSEWHERE = {
    "submit": ("job_order", "submit", "Orders a job."),
    "preview": ("job_order", "preview", "Shows what would be done for a goal, without doing it."),
    "watch": ("job_watch", "watch", "Follows a job until it is over."),
    "start": ("job_commands", "start", "Gives a job leave to start."),
    "revoke-start": ("job_commands", "revoke_start", "Takes back the leave to start."),
    "pause": ("job_commands", "pause", "Lets a job stand for a while."),
    "resume": ("job_commands", "resume", "Goes on with a job that stands."),
    "stop": ("job_commands", "stop", "Ends a job in good order."),
    "abort": ("job_commands", "abort", "Gives a job up."),
    "cancel": ("job_commands", "cancel", "Removes a job that has not begun."),
    "clear": ("job_commands", "clear", "Removes a job that is over."),
    "answer": ("job_commands", "reply", "Answers what a job waits for."),
}
"""Commands of other modules, imported when they are used."""


class _JobGroup(click.Group):
    def list_commands(self, ctx: click.Context) -> list[str]:
        return [*_ELSEWHERE, *super().list_commands(ctx)]

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        if cmd_name not in _ELSEWHERE:
            return super().get_command(ctx, cmd_name)
        module, name, _ = _ELSEWHERE[cmd_name]
        elsewhere: click.Command = getattr(import_module(f"skiros_py.cli.{module}"), name)
        return elsewhere

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:  # noqa: ARG002  click's
        here = [(name, one.get_short_help_str(100)) for name, one in sorted(self.commands.items())]
        with formatter.section("Commands"):
            formatter.write_dl([*((name, help_) for name, (_, _, help_) in _ELSEWHERE.items()), *here])


@click.group("job", cls=_JobGroup)
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
    if as_json:
        answer({"jobs": [job.model_dump(mode="json", by_alias=True) for job in found]})
    else:
        print_jobs(found)
    return REACHED


@command.command("show", epilog="Example: skiros job show kit-17 --data cell")
@click.argument("job")
@server_options
@JSON
def show(job: str, data: Path | None, url: str | None, key_file: Path | None, as_json: bool) -> int:
    """Shows what is known of JOB."""
    from skiros_py.cli.job_text import job_lines, say

    with _jobs(data, url, key_file) as jobs:
        found = jobs.get(job)
    if as_json:
        answer(found.model_dump(mode="json", by_alias=True))
    else:
        say(job_lines(found))
    return REACHED


@command.command("plan", epilog="Example: skiros job plan kit-17 --data cell")
@click.argument("job")
@server_options
@JSON
def plan(job: str, data: Path | None, url: str | None, key_file: Path | None, as_json: bool) -> int:
    """Shows the last plan of JOB."""
    from skiros_py.cli.job_text import plan_lines, say

    with _jobs(data, url, key_file) as jobs:
        found = jobs.plan(job)
    if as_json:
        answer(found.model_dump(mode="json"))
    else:
        say(plan_lines(found))
    return REACHED


@command.command("trace", epilog="Example: skiros job trace kit-17 --data cell")
@click.argument("job")
@server_options
@JSON
def trace(job: str, data: Path | None, url: str | None, key_file: Path | None, as_json: bool) -> int:
    """Shows what happened for JOB, oldest first."""
    from skiros_py.cli.job_text import say, trace_lines

    with _jobs(data, url, key_file) as jobs:
        entries = jobs.trace(job)
    if as_json:
        answer({"entries": list(entries)})
    else:
        say(trace_lines(entries))
    return REACHED


@command.command("response", epilog="Example: skiros job response kit-17 --data cell --json")
@click.argument("job")
@server_options
@JSON
def response(job: str, data: Path | None, url: str | None, key_file: Path | None, as_json: bool) -> int:
    """Shows what JOB has come to: skills that were run, changes of state (ISA-95: job response)."""
    from skiros_py.cli.job_text import response_lines, say

    with reach(data, url, key_file) as client:
        found = client.jobs.response(job)
    if as_json:
        answer(found.model_dump(mode="json", by_alias=True))
    else:
        say(response_lines(found.job_response_data, found.transitions))
    return REACHED


def _jobs(data: Path | None, url: str | None, key_file: Path | None) -> AbstractContextManager[JobFiles | JobServer]:
    """Opens the jobs of a server; where none runs on a data directory, what is kept there."""
    from skiros_py.cli.job_files import JobFiles
    from skiros_py.cli.job_server import JobServer
    from skiros_py.client.discovery import find_server

    if data is not None and find_server(data) is None:
        files = JobFiles(data)
        click.echo(f"no server runs on {data}: these are the jobs that are kept there", err=True)
        return files
    return JobServer(reach(data, url, key_file))
