"""When a call is sent once more: the connection broke, or the server has too much to do."""

from __future__ import annotations

import random
from dataclasses import dataclass
from typing import Any, TypeAlias

import httpx2

from skiros_py.client.call import Call
from skiros_py.errors import UsageError

__all__ = ["Outcome", "Patience"]

Outcome: TypeAlias = httpx2.Response | httpx2.TransportError
"""What comes of sending a request: an answer, or a broken connection."""

_FIRST, _LONGEST = 0.1, 5.0
"""The waits between two tries grow from the one to the other [s]."""
_LONGEST_ASKED = 30.0
"""Who is asked to wait for longer than that [s] tells the caller instead."""
_LONGEST_TEXT = 5
_TOO_MANY_REQUESTS, _UNAVAILABLE = 429, 503


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

    def wait_after(self, outcome: Outcome, call: Call[Any], sent: int) -> float | None:
        """Returns after which time a call is sent again [s]; None where it is not.

        Args:
            outcome: What came of the last try.
            call: What was sent.
            sent: How often.
        """
        if sent >= self.tries:
            return None
        if isinstance(outcome, httpx2.Response):
            return _asked_wait(outcome, call)
        # What never reached the server was not done: that may be sent again whatever it is.
        never_arrived = isinstance(outcome, httpx2.ConnectError | httpx2.ConnectTimeout | httpx2.PoolTimeout)
        if not (call.repeatable or never_arrived) or isinstance(outcome, httpx2.UnsupportedProtocol):
            return None
        longest = min(_LONGEST, _FIRST * 2.0 ** (sent - 1))
        return random.uniform(0.5, 1.0) * longest  # noqa: S311 - keeps many clients from coming back together


def _asked_wait(response: httpx2.Response, call: Call[Any]) -> float | None:
    """Returns the wait that the server asks for [s]; None where it did not, or for longer than anybody waits."""
    refused = response.status_code == _TOO_MANY_REQUESTS  # nothing was done
    if not refused and not (call.repeatable and response.status_code == _UNAVAILABLE):
        return None
    text = response.headers.get("retry-after", "").strip()
    if not (text.isascii() and text.isdecimal() and len(text) <= _LONGEST_TEXT):
        return None
    seconds = float(text)
    return seconds if seconds <= _LONGEST_ASKED else None
