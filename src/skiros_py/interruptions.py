"""What ends code from outside: no faults, and not for authors to catch."""

from __future__ import annotations

import signal


class Interruption(BaseException):
    """The platform breaks off what runs, such as code that holds the control cycle."""


class UserStop(KeyboardInterrupt):
    """The user asks the command to end: what its handlers of signals raise."""


def by_user(error: BaseException) -> bool:
    """Tells whether an exception is the user's wish to end; where nobody handles Ctrl-C, each interrupt may be."""
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        return isinstance(error, KeyboardInterrupt)
    return isinstance(error, UserStop)
