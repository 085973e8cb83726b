"""Errors in authors' code, turned into failures with a text for people."""

from __future__ import annotations

import logging
from collections.abc import Callable
from typing import TypeVar

from skiros_py.errors import DeviceError, SkirosError
from skiros_py.interruptions import CycleOverrun, not_the_authors
from skiros_py.messages import Message, joined
from skiros_py.skills.outcome import BROKEN, DEVICE_FAILED, Failure

T = TypeVar("T")

_log = logging.getLogger(__name__)


def contained(what: str, action: Callable[[], T]) -> T | Failure:
    """Returns what an action returns, or the failure that it is when it raises.

    A refusal of the platform (an unknown name, a locked element) is an ordinary failure, anything else a mistake in the
    author's code.

    Args:
        what: Whose action it is.
        action: What is called.

    Raises:
        KeyboardInterrupt: It is the user's.
        Interruption: It is the platform's.
    """
    try:
        return action()
    except SkirosError as error:
        return Failure(joined(": ", (what, joined("", (str(error), _where(error))))))
    except BaseException as error:  # an author's mistake ends what it is part of, not the platform
        if not_the_authors(error):
            raise
        return broken(what, error)


def broken(what: str, error: BaseException, origin: str = "") -> Failure:
    """Logs an error in an author's code, or of a device that it uses, and returns it as a failure.

    Args:
        what: What broke.
        error: What was raised.
        origin: Where its code is from.
    """
    if isinstance(error, DeviceError):
        _log.warning("%s: %s", what, error)
        return Failure(joined(": ", (what, str(error))), DEVICE_FAILED, {"cause": "device"})
    _log.error("%s%s broke", what, f", {origin}," if origin else "", exc_info=error)
    return Failure(Message("{what} broke: {error}", what=what, error=words(error)), BROKEN)


def words(error: BaseException) -> str:
    """Describes in words how an author's code ended."""
    if isinstance(error, SystemExit):
        return Message(
            "it tried to end the program: sys.exit({code}){where}", code=repr(error.code), where=_where(error)
        )
    return f"{type(error).__name__}: {error}{_where(error)}"


def _where(error: BaseException) -> str:
    notes = getattr(error, "__notes__", ())
    return f" ({'; '.join(notes)})" if notes else ""


def off_words(error: BaseException) -> str:
    """Describes in words why a part of a plug-in is switched off: what it raised, or that it held the cycle."""
    return (
        str(error)
        if isinstance(error, CycleOverrun)
        else Message("it raised {name}: {error}", name=type(error).__name__, error=error)
    )
