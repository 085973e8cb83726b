"""Exceptions that end code from outside: they are no faults, and authors must not catch them."""

from __future__ import annotations

import signal


class Interruption(BaseException):
    """The platform cancels what runs, such as code that holds the control cycle."""


class UserStop(KeyboardInterrupt):
    """The user asks the command to end: what its handlers of signals raise."""


def by_user(error: BaseException) -> bool:
    """Tells whether an exception comes from the user; without a handler of Ctrl-C, each interrupt counts."""
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        return isinstance(error, KeyboardInterrupt)
    return isinstance(error, UserStop)
