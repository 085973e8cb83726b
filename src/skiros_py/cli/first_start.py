"""Rolls back a first start that fails: its data directory is removed."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import closing, contextmanager, suppress
from pathlib import Path

from skiros_py.errors import FileError, SkirosError

_OF_ACCESS = ("access.db", "access.db-wal", "access.db-shm")


@contextmanager
def rollback_first_start(data: Path) -> Iterator[None]:
    """Removes the data directory if the block created it and then failed.

    The world in it is discarded by its owner; files that others added meanwhile are kept.
    """
    made = [folder for folder in (data, *data.parents) if not folder.exists()]
    try:
        yield
    except SkirosError:
        if made:
            _remove(made)
        raise


def _remove(made: list[Path]) -> None:
    """Removes folders, the innermost first; what cannot be removed stays."""
    from skiros_py.world.journal.lock import DirectoryLock

    data = made[0]
    with suppress(OSError, FileError):  # FileError: somebody else uses it by now
        lock = DirectoryLock(data)
        try:
            if not _holds_more(data):
                for name in (*_OF_ACCESS, "lock"):
                    (data / name).unlink(missing_ok=True)
        finally:
            lock.release()
        for folder in made:
            folder.rmdir()


def _holds_more(data: Path) -> bool:
    """Returns whether there is more than a server makes before it opens its world."""
    from skiros_py.server.access.keys import KeyStore

    if {file.name for file in data.iterdir()} - {*_OF_ACCESS, "lock"}:
        return True
    with closing(KeyStore(data)) as keys:
        return bool(keys.all())
