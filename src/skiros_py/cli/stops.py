"""Signals that ask the command to end: Ctrl-C, a polite kill, a closed terminal."""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from skiros_py.interruptions import UserStop

STOPS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


def raise_interrupt(_number: int, _frame: object) -> None:
    """Unwinds the stack, so that everything that was started is closed."""
    raise UserStop


def unwind_on_stops() -> None:
    """Makes every stop unwind the stack."""
    for number in STOPS:
        signal.signal(number, raise_interrupt)


def ignore_stops() -> None:
    """Lets the clean-up that is already under way come to its end."""
    for number in STOPS:
        signal.signal(number, signal.SIG_IGN)


@contextmanager
def heard_at_once(listener: Callable[[], None]) -> Iterator[None]:
    """Calls a function, in a thread of its own, for each stop: also while the main thread is in C and hears none."""
    reading, writing = os.pipe()
    os.set_blocking(writing, False)
    before = signal.set_wakeup_fd(writing, warn_on_full_buffer=False)
    thread = threading.Thread(target=_listen, args=(reading, listener), name="skiros-stops", daemon=True)
    thread.start()
    try:
        yield
    finally:
        signal.set_wakeup_fd(before)
        os.close(writing)
        thread.join()
        os.close(reading)


def _listen(reading: int, listener: Callable[[], None]) -> None:
    while numbers := os.read(reading, 1):
        if numbers[0] in STOPS:
            listener()
