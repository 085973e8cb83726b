"""``skiros stop``: everything halts, from the shell."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from skiros_py.cli.exit_status import NOT_REACHED, REACHED
from skiros_py.cli.options import JSON
from skiros_py.cli.output import answer
from skiros_py.cli.reaching import reach, server_options
from skiros_py.cli.text import escaped

if TYPE_CHECKING:
    from skiros_py.api.stop import StopInfo

_TIMEOUT, _TRIES = 3.0, 3
"""Whoever wants everything to stop must soon know when that does not work [s], [tries]."""


@click.command("stop", epilog="Example: skiros stop --data cell --reason 'a person is in the cell'")
@click.option("--reason", default="", metavar="TEXT", help="Why, for those who have to reset it.")
@server_options
@JSON
def command(reason: str, data: Path | None, url: str | None, key_file: Path | None, as_json: bool) -> int:
    """Halts all robots of a server in the next control cycle; nothing moves until 'skiros reset'.

    It does not replace the emergency stop of a machine. Exit status: 0 obeyed, 1 not, or not known.
    """
    with reach(data, url, key_file, timeout=_TIMEOUT, tries=_TRIES) as client:
        info = client.station.stop(reason)
    return show_stop(info, as_json=as_json)


def show_stop(info: StopInfo, *, as_json: bool) -> int:
    """Shows whether everything is halted, and returns the exit status that says whether that can be relied on."""
    if as_json:
        answer(info.model_dump(mode="json"))
    elif not info.halted:
        click.echo("nothing is halted")
    elif not info.obeyed:
        click.echo("NOT OBEYED: the control thread does not come round; press the button of the machine", err=True)
    else:
        stands = "everything stands" if info.standing else "it brakes"
        by = f", by {info.by}" if info.by else ""
        click.echo(escaped(f"halted ({info.why}{by}): {stands}"))
    return REACHED if info.obeyed else NOT_REACHED
