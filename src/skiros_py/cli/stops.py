"""Signals that ask the command to end: Ctrl-C, a polite kill, a closed terminal."""

from __future__ import annotations

import signal

__all__ = ["STOPS", "ignore_stops", "raise_interrupt", "unwind_on_stops"]

STOPS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


def raise_interrupt(_number: int, _frame: object) -> None:
    """Unwinds the stack, so that everything that was started is closed."""
    raise KeyboardInterrupt


def unwind_on_stops() -> None:
    """Makes every stop unwind the stack."""
    for number in STOPS:
        signal.signal(number, raise_interrupt)


def ignore_stops() -> None:
    """Lets the clean-up that is already under way come to its end."""
    for number in STOPS:
        signal.signal(number, signal.SIG_IGN)
