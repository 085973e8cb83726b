"""``skiros job start|pause|…|answer``: commands to jobs."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from skiros_py.cli.exit_status import REACHED
from skiros_py.cli.options import JSON
from skiros_py.cli.output import answer
from skiros_py.cli.reaching import reach, server_options

if TYPE_CHECKING:
    from skiros_py.api.jobs import Job

_REMOVE = ("cancel", "clear")


def _command(name: str, method: str, text: str) -> click.Command:
    """Makes the command that sends one of a job's commands.

    Args:
        name: What people type.
        method: What the client calls it.
        text: What it does, for its help.
    """

    @click.command(name, help=text, epilog=f"Example: skiros job {name} kit-17 --data cell")
    @click.argument("job")
    @click.option("--comment", default="", metavar="TEXT", help="Why, for the record.")
    @server_options
    @JSON
    def run(job: str, comment: str, data: Path | None, url: str | None, key_file: Path | None, as_json: bool) -> int:
        with reach(data, url, key_file) as client:
            found: Job = getattr(client.jobs, method)(job, comment)
        return _show(job, None if name in _REMOVE else found, as_json=as_json)

    return run


start = _command("start", "start", "Gives JOB leave to start when its turn comes.")
revoke_start = _command("revoke-start", "revoke_start", "Takes back the leave of JOB to start.")
pause = _command("pause", "pause", "Lets JOB come to a standstill where it is.")
resume = _command("resume", "resume", "Goes on with JOB, which stands.")
stop = _command("stop", "stop", "Ends JOB in good order.")
abort = _command("abort", "abort", "Gives JOB up, begun or not.")
cancel = _command("cancel", "cancel", "Removes JOB, which has not begun.")
clear = _command("clear", "clear", "Removes JOB, which is over, with all that is known of it.")


@click.command("answer", epilog="Example: skiros job answer kit-17 retry --data cell")
@click.argument("job")
@click.argument("choice")
@server_options
@JSON
def reply(job: str, choice: str, data: Path | None, url: str | None, key_file: Path | None, as_json: bool) -> int:
    """Answers what JOB waits for with one of its CHOICEs; 'skiros job show JOB' lists them."""
    with reach(data, url, key_file) as client:
        found = client.jobs.answer(job, choice)
    return _show(job, found, as_json=as_json)


def _show(name: str, job: Job | None, *, as_json: bool) -> int:
    """Shows what has become of a job; None where it was removed."""
    from skiros_py.cli.job_text import say, state_line

    if as_json:
        answer({"id": name, "removed": True} if job is None else job.model_dump(mode="json", by_alias=True))
    else:
        say([f"{name}: removed" if job is None else state_line(job)])
    return REACHED
