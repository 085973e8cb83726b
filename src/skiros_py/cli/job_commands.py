"""``skiros job start|pause|…|answer``: commands to jobs."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from skiros_py.cli.job_text import state_line
from skiros_py.cli.options import JSON
from skiros_py.cli.output import tell
from skiros_py.cli.reaching import with_client

if TYPE_CHECKING:
    from skiros_py.api.jobs import Job
    from skiros_py.client import Client

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
    @with_client()
    @JSON
    def run(job: str, comment: str, client: Client, as_json: bool) -> int:
        found: Job = getattr(client.jobs, method)(job, comment)
        if name in _REMOVE:
            return tell({"id": job, "removed": True}, [f"{job}: removed"], as_json=as_json)
        return tell(found, [state_line(found)], as_json=as_json)

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
@with_client()
@JSON
def reply(job: str, choice: str, client: Client, as_json: bool) -> int:
    """Answers what JOB waits for with one of its CHOICEs; 'skiros job show JOB' lists them."""
    found = client.jobs.answer(job, choice)
    return tell(found, [state_line(found)], as_json=as_json)
