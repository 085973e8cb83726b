"""The file of one replay: lines, compressed piece by piece, so that what a crash leaves is a readable beginning."""

from __future__ import annotations

import enum
import gzip
import zlib
from collections.abc import Iterable
from pathlib import Path

__all__ = ["Kind", "Line", "add_lines", "mend", "read_lines"]

_GZIP = 16 + zlib.MAX_WBITS
_LEVEL = 6


class Kind(enum.StrEnum):
    """What a line says; the rest of it is JSON."""

    BEGINNING = "B"
    """A part begins: a job that was held has several."""
    VIEW = "V"
    """The whole world as it looks then."""
    FRAMES = "F"
    """Snapshots of the devices."""
    CHANGE = "C"
    """Something looks different."""
    FULL = "X"
    """What comes now is too much to be kept."""
    END = "E"
    """The part ended in good order."""


Line = tuple[Kind, bytes]


def add_lines(path: Path, lines: Iterable[Line]) -> int:
    """Adds lines to a file, all or none of them; made where it is missing.

    Returns:
        How many bytes that took.

    Raises:
        OSError: It cannot be written.
    """
    piece = gzip.compress(b"".join(kind.encode() + text + b"\n" for kind, text in lines), _LEVEL, mtime=0)
    with path.open("ab") as file:
        file.write(piece)
    return len(piece)


def read_lines(path: Path) -> list[Line]:
    """Returns the lines of a file, as far as they are whole.

    Raises:
        OSError: It cannot be read.
    """
    return _pieces(path.read_bytes())[0]


def mend(path: Path) -> None:
    """Takes away what a crash left of the last piece, so that others can follow.

    Raises:
        OSError: The file cannot be read or written.
    """
    data = path.read_bytes()
    whole = _pieces(data)[1]
    if whole < len(data):
        with path.open("r+b") as file:
            file.truncate(whole)


def _pieces(data: bytes) -> tuple[list[Line], int]:
    """Returns the lines of whole pieces, and where the last of them ends."""
    lines: list[Line] = []
    rest, whole = data, 0
    while rest:
        unpacking = zlib.decompressobj(_GZIP)
        try:
            text = unpacking.decompress(rest)
            lines += [(Kind(chr(line[0])), line[1:]) for line in text.splitlines()] if unpacking.eof else ()
        except (zlib.error, ValueError, IndexError):
            break
        if not unpacking.eof:
            break
        rest = unpacking.unused_data
        whole = len(data) - len(rest)
    return lines, whole
