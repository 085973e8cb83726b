"""The files of a data directory: checked, copied, and opened again after a loss."""

from __future__ import annotations

import json
import shutil
import sqlite3
from collections.abc import Iterator, Sequence
from contextlib import closing, suppress
from dataclasses import dataclass
from pathlib import Path

from skiros_py import commits, database
from skiros_py.commits import ENDING, Loss
from skiros_py.database import DatabaseFile
from skiros_py.errors import FileError, SkirosError
from skiros_py.recording.reader import SUFFIX, Recording
from skiros_py.tasks.jobs.store import unreadable_jobs
from skiros_py.world.journal.data_directory import DATABASES, FILES, DirectoryLock
from skiros_py.world.journal.records import select_after
from skiros_py.world.ontology.documents import read_document

_BACKUP_ORDER = ("webhooks.db", "jobs.db", "journal.db", "server.db", "access.db")
"""No message is noted as sent about a job that is not in the copy, nor a step as done that the world does not know."""
_RESTORE = "restore a backup of the data directory"


@dataclass(frozen=True, slots=True)
class Finding:
    """Something that is wrong with a file.

    Attributes:
        file: Path of the file within the data directory.
        fault: What is wrong.
        advice: What to do.
    """

    file: str
    fault: str
    advice: str


def check_data(data: Path) -> Iterator[Finding]:
    """Yields what is wrong with the files of a data directory; nothing is changed, and a server may use it.

    Args:
        data: The data directory.

    Raises:
        FileError: It is no data directory.
    """
    for path in _databases(data, DATABASES):
        yield from (Finding(path.name, fault, advice) for fault, advice in _database_faults(path))
        if unreadable := commits.damaged(path) if commits.exists(path) else 0:
            yield Finding(path.name, f"{unreadable} notes of commits are damaged", "they are replaced by later ones")
    for name in FILES:
        for path in sorted(_below(data / name)):
            try:
                _read(path)
            except (SkirosError, OSError, ValueError) as error:
                if not path.exists():  # an old recording that was deleted meanwhile
                    continue
                advice = "it is written again from the journal" if name == "learned.ttl" else "remove it, or restore it"
                reason = error.reason if isinstance(error, FileError) else str(error)
                yield Finding(str(path.relative_to(data)), reason, advice)


def back_up(data: Path, folder: Path) -> Sequence[Path]:
    """Copies a data directory, while a server may use it; the copy is a data directory, too.

    Args:
        data: The data directory.
        folder: The copy; must not exist yet.

    Returns:
        The copied files.

    Raises:
        FileError: It is no data directory, one of its files is damaged, or the copy cannot be written.
    """
    paths = list(_databases(data, _BACKUP_ORDER))
    for path in paths:
        for fault, advice in _database_faults(path):
            raise FileError(path, f"{fault}: nothing was copied; {advice}")
    try:
        folder.mkdir(0o700, parents=True)
    except OSError as error:
        raise FileError(folder, f"cannot be made: {error.strerror}; choose a new folder") from None
    try:
        database.back_up(paths, folder)
        for name in FILES:
            for path in _below(data / name):
                target = folder / path.relative_to(data)
                target.parent.mkdir(0o700, parents=True, exist_ok=True)
                with suppress(FileNotFoundError):  # an old recording that was deleted meanwhile
                    shutil.copy2(path, target)
    except (sqlite3.Error, OSError) as error:
        shutil.rmtree(folder, ignore_errors=True)
        raise FileError(folder, f"the copy cannot be written: {error}") from error
    return sorted(path for path in folder.rglob("*") if path.is_file())


def accept_loss(data: Path) -> Sequence[Loss]:
    """Gives up the acknowledged writes that are missing in the files of a data directory, which no server uses.

    Args:
        data: The data directory.

    Returns:
        What was missing, by file.

    Raises:
        FileError: It is no data directory, or is in use, or a file is damaged otherwise.
    """
    paths = list(_databases(data, DATABASES))
    lock = DirectoryLock(data)
    try:
        losses = []
        for path in paths:
            try:
                losses.append(database.accept_loss(path))
            except (sqlite3.Error, OSError) as error:
                raise FileError(path, f"the file is damaged ({error}): {_RESTORE}") from error
        return [loss for loss in losses if loss is not None]
    finally:
        lock.release()


def _databases(data: Path, names: Sequence[str]) -> Iterator[Path]:
    """Yields the databases that there are, or were."""
    if not (data / "journal.db").exists() and not (data / f"journal.db{ENDING}").exists():
        raise FileError(data, "is no data directory: there is no journal.db in it")
    for name in names:
        if (data / name).exists() or (data / f"{name}{ENDING}").exists():
            yield data / name


def _database_faults(path: Path) -> Iterator[tuple[str, str]]:
    """Yields what is wrong with a database, and what to do."""
    if not path.exists():
        yield "the file is missing", _RESTORE
        return
    try:
        loss = database.find_loss(path)
        if loss is not None:
            yield str(loss), f"{_RESTORE}, or go on without by 'skiros data accept-loss --data {path.parent}'"
        with closing(DatabaseFile(path)) as file:
            yield from ((fault, _RESTORE) for fault in file.faults())
            if path.name == "journal.db":
                ((first,),) = file.rows("SELECT min(number) FROM changes")
                ((snapshot,),) = file.rows("SELECT max(version) FROM snapshot")
                for _ in select_after(file, snapshot or (first or 1) - 1):
                    pass
            elif path.name == "jobs.db":
                yield from ((fault, _RESTORE) for fault in unreadable_jobs(file))
    except FileError as error:
        yield error.reason, _RESTORE
    except (sqlite3.Error, OSError) as error:
        yield f"the file is damaged ({error})", _RESTORE


def _below(path: Path) -> Iterator[Path]:
    """Yields a file, or the files in a folder; none if it does not exist."""
    return (file for file in (path, *path.rglob("*")) if file.is_file())


def _read(path: Path) -> None:
    """Reads a file to its end.

    Raises:
        SkirosError: It is damaged.
        OSError: It cannot be read.
        ValueError: It is damaged.
    """
    if path.suffix == SUFFIX:
        with Recording(path) as recording:
            for _ in recording.raw_messages():
                pass
    elif path.suffix == ".ttl":
        read_document(path)
    elif path.suffix == ".json":
        json.loads(path.read_bytes())
