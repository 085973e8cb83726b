"""When a call is sent once more: the connection broke, or the server has too much to do."""

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
"""The waits between two tries grow from the one to the other [s]."""
_APART = 0.1
"""A random time that is added to each [s]: it keeps many clients from coming back together."""
_LONGEST_ASKED = 30.0
"""Who is asked to wait for longer than that [s] tells the caller instead."""
_TOO_MANY_REQUESTS, _UNAVAILABLE = 429, 503


class Attempts(Protocol):
    """The tries of one call, for ``for`` and ``async for``: each is a ``with`` that ends the loop where it succeeds."""

    def __iter__(self) -> Iterator[stamina.Attempt]:
        """Yields the tries, and waits between them."""
        ...

    def __aiter__(self) -> AsyncIterator[stamina.Attempt]:
        """Yields the tries, and lets others run between them."""
        ...


@dataclass(frozen=True, slots=True)
class Patience:
    """How often, and after which waits, a call is sent again.

    Attributes:
        tries: How often it is sent at most.
    """

    tries: int = 6

    def __post_init__(self) -> None:
        if self.tries < 1:
            raise UsageError(f"tries: 1 or more, not {self.tries}")

    def attempts(self, call: Call[Any]) -> Attempts:
        """Returns the tries of a call; the last one raises what went wrong."""
        return stamina.retry_context(
            on=lambda error: wait_after(error, call),
            attempts=self.tries,
            timeout=None,
            wait_initial=_FIRST,
            wait_max=_LONGEST,
            wait_jitter=_APART,
        )


def wait_after(error: Exception, call: Call[Any]) -> bool | float:
    """Returns whether a call is sent again: True after the usual wait, False for not, a number after so long [s].

    Args:
        error: What came of the last try.
        call: What was sent.
    """
    if isinstance(error, ProblemError):
        return _asked_wait(error, call)
    if not isinstance(error, Unreachable):
        return False
    broken = error.__cause__
    # What never reached the server was not done: that may be sent again whatever it is.
    never_arrived = isinstance(broken, httpx2.ConnectError | httpx2.ConnectTimeout | httpx2.PoolTimeout)
    return (call.repeatable or never_arrived) and not isinstance(broken, httpx2.UnsupportedProtocol)


def _asked_wait(problem: ProblemError, call: Call[Any]) -> bool | float:
    """Returns the wait that the server asks for [s]; False if it did not, or for longer than anybody waits."""
    refused = problem.status == _TOO_MANY_REQUESTS  # nothing was done
    if not refused and not (call.repeatable and problem.status == _UNAVAILABLE):
        return False
    seconds = problem.retry_after
    return False if seconds is None or seconds > _LONGEST_ASKED else seconds
