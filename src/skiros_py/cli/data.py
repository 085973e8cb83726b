"""``skiros data``: backups and checks of a data directory."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import closing
from pathlib import Path

import click

from skiros_py.cli.commands import Found, reports
from skiros_py.cli.options import DATA
from skiros_py.cli.output import DIFFERENT, REACHED, answer_text, counted
from skiros_py.commits import Loss
from skiros_py.database_file import DatabaseFile
from skiros_py.errors import FileError
from skiros_py.station.data_files import Finding, accept_loss, back_up, check_data
from skiros_py.world.scene.files import write_atomically


@click.group("data")
def command() -> None:
    """Backs up and checks a data directory, also while a server runs on it."""


@reports("data backup backups/monday --data plant", command)
@click.argument("folder", type=click.Path(path_type=Path))
@DATA
def backup(folder: Path, data: Path) -> Found:
    """Copies a data directory to FOLDER, which must be new; damaged files are not copied.

    The copy is a data directory: it is restored by moving it to the place of the other one.
    """
    files = back_up(data, folder)
    size = sum(file.stat().st_size for file in files)
    names = [str(file.relative_to(folder)) for file in files]
    lines = [f"{folder}: {counted(file=len(files))}, {size / 1e6:.1f} MB"]
    return {"folder": str(folder), "files": names, "bytes": size}, lines


@reports("data check --data plant", command)
@DATA
def check(data: Path) -> Found:
    """Checks every file of a data directory, without changing it.

    Exit status: 0 everything is well, 1 something is damaged, missing or was changed.
    """
    from skiros_py.server.access.audit import audit_findings

    found = [*check_data(data), *audit_findings(data)]
    return {"findings": found}, _finding_lines(found), DIFFERENT if found else REACHED


def _finding_lines(found: list[Finding]) -> Iterator[str]:
    for one in found:
        first, *more = one.fault.splitlines()
        yield f"{one.file}: {first}"
        yield from more
        yield f"  → {one.advice}"
    yield counted(fault=len(found)) if found else "every file is whole"


@reports("data accept-loss --data plant", command, name="accept-loss")
@DATA
def accept(data: Path) -> Found:
    """Goes on without acknowledged writes that are missing in a data directory; no server may run on it.

    They are listed. A damaged write-ahead log is kept beside its database, as FILE-wal.kept.
    """
    losses = accept_loss(data)
    shown = [
        {"file": loss.path.name, "count": loss.count, "missing": [str(one) for one in loss.commits]} for loss in losses
    ]
    return {"losses": shown}, _loss_lines(losses)


def _loss_lines(losses: Sequence[Loss]) -> Iterator[str]:
    for loss in losses:
        yield from f"{loss.path.name}: {loss}".splitlines()
    yield "it can be opened again, as it is" if losses else "nothing is missing"


@command.command("audit", epilog="Example: skiros data audit audit.jsonl --data plant")
@click.argument("file", required=False, type=click.Path(dir_okay=False, path_type=Path))
@DATA
def audit(file: Path | None, data: Path) -> int:
    """Exports the audit log as JSON Lines, oldest record first, to FILE or to stdout.

    Each line holds the SHA-256 of the line before, as "previous".
    """
    from skiros_py.server.access.audit import exported

    with closing(_audit_file(data)) as opened:
        lines = exported(opened)
        if file is None:
            for line in lines:
                answer_text(line)
        else:
            write_atomically(file, "".join(f"{line}\n" for line in lines))
    return REACHED


def _audit_file(data: Path) -> DatabaseFile:
    from skiros_py.server.access.keys import FILE

    if not (data / FILE).exists():
        raise FileError(data, f"there is no {FILE} in it: no server has run on it")
    return DatabaseFile(data / FILE)
