"""The files of a data directory: checked, copied, and opened again after a loss."""

from __future__ import annotations

import json
import shutil
import sqlite3
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing, suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from skiros_py import commits, database_file
from skiros_py.commits import ENDING, Loss
from skiros_py.database_file import DatabaseFile
from skiros_py.errors import FileError, Refused, SkirosError
from skiros_py.recording.reader import SUFFIX, Recording
from skiros_py.station.requests import admitted
from skiros_py.tasks.jobs.store import unreadable_jobs
from skiros_py.workers import Worker
from skiros_py.world.journal.data_directory import BACKUPS, DATABASES, FILES, DirectoryLock, make_folder
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
        database_file.back_up(paths, folder)
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
                losses.append(database_file.accept_loss(path))
            except (sqlite3.Error, OSError) as error:
                raise FileError(path, f"the file is damaged ({error}): {_RESTORE}") from error
        return [loss for loss in losses if loss is not None]
    finally:
        lock.release()


class DataFiles:
    """Checks and copies the data directory of a running station, in a process of its own.

    Args:
        data: The data directory.
    """

    def __init__(self, data: Path) -> None:
        self._data = data
        self._place = threading.Lock()

    def check(self, more: Callable[[Path], Iterator[Finding]]) -> list[Finding]:
        """Returns what is wrong with the files.

        Args:
            more: Yields further findings; picklable.

        Raises:
            Busy: Another check or copy is made.
        """
        found: list[Finding] = self._do("check", more)
        return found

    def back_up(self, name: str) -> tuple[Path, Sequence[Path]]:
        """Copies the data directory into its folder ``backups``.

        Args:
            name: Name of the copy.

        Returns:
            The folder of the copy, and its files.

        Raises:
            Refused: There is a copy of this name, or a file is damaged.
            Busy: Another check or copy is made.
        """
        folder = self._data / BACKUPS / name
        try:
            make_folder(folder.parent)
            files: Sequence[Path] = self._do("back_up", folder)
        except FileError as error:
            raise Refused("NotCopied", f"{error.path.name}: {error.reason}") from None
        return folder, files

    def _do(self, what: str, argument: object) -> Any:
        with admitted(self._place, "the data directory is being checked or copied: ask again when that is done"):
            worker = Worker("data directory", partial(_Files, self._data))
            try:
                return worker.call(what, argument).result()
            finally:
                worker.close()


@dataclass(frozen=True, slots=True)
class _Files:
    """What the process of :class:`DataFiles` does."""

    data: Path

    def check(self, more: Callable[[Path], Iterator[Finding]]) -> list[Finding]:
        return [*check_data(self.data), *more(self.data)]

    def back_up(self, folder: Path) -> Sequence[Path]:
        return back_up(self.data, folder)


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
        loss = database_file.find_loss(path)
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
