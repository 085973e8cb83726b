"""Lets programs of the same user find the server: it announces itself in its data directory while it listens."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from skiros_py.api.local import SERVER_FILE, LocalServer
from skiros_py.errors import FileError


@contextmanager
def announced(data: Path, url: str, token: str) -> Iterator[LocalServer]:
    """Announces the server of a data directory for the duration of the block.

    Args:
        data: The data directory; the caller holds its lock.
        url: Address of the server.
        token: The key that programs of the same user may use until the server ends.

    Raises:
        FileError: The announcement cannot be written.
    """
    server = LocalServer(url=url, pid=os.getpid(), token=token)
    path = data / SERVER_FILE
    try:
        _write(path, server.model_dump_json())
    except OSError as error:
        raise FileError(path, f"cannot be written: {error.strerror}") from error
    try:
        yield server
    finally:
        with suppress(OSError):  # a leftover announcement is recognised by the free lock
            path.unlink()


def _write(path: Path, text: str) -> None:
    """Writes a file atomically, and so that other users can never read it."""
    new = path.with_name(f"{path.name}.new")
    new.unlink(missing_ok=True)  # a leftover file may be readable for others
    with open(os.open(new, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "w", encoding="utf-8") as file:  # noqa: PTH123
        file.write(text)
    new.replace(path)
