"""Prevents a second process from using a data directory, and names the one that does."""

from __future__ import annotations

import fcntl
import json
import os
import sys
import time
from pathlib import Path

from skiros_py.errors import FileError


class DirectoryLock:
    """The right to use a folder, until :meth:`release` or the end of the process, however it ends.

    The kernel holds it, so leftovers of a killed process are no obstacle; the file names the holder for users.
    """

    def __init__(self, folder: Path) -> None:
        """Takes the lock.

        Raises:
            FileError: Somebody else has it, or the folder does not take the file.
        """
        path = folder / "lock"
        try:
            self._file: int | None = os.open(path, os.O_RDWR | os.O_CREAT, 0o644)
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
        """Lets others in; may be called twice."""
        file, self._file = self._file, None
        if file is not None:
            os.close(file)

    def _sign(self) -> None:
        assert self._file is not None
        since = time.strftime("%Y-%m-%d %H:%M:%S %z")
        text = json.dumps({"pid": os.getpid(), "command": _command(), "since": since})
        try:
            os.ftruncate(self._file, 0)
            os.pwrite(self._file, text.encode(), 0)
        except OSError:
            return  # a full disk: who is kept out learns less, and the lock holds all the same


def _command() -> str:
    name = Path(sys.argv[0] or sys.executable).name if sys.argv else "python"
    return " ".join([name, *sys.argv[1:]])[:200]


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
