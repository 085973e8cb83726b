"""``skiros job``: order jobs, follow and command them."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import click

from skiros_py.cli.commands import Found, served
from skiros_py.cli.job_text import (
    follow_job,
    job_lines,
    job_table,
    plan_lines,
    response_lines,
    state_line,
    trace_lines,
)
from skiros_py.cli.lazy import LazyGroup
from skiros_py.cli.server_choice import reach

if TYPE_CHECKING:
    from skiros_py.cli.job_files import JobFiles
    from skiros_py.client import Client
    from skiros_py.client.operation import Sender
    from skiros_py.client.topics.work import Jobs as Topic

    Jobs = Topic[Sender] | JobFiles

_STATES = ("NotAllowedToStart", "AllowedToStart", "Running", "Interrupted", "Ended", "Aborted")
_PAGE = 1000

_ELSEWHERE = {
    "submit": ("job_order:submit", "Orders a job."),
    "preview": ("job_order:preview", "Shows what would be done for a goal, without doing it."),
}
"""Commands in other modules, imported when used."""


@click.group("job", cls=LazyGroup, elsewhere=_ELSEWHERE)
def command() -> None:
    """Orders jobs of a server, follows and commands them.

    The server is that of a data directory of yours (--data), or named by --url with a key in --key-file or SKIROS_KEY.
    Without a server, --data shows the jobs that are kept there.
    """


# ---------------------------------------------------------------- looking


@contextmanager
def _jobs(data: Path | None, url: str | None, key_file: Path | None) -> Iterator[Jobs]:
    """Opens the jobs of a server; if none runs on a data directory, the jobs stored there."""
    from skiros_py.cli.job_files import kept_jobs
    from skiros_py.client.client import find_server

    if data is not None and find_server(data) is None:
        with kept_jobs(data) as files:
            click.echo(f"no server runs on {data}: these are the jobs stored there", err=True)
            yield files
    else:
        with reach(data, url, key_file) as client:
            yield client.jobs


@served("job list --data cell --state Running --state Interrupted", command, _jobs)
@click.option("--state", "states", multiple=True, type=click.Choice(_STATES), help="Only this state; may be repeated.")
@click.option("--limit", type=click.IntRange(1, 1000), default=100, show_default=True, help="How many at most.")
@click.option("--cursor", type=click.IntRange(min=0), help="Go on where the list before ended.")
def list_jobs(jobs: Jobs, states: tuple[str, ...], limit: int, cursor: int | None) -> Found:
    """Lists jobs in the order in which they were ordered."""
    found = jobs.list(states=states, limit=limit, cursor=None if cursor is None else str(cursor))
    more = [] if found.next is None else [f"there are more: --cursor {found.next}"]
    return found, [*job_table(found.items), *more]


@served("job show kit-17 --data cell", command, _jobs)
@click.argument("job")
def show(jobs: Jobs, job: str) -> Found:
    """Shows the state of JOB."""
    found = jobs.get(job)
    return found, job_lines(found)


@served("job plan kit-17 --data cell", command, _jobs)
@click.argument("job")
def plan(jobs: Jobs, job: str) -> Found:
    """Shows the last plan of JOB."""
    found = jobs.plan(job)
    return found, plan_lines(found)


@served("job trace kit-17 --data cell", command, _jobs)
@click.argument("job")
def trace(jobs: Jobs, job: str) -> Found:
    """Shows the trace of JOB, oldest entry first."""
    page = jobs.trace(job, limit=_PAGE)
    entries = list(page.items)
    while page.next is not None:
        page = jobs.trace(job, limit=_PAGE, cursor=page.next)
        entries += page.items
    return page.model_copy(update={"items": entries}), trace_lines(entries)


@served("job response kit-17 --data cell --json", command)
@click.argument("job")
def response(client: Client, job: str) -> Found:
    """Shows the result of JOB: skills executed, changes of state (ISA-95: job response)."""
    found = client.jobs.response(job)
    return found, response_lines(found.job_response_data, found.transitions)


@served("job watch kit-17 --data cell", command)
@click.argument("job")
def watch(client: Client, job: str) -> Found:
    """Follows JOB until it is over, across connection failures and server restarts. Ctrl-C ends only the watching.

    Exit status as that of 'skiros run': 0 reached, 1 not reached, 3 no plan, 130 stopped or aborted.
    """
    return follow_job(client, job)


# ---------------------------------------------------------------- commanding


_REMOVE = ("cancel", "clear")
_COMMANDS = {
    "start": "Allows JOB to start when its turn comes.",
    "revoke-start": "Revokes the permission of JOB to start.",
    "pause": "Pauses JOB: everything that it moves comes to a standstill.",
    "resume": "Resumes JOB after a pause.",
    "stop": "Ends JOB in an orderly way.",
    "abort": "Aborts JOB, started or not.",
    "cancel": "Removes JOB if it has not started.",
    "clear": "Removes JOB with all its data if it is over.",
}


def _add_command(name: str, text: str) -> None:
    @served(f"job {name} kit-17 --data cell", command, help=text)
    @click.argument("job")
    @click.option("--comment", default="", metavar="TEXT", help="Reason, for the record.")
    def run(client: Client, job: str, comment: str) -> Found:
        found = getattr(client.jobs, name.replace("-", "_"))(job, comment)
        return ({"id": job, "removed": True}, [f"{job}: removed"]) if name in _REMOVE else (found, [state_line(found)])


for _name, _text in _COMMANDS.items():
    _add_command(_name, _text)


@served("job answer kit-17 retry --data cell", command)
@click.argument("job")
@click.argument("choice")
def reply(client: Client, job: str, choice: str) -> Found:
    """Answers the question for which JOB waits, with one of its choices; 'skiros job show JOB' lists them."""
    found = client.jobs.answer(job, choice)
    return found, [state_line(found)]
