"""The last commits of a database in a file beside it, which shows what is missing if the database ends before them.

SQLite ends the recovery of its write-ahead log at the first damaged frame, without an error: later commits are gone.
Each commit is therefore also noted here, after it and before it is acknowledged. A note is one small write into a ring,
without a sync of its own, so that it survives the process like the commit itself.
"""

from __future__ import annotations

import os
import time
import zlib
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from skiros_py.errors import FileError
from skiros_py.files import open_private

ENDING = "-commits"
"""What the name of the file adds to that of its database."""

_SLOT = 256
"""Length of a note [bytes]: number, time, what was written, and a checksum."""
_SLOTS = 512
"""Number of notes that are kept."""
_CHECKSUM = 8
_BOOT = Path("/proc/sys/kernel/random/boot_id")
_BETWEEN_SYNCS = 1.0
"""Minimum time between two syncs of the file, besides those by its owner [s]."""


@dataclass(frozen=True, slots=True)
class Commit:
    """A commit of a database.

    Attributes:
        number: Counts the commits of the database.
        wall: When it was made [s since 1970].
        what: What it wrote, in words.
    """

    number: int
    wall: float
    what: str

    def __str__(self) -> str:
        """Returns time and content, for people."""
        return f"{time.strftime('%Y-%m-%d %H:%M:%S', time.localtime(self.wall))}  {self.what or 'a write'}"


@dataclass(frozen=True, slots=True)
class Loss:
    """Commits that were acknowledged and are not in the database.

    Attributes:
        path: The database.
        commits: The missing commits, in order; of very many, the last.
        count: Number of all missing commits.
        last: Number of the last commit ever noted.
        power_cut: Whether a power cut explains it: none of them had been synced when the machine last went down.
        unknown: Why it is not known what is missing; empty if it is.
    """

    path: Path
    commits: Sequence[Commit]
    count: int
    last: int
    power_cut: bool = False
    unknown: str = ""

    def __str__(self) -> str:
        """Returns what is missing, for people."""
        if self.unknown:
            return self.unknown
        more = [f"{self.count - len(self.commits)} earlier ones"] if self.count > len(self.commits) else []
        records = "1 write is" if self.count == 1 else f"{self.count} writes are"
        return "\n  - ".join([f"ends before what was acknowledged: {records} missing", *more, *map(str, self.commits)])


class LostCommits(FileError):
    """A database ends before what was acknowledged.

    Attributes:
        loss: What is missing.
    """

    def __init__(self, loss: Loss) -> None:
        self.loss = loss
        advice = (
            "\nit was left as it is: restore a backup of the whole data directory, or go on without them by"
            f" 'skiros data accept-loss --data {loss.path.parent}'"
        )
        super().__init__(loss.path, f"{loss}{advice}")


class CommitLog:
    """The notes of one open database; several processes may add some. Close it.

    Notes that cannot be written, as on a full disk, are left out: the database itself is not affected.

    Args:
        database: Path of the database.
    """

    def __init__(self, database: Path) -> None:
        self._file: int | None = os.open(_path(database), os.O_RDWR)
        self._noted = self._synced_file = time.monotonic()

    def note(self, number: int, what: str, *, synced: bool) -> None:
        """Notes a commit.

        Args:
            number: Its number.
            what: What it wrote, in words.
            synced: Whether the commit is on the disk.
        """
        self._write(1 + number % (_SLOTS - 1), Commit(number, time.time(), what))
        self._noted = time.monotonic()
        if synced:
            self.synced(number)
            if self._noted - self._synced_file > _BETWEEN_SYNCS:
                self.sync()

    def synced(self, number: int) -> None:
        """Notes that the commits up to a number are on the disk."""
        self._write(0, Commit(number, time.time(), _boot()))

    def sync(self) -> None:
        """Waits until the notes are on the disk, too, if there are new ones."""
        if self._file is not None and self._noted >= self._synced_file:
            self._synced_file = time.monotonic()
            with suppress(OSError):
                os.fsync(self._file)

    def close(self) -> None:
        """Closes the file; may be called twice."""
        self.sync()
        file, self._file = self._file, None
        if file is not None:
            os.close(file)

    def _write(self, slot: int, commit: Commit) -> None:
        if self._file is not None:
            with suppress(OSError):
                os.pwrite(self._file, _encoded(commit), slot * _SLOT)


def create(database: Path, last: int, what: str) -> None:
    """Writes the file for a database whose content is complete and on the disk; replaces an older file.

    Args:
        database: Path of the database.
        last: Number of its last commit.
        what: Why the file begins with it, in words.

    Raises:
        OSError: It cannot be written.
    """
    path = _path(database)
    new = path.with_name(f"{path.name}.new")
    content = bytearray(_SLOTS * _SLOT)  # written in full, so that later notes need no room on the disk
    for slot, commit in (
        (0, Commit(last, time.time(), _boot())),
        (1 + last % (_SLOTS - 1), Commit(last, time.time(), what)),
    ):
        content[slot * _SLOT : (slot + 1) * _SLOT] = _encoded(commit)
    new.unlink(missing_ok=True)
    file = open_private(os.fspath(new), os.O_WRONLY | os.O_CREAT | os.O_EXCL)
    try:
        os.write(file, content)
        os.fsync(file)
    finally:
        os.close(file)
    new.replace(path)


def find_loss(database: Path, last: int, noted: Sequence[Commit | None] | None) -> Loss | None:
    """Compares a database with the notes of its commits.

    Args:
        database: Path of the database.
        last: Number of the last commit in it.
        noted: What :func:`read` returned before that number was read.

    Returns:
        What is missing in the database; None if nothing is.
    """
    if noted is None:
        if last == 0:
            return None
        unknown = (
            f"the file {_path(database).name} beside it is missing: without that, it is not known whether the last"
            " writes are in it"
        )
        return Loss(database, (), 0, last, unknown=unknown)
    head, *others = noted
    missing = sorted((one for one in others if one is not None and one.number > last), key=lambda one: one.number)
    newest = max([last, *(one.number for one in noted if one is not None)])
    if newest == last:
        return None
    rebooted = head is not None and head.what != _boot() and bool(_boot())
    power_cut = rebooted and head is not None and head.number <= last
    return Loss(database, missing, newest - last, newest, power_cut)


def read(database: Path) -> Sequence[Commit | None] | None:
    """Returns the notes of a database: first how far it was synced; None for unused and damaged ones.

    Returns:
        The notes; None if there is no such file.

    Raises:
        OSError: The file cannot be read.
    """
    try:
        content = _path(database).read_bytes()
    except FileNotFoundError:
        return None
    return [_decoded(content[at : at + _SLOT]) for at in range(0, _SLOTS * _SLOT, _SLOT)]


def damaged(database: Path) -> int:
    """Returns the number of notes that are neither unused nor readable.

    Raises:
        OSError: The file cannot be read.
    """
    content = _path(database).read_bytes().ljust(_SLOTS * _SLOT, b"?")
    slots = [content[at : at + _SLOT] for at in range(0, len(content), _SLOT)]
    return sum(any(slot) and _decoded(slot) is None for slot in slots)


def unused(database: Path) -> bool:
    """Returns whether a file notes no commit at all: a kill came before its database got its name.

    Raises:
        OSError: The file cannot be read.
    """
    noted = read(database)
    return noted is not None and noted[0] is not None and not any(one.number for one in noted if one is not None)


def exists(database: Path) -> bool:
    """Returns whether a database has such a file."""
    return _path(database).exists()


def _path(database: Path) -> Path:
    return database.with_name(f"{database.name}{ENDING}")


def _boot() -> str:
    """Returns what identifies this start of the machine; empty if the system does not tell."""
    try:
        return _BOOT.read_text(encoding="ascii").strip()
    except OSError:
        return ""


_ROOM = _SLOT - _CHECKSUM - 40
"""Room for the words of a note, after number and time [bytes]."""


def listed(writes: Sequence[str]) -> str:
    """Returns the words of a commit that consists of several writes; says how many of them do not fit."""
    said = [one for one in writes if one]
    text = ", ".join(said)
    if len(said) < 2 or len(text.encode("utf-8", "replace")) <= _ROOM:
        return text
    text, fit = f"{len(said)} writes: ", 0
    for one in said:
        if len(f"{text}{one}, and {len(said)} more".encode("utf-8", "replace")) > _ROOM:
            break
        text, fit = f"{text}{one}, ", fit + 1
    return f"{text}and {len(said) - fit} more" if fit else text.rstrip(": ")


def _encoded(commit: Commit) -> bytes:
    text = f"{commit.number} {commit.wall:.3f} {commit.what}".encode("utf-8", "replace")
    body = text[: _SLOT - _CHECKSUM].ljust(_SLOT - _CHECKSUM, b"\0")
    return body + f"{zlib.crc32(body):08x}".encode()


def _decoded(slot: bytes) -> Commit | None:
    body, checksum = slot[:-_CHECKSUM], slot[-_CHECKSUM:]
    if f"{zlib.crc32(body):08x}".encode() != checksum:
        return None
    number, wall, what = body.rstrip(b"\0").decode("utf-8", "replace").split(" ", 2)
    return Commit(int(number), float(wall), what)
