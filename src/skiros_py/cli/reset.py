"""``skiros reset``: lets robots start again after everything was halted."""

from __future__ import annotations

from pathlib import Path

import click

from skiros_py.cli.options import JSON
from skiros_py.cli.reaching import reach, server_options
from skiros_py.cli.stop import show_stop


@click.command("reset", epilog="Example: skiros reset --data cell")
@server_options
@JSON
def command(data: Path | None, url: str | None, key_file: Path | None, as_json: bool) -> int:
    """Lets the robots of a server start again after everything was halted; look first why that was.

    Jobs that were under way wait for an answer then: skiros job answer JOB retry.
    """
    with reach(data, url, key_file) as client:
        info = client.station.reset()
    return show_stop(info, as_json=as_json)
