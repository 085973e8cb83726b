"""Serializes changes of jobs, with priority for the control thread."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager


class Guard:
    """The lock held while a job is changed.

    A command waits for the disk after releasing it; the control thread does so in lockstep only.

    Regardless of the number of concurrent commands, the control cycle waits for at most one of them: the others wait
    on a second lock. With a single lock the cycle waited ten times as long.

    Args:
        flush: Waits for the disk.
        lockstep: True if simulated time stands still meanwhile.
    """

    def __init__(self, flush: Callable[[], None], *, lockstep: bool) -> None:
        self._flush = flush
        self._lockstep = lockstep
        self._door = threading.Lock()
        self._room = threading.RLock()
        self._holder: int | None = None

    @contextmanager
    def command(self) -> Iterator[None]:
        """Holds the lock for a command; reentrant, since listeners may issue commands."""
        if self._holder == threading.get_ident():
            yield
            return
        with self._door, self._inside():
            yield
        self._flush()

    @contextmanager
    def control(self) -> Iterator[None]:
        """Holds the lock for the control thread."""
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
