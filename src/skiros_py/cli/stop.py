"""``skiros stop`` and ``skiros reset``: everything halts, and may start again."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from skiros_py.cli.options import JSON
from skiros_py.cli.output import NOT_REACHED, REACHED, tell
from skiros_py.cli.reaching import with_client

if TYPE_CHECKING:
    from skiros_py.api.alarms import StopInfo
    from skiros_py.client import Client

_TIMEOUT, _TRIES = 3.0, 3
"""A stop that does not work must be known soon [s], [tries]."""


@click.command("stop", epilog="Example: skiros stop --data cell --reason 'a person is in the cell'")
@click.option("--reason", default="", metavar="TEXT", help="Why, for those who have to reset it.")
@with_client(timeout=_TIMEOUT, tries=_TRIES)
@JSON
def stop(reason: str, client: Client, as_json: bool) -> int:
    """Halts all robots of a server in the next control cycle; nothing moves until 'skiros reset'.

    It does not replace the emergency stop of a machine. Exit status: 0 obeyed, 1 not, or not known.
    """
    return _show(client.station.stop(reason), as_json=as_json)


@click.command("reset", epilog="Example: skiros reset --data cell")
@with_client()
@JSON
def reset(client: Client, as_json: bool) -> int:
    """Lets the robots of a server start again after everything was halted; look first why that was.

    Jobs that were under way wait for an answer then: skiros job answer JOB retry.
    """
    return _show(client.station.reset(), as_json=as_json)


def _show(info: StopInfo, *, as_json: bool) -> int:
    """Shows whether everything is halted, and returns the exit status that says whether that can be relied on."""
    if not info.obeyed and info.halted and not as_json:
        click.echo("NOT OBEYED: the control thread does not run; press the button of the machine", err=True)
        return NOT_REACHED
    by = f", by {info.by}" if info.by else ""
    halted = f"halted ({info.why}{by}): {'everything stands' if info.standing else 'it brakes'}"
    tell(info, [halted if info.halted else "nothing is halted"], as_json=as_json)
    return REACHED if info.obeyed else NOT_REACHED
