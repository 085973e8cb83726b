"""Exceptions that end code from outside: they are no faults, and authors must not catch them."""

from __future__ import annotations

import ctypes
import signal
from threading import get_ident


class Interruption(BaseException):
    """The platform cancels what runs, such as code that holds the control cycle."""


class UserStop(KeyboardInterrupt):
    """The user asks the command to end: what its handlers of signals raise."""


def by_user(error: BaseException) -> bool:
    """Tells whether an exception comes from the user; without a handler of Ctrl-C, each interrupt counts."""
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        return isinstance(error, KeyboardInterrupt)
    return isinstance(error, UserStop)


def raise_in(thread: int, kind: type[BaseException]) -> None:
    """Raises an exception in a thread, at one of its next Python instructions."""
    ctypes.pythonapi.PyThreadState_SetAsyncExc(ctypes.c_ulong(thread), ctypes.py_object(kind))


def take_back(kind: type[BaseException]) -> None:
    """Takes back an exception of :func:`raise_in` that has not been raised yet in the current thread.

    It is replaced by one that is raised and caught here: taken back in C, it would leave CPython 3.11's evaluation loop
    checking for it forever, and a program that is profiled would never go on.
    """
    try:
        raise_in(get_ident(), kind)
        while True:
            pass
    except kind:
        pass
