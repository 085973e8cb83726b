"""One change of a job at a time, and the control thread before everybody else."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager


class Guard:
    """Held by whoever changes a job, also while the disk is waited for.

    However many commands come at once, only one of them stands between the control cycle and its turn: the others
    wait before a door of their own. With one lock for all the cycle waited ten times as long.
    """

    def __init__(self) -> None:
        self._door = threading.Lock()
        self._room = threading.RLock()
        self._holder: int | None = None

    @contextmanager
    def command(self) -> Iterator[None]:
        """Lets a command change jobs while the block lasts; a listener may give one from within another."""
        if self._holder == threading.get_ident():
            yield
            return
        with self._door, self.control():
            yield

    @contextmanager
    def control(self) -> Iterator[None]:
        """Lets the control thread change jobs while the block lasts."""
        with self._room:
            outer, self._holder = self._holder, threading.get_ident()
            try:
                yield
            finally:
                self._holder = outer
