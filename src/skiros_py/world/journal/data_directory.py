"""A folder that stores a world: its journal, learned data, and a lock for the process that uses it."""

from __future__ import annotations

import fcntl
import json
import logging
import os
import sys
import time
from collections.abc import Sequence
from contextlib import AbstractContextManager, ExitStack
from pathlib import Path
from typing import Self

from skiros_py.database_file import delete
from skiros_py.errors import FileError
from skiros_py.files import open_private
from skiros_py.world.abstract import abstract_individuals
from skiros_py.world.journal.journal import Journal
from skiros_py.world.ontology import Ontology
from skiros_py.world.past import Past
from skiros_py.world.reasoners.registry import NO_REASONERS, Reasoners
from skiros_py.world.scene.files import load_scene
from skiros_py.world.scene.learned import LearnedFile
from skiros_py.world.world import World


class DirectoryLock:
    """The exclusive right to use a folder, until :meth:`release` or the end of the process, however it ends.

    The kernel holds the lock, so a killed process leaves none behind; the file names the holder for users.
    """

    def __init__(self, folder: Path) -> None:
        """Takes the lock.

        Raises:
            FileError: Another process has it, or the file cannot be written.
        """
        path = folder / "lock"
        try:
            self._file: int | None = open_private(os.fspath(path), os.O_RDWR | os.O_CREAT)
        except OSError as error:
            raise FileError(path, f"cannot be opened: {error.strerror}") from error
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            owner = _owner(self._file, folder)
            os.close(self._file)
            if not isinstance(error, BlockingIOError):
                raise FileError(path, f"cannot be locked: {error.strerror}") from error
            raise FileError(folder, f"is in use by {owner}: stop that first, or choose another folder") from None
        self._sign()

    def release(self) -> None:
        """Releases the lock; may be called twice."""
        file, self._file = self._file, None
        if file is not None:
            os.close(file)

    def _sign(self) -> None:
        assert self._file is not None
        since = time.strftime("%Y-%m-%d %H:%M:%S %z")
        command = " ".join([Path("".join(sys.argv[:1]) or sys.executable).name, *sys.argv[1:]])[:200]
        text = json.dumps({"pid": os.getpid(), "command": command, "since": since})
        try:
            os.ftruncate(self._file, 0)
            os.pwrite(self._file, text.encode(), 0)
        except OSError:
            return  # a full disk: the lock holds, but others do not see who has it


def _owner(file: int, folder: Path) -> str:
    try:
        said = json.loads(os.pread(file, 4096, 0))
        return f"process {said['pid']} ({said['command']}) since {said['since']}{_serving(folder, said['pid'])}"
    except (OSError, ValueError, KeyError, TypeError):
        return "another process"


def _serving(folder: Path, pid: int) -> str:
    """Returns the address of the server that holds the lock; empty if it is no server, or another user's."""
    try:
        said = json.loads((folder / "server.json").read_bytes())
        return f", which serves it at {said['url']}" if said["pid"] == pid else ""
    except (OSError, ValueError, KeyError, TypeError):
        return ""


_log = logging.getLogger(__name__)

_LONG = 20_000
"""Number of changes since the last snapshot after which opening makes a new one."""


class DataDirectory(AbstractContextManager["DataDirectory"]):
    """An open data directory. Close it, or use it in a ``with``.

    Attributes:
        path: The folder.
        world: The world stored in it.
        journal: Its changes, with queries on them.
    """

    def __init__(
        self, path: Path, world: World, journal: Journal, stack: ExitStack, made: tuple[Path, ...] | None
    ) -> None:
        """Made by :meth:`open`; ``made`` are the files, besides the journal, of a world that began with it."""
        self.path = path
        self.world = world
        self.journal = journal
        self._stack = stack
        self._made = made

    @classmethod
    def open(
        cls,
        path: Path,
        ontology: Ontology,
        reasoners: Reasoners = NO_REASONERS,
        scene: Path | None = None,
        *,
        imports: Sequence[Path] = (),
        create: bool = True,
    ) -> Self:
        """Opens a folder; creates it if there is none.

        Args:
            path: The folder.
            ontology: The ontology of its world.
            reasoners: The reasoners for computed relations in its world.
            scene: The scene file that is the first content of a new one; ignored for an existing one. The learned
                concepts in a file ``learned.ttl`` of the folder are added.
            imports: More files or folders in which the scene's imports are looked up.
            create: False to refuse a folder without a world.

        Raises:
            FileError: Another process uses it, it cannot be read or written, is damaged, or does not fit the ontology;
                or the scene is broken.
        """
        if not create and not (path / "journal.db").exists():
            raise FileError(path, "is no data directory: there is no journal.db in it")
        make_folder(path)
        stack = ExitStack()
        try:
            stack.callback(DirectoryLock(path).release)
            journal = Journal(path / "journal.db")
            stack.callback(journal.close)
            learned = LearnedFile(path / "learned.ttl")
            made: tuple[Path, ...] | None = None
            if journal.version == 0:
                made = () if learned.path.exists() else (learned.path,)
                fresh = World(ontology, reasoners=reasoners)
                if scene is not None:
                    fresh = load_scene(ontology, scene, imports, reasoners=reasoners)
                learned.read_into(fresh)
                journal.append_all(fresh.changes)  # one transaction
                past = Past(fresh.snapshot(), journal.ids(), journal)
            else:
                past = journal.past(abstract_individuals(ontology, reasoners))
            world = World(ontology, reasoners=reasoners, past=past)
            _shorten(journal, world)
            learned.follow(world)
            stack.callback(learned.close)
        except BaseException:
            stack.close()
            raise
        return cls(path, world, journal, stack, made)

    def compact(self, keep: int) -> None:
        """Deletes all but the latest changes: the file gets smaller, history and undo go back no further.

        Args:
            keep: How many changes are kept.

        Raises:
            FileError: There is no room for it; nothing was changed.
            UsageError: The number is negative.
        """
        self.journal.compact(self.world.snapshot(), keep=keep)

    def discard(self) -> None:
        """Closes it as if it had not been opened: a world created by opening it is deleted, an older one is kept."""
        self.journal.close()
        if self._made is not None:
            for file in self._made:
                file.unlink(missing_ok=True)
            delete(self.path / "journal.db")  # last: until then, the world is as it was
        self.close()

    def close(self) -> None:
        """Releases the folder; the world can still be read, but not written. May be called twice."""
        self._stack.close()

    def __exit__(self, *_: object) -> None:
        self.close()


def make_folder(path: Path) -> None:
    """Creates a data directory, or a folder in one, for its owner only; an existing one becomes private.

    Raises:
        FileError: It cannot be created, or is not a folder.
    """
    try:
        path.mkdir(0o700, parents=True, exist_ok=True)
        if path.stat().st_mode & 0o077:
            _make_private(path)
    except FileExistsError:
        raise FileError(path, "is not a folder, and one is needed here") from None
    except OSError as error:
        raise FileError(path, f"cannot be made: {error.strerror}") from error


DATABASES = ("journal.db", "jobs.db", "server.db", "access.db", "webhooks.db")
"""The databases of a data directory."""
FILES = ("learned.ttl", "halted.json", "scenes", "recordings", "runs")
"""Its other files and folders that outlive the process."""
BACKUPS = "backups"
"""Its folder with copies of it that a server made; no part of such a copy."""


def _make_private(folder: Path) -> None:
    """Makes a folder and its content private, unless it holds something else than a data directory."""
    own = (*DATABASES, *FILES, BACKUPS, "server.json", "lock", "models", ".learned.ttl.", ".halted.json.")
    if folder.name not in (*FILES, BACKUPS) and not all(file.name.startswith(own) for file in folder.iterdir()):
        _log.warning("%s holds other files, too: its permissions are left as they are, and others may look in", folder)
        return
    try:
        for file in (folder, *folder.rglob("*")):
            if not file.is_symlink():
                file.chmod(0o700 if file.is_dir() else 0o600)
    except OSError as error:
        _log.warning("%s: other users may look into this data directory: %s", folder, error.strerror)


def _shorten(journal: Journal, world: World) -> None:
    """Makes a snapshot so that the next opening is fast; on a full disk it stays slow."""
    if journal.since_snapshot <= _LONG:
        return
    try:
        journal.compact(world.snapshot())
    except FileError as error:
        _log.warning("no snapshot was made, opening takes longer and longer: %s", error)
