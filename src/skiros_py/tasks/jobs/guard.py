"""One change of a job at a time, and the control thread before everybody else."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager


class Guard:
    """Held by whoever changes a job.

    A command waits for the disk when it holds it no longer; the control thread does so in lockstep only.

    However many commands come at once, only one of them stands between the control cycle and its turn: the others
    wait before a door of their own. With one lock for all the cycle waited ten times as long.

    Args:
        flush: Waits for the disk.
        lockstep: True where simulated time stands still meanwhile.
    """

    def __init__(self, flush: Callable[[], None], *, lockstep: bool) -> None:
        self._flush = flush
        self._lockstep = lockstep
        self._door = threading.Lock()
        self._room = threading.RLock()
        self._holder: int | None = None

    @contextmanager
    def command(self) -> Iterator[None]:
        """Lets a command change jobs while the block lasts; a listener may give one from within another."""
        if self._holder == threading.get_ident():
            yield
            return
        with self._door, self._inside():
            yield
        self._flush()

    @contextmanager
    def control(self) -> Iterator[None]:
        """Lets the control thread change jobs while the block lasts."""
        with self._inside():
            yield
        if self._lockstep:
            self._flush()

    @contextmanager
    def _inside(self) -> Iterator[None]:
        with self._room:
            outer, self._holder = self._holder, threading.get_ident()
            try:
                yield
            finally:
                self._holder = outer
