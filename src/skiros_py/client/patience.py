"""When a call is retried: the connection broke, or the server is overloaded."""

from __future__ import annotations

from collections.abc import AsyncIterator, Iterator
from dataclasses import dataclass
from typing import Any, Protocol

import httpx2
import stamina

from skiros_py.client.call import Call
from skiros_py.client.errors import ProblemError, Unreachable
from skiros_py.errors import UsageError

_FIRST, _LONGEST = 0.1, 5.0
"""First and longest wait between two attempts [s]."""
_APART = 0.1
"""Maximum random time added to each wait [s]: keeps many clients from retrying at the same moment."""
_LONGEST_ASKED = 30.0
"""If the server asks for a longer wait [s], the error is raised to the caller instead."""
_TOO_MANY_REQUESTS, _UNAVAILABLE = 429, 503


class Attempts(Protocol):
    """The attempts at one call, for ``for`` and ``async for``: each is a ``with`` block; success ends the loop."""

    def __iter__(self) -> Iterator[stamina.Attempt]:
        """Yields the attempts, and waits between them."""
        ...

    def __aiter__(self) -> AsyncIterator[stamina.Attempt]:
        """Yields the attempts, and awaits between them."""
        ...


@dataclass(frozen=True, slots=True)
class Patience:
    """How often, and after which waits, a call is retried.

    Attributes:
        tries: How often it is sent at most.
    """

    tries: int = 6

    def __post_init__(self) -> None:
        if self.tries < 1:
            raise UsageError(f"tries: 1 or more, not {self.tries}")

    def attempts(self, call: Call[Any]) -> Attempts:
        """Returns the attempts at a call; the last one raises the error."""
        return stamina.retry_context(
            on=lambda error: wait_after(error, call),
            attempts=self.tries,
            timeout=None,
            wait_initial=_FIRST,
            wait_max=_LONGEST,
            wait_jitter=_APART,
        )


def wait_after(error: Exception, call: Call[Any]) -> bool | float:
    """Returns whether a call is sent again: True after the usual wait, False for no, a number to wait that long [s].

    Args:
        error: The error of the last attempt.
        call: The call.
    """
    if isinstance(error, ProblemError):
        return _asked_wait(error, call)
    if not isinstance(error, Unreachable):
        return False
    broken = error.__cause__
    # A request that never reached the server had no effect: it may always be sent again.
    never_arrived = isinstance(broken, httpx2.ConnectError | httpx2.ConnectTimeout | httpx2.PoolTimeout)
    return (call.repeatable or never_arrived) and not isinstance(broken, httpx2.UnsupportedProtocol)


def _asked_wait(problem: ProblemError, call: Call[Any]) -> bool | float:
    """Returns the wait the server asks for [s]; False if there is none, or it is too long."""
    refused = problem.status == _TOO_MANY_REQUESTS  # the request had no effect
    if not refused and not (call.repeatable and problem.status == _UNAVAILABLE):
        return False
    seconds = problem.retry_after
    return False if seconds is None or seconds > _LONGEST_ASKED else seconds
