"""Writes a file atomically: it is either complete or unchanged."""

from __future__ import annotations

import os
import secrets
import stat
from pathlib import Path

from skiros_py.errors import FileError


def write_atomically(path: Path, text: str) -> None:
    """Writes a text file such that after a crash or power loss either the new or the old one is complete.

    The permissions of the old file are kept; a symbolic link still points to the written file.

    Raises:
        FileError: It cannot be written; the old file is unchanged.
    """
    try:
        _replace(Path(os.path.realpath(path)), text.encode())
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise FileError(path, f"cannot be written ({reason}); nothing was changed") from error
    try:
        _flush_folder(Path(os.path.realpath(path)).parent)
    except OSError as error:
        raise FileError(path, f"is written, but may not survive a power cut ({error.strerror})") from error


def _replace(path: Path, content: bytes) -> None:
    new = path.with_name(f".{path.name[:40]}.{secrets.token_hex(4)}.tmp")
    try:
        _write(new, content)
        if path.exists():
            new.chmod(stat.S_IMODE(path.stat().st_mode))
        new.replace(path)
    except BaseException:
        new.unlink(missing_ok=True)
        raise


def _write(path: Path, content: bytes) -> None:
    with path.open("xb") as file:
        file.write(content)
        file.flush()
        os.fsync(file.fileno())


def _flush_folder(folder: Path) -> None:
    """Makes the new directory entry durable, not only the contents."""
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
