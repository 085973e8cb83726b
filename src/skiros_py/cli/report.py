"""``skiros report``: a page about a run that was recorded."""

from __future__ import annotations

from pathlib import Path

import click

from skiros_py.cli.exit_status import REACHED
from skiros_py.cli.options import JSON
from skiros_py.cli.output import answer
from skiros_py.errors import FileError

__all__ = ["command"]


@click.command("report", epilog="Example: skiros run kitting --data work && skiros report work --output run.html")
@click.argument("run", type=click.Path(path_type=Path))
@click.option(
    "--output",
    type=click.Path(dir_okay=False, path_type=Path),
    metavar="FILE.html",
    help="Where the page goes.  [default: the record's name in the present folder]",
)
@JSON
def command(run: Path, output: Path | None, as_json: bool) -> int:
    """Makes a page about RUN: a record, or a data directory for the record of its latest run.

    With --json the record's content is printed as data instead; a page is written where --output asks for one.
    """
    from skiros_py.records import Record, find_record, report_page

    with Record(find_record(run)) as record:
        page = output or (None if as_json else Path(f"{record.path.stem}.html"))
        if page is not None:
            _write(page, report_page(record))
        if as_json:
            answer(record.as_json())
        else:
            click.echo(f"{page}")
    return REACHED


def _write(path: Path, text: str) -> None:
    try:
        path.write_text(text, encoding="utf-8")
    except OSError as error:
        raise FileError(path, f"cannot be written: {error.strerror or error}") from error
