"""Cursors that are numbers."""

from __future__ import annotations

import re

from skiros_py.errors import UsageError

_NUMBER = re.compile(r"\d{1,18}", re.ASCII)


def number_cursor(cursor: str | None, first: int = 0) -> int:
    """Reads a cursor that is a number.

    Args:
        cursor: The cursor.
        first: What it is for the first page.

    Raises:
        UsageError: It is none of ours.
    """
    if cursor is None:
        return first
    if not _NUMBER.fullmatch(cursor):
        raise UsageError(f"'{cursor[:50]}' is no cursor of this list: give 'next' of the page before, as it is")
    return int(cursor)
