"""The folder with the replays: so many and so large at most; the oldest go."""

from __future__ import annotations

import logging
from collections.abc import Collection
from pathlib import Path

__all__ = ["MOST", "ROOM", "ReplayShelf"]

_log = logging.getLogger(__name__)

MOST = 200
"""Replays that are kept."""
ROOM = 200 * 1024 * 1024
"""Bytes that all of them take at most."""
_SUFFIX = ".replay"


class ReplayShelf:
    """Files by the numbers of jobs, which are never given twice.

    Args:
        folder: Made when there is something to keep.
        most: How many are kept.
        room: Bytes that they take at most.
    """

    def __init__(self, folder: Path, most: int = MOST, room: int = ROOM) -> None:
        self.most = most
        self.room = room
        self._folder = folder

    def path(self, number: int) -> Path:
        """Returns where the replay of a job is, or would be."""
        return self._folder / f"{number:09d}{_SUFFIX}"

    def prepare(self) -> None:
        """Makes the folder.

        Raises:
            OSError: It cannot be made.
        """
        self._folder.mkdir(parents=True, exist_ok=True)

    def remove(self, number: int) -> None:
        """Removes a replay; where there is none, nothing happens."""
        try:
            self.path(number).unlink(missing_ok=True)
        except OSError as error:
            _log.warning("a replay cannot be removed: %s", error)

    def make_room(self, staying: Collection[int]) -> None:
        """Removes the oldest until there are few and small enough.

        Args:
            staying: Numbers of jobs whose replays are being written.
        """
        files = sorted(file for file in self._folder.glob(f"*{_SUFFIX}") if file.stem.isdecimal())  # else not ours
        sizes = {int(file.stem): file.stat().st_size for file in files}
        for number in tuple(sizes):
            if len(sizes) <= self.most and sum(sizes.values()) <= self.room:
                return
            if number not in staying:
                self.remove(number)
                del sizes[number]
