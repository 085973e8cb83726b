"""``skiros report``: a page about a run that was recorded."""

from __future__ import annotations

from pathlib import Path

import click

from skiros_py.cli.options import JSON
from skiros_py.cli.output import REACHED, answer


@click.command("report", epilog="Example: skiros run kitting --data work && skiros report work --output run.html")
@click.argument("run", type=click.Path(path_type=Path))
@click.option(
    "--output",
    type=click.Path(dir_okay=False, path_type=Path),
    metavar="FILE.html",
    help="File for the page.  [default: the recording's name in the current folder]",
)
@click.option(
    "--mcap",
    type=click.Path(dir_okay=False, path_type=Path),
    metavar="FILE.mcap",
    help="Write a copy of the recording instead, with a complete index even if the run was interrupted.",
)
@click.option(
    "--pictures",
    type=click.Path(dir_okay=False, path_type=Path),
    metavar="FILE",
    help="Write its pictures instead: as a contact sheet (.png), or as an animation (.gif, .webp).",
)
@JSON
def command(run: Path, output: Path | None, pictures: Path | None, mcap: Path | None, as_json: bool) -> int:
    """Creates a page about RUN: a recording, or a data directory for the recording of its latest run.

    With --json the recording's content is printed as data instead; a page is written only where --output asks for one.
    """
    from skiros_py.recording import Recording, find_recording
    from skiros_py.recording.pictures import check_pictures, write_recorded_pictures
    from skiros_py.recording.report import report_page
    from skiros_py.recording.writer import export
    from skiros_py.world.scene.files import write_atomically

    if pictures is not None:
        check_pictures(pictures, "--pictures")
    with Recording(find_recording(run)) as recording:
        page = output or (None if as_json or mcap or pictures else Path(f"{recording.path.stem}.html"))
        if page is not None:
            write_atomically(page, report_page(recording))
        if pictures is not None:
            write_recorded_pictures(recording, pictures)
        if mcap is not None:
            export(recording, mcap)
        if as_json:
            answer(recording.as_json())
        else:
            click.echo("\n".join(str(path) for path in (page, pictures, mcap) if path is not None))
    return REACHED
