"""How much is under way at the same time: what those do who were let in, and, apart from it, what strangers do."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager

from skiros_py.server.access.networks import network_of
from skiros_py.server.problems import Problem

_STRANGERS = 50
"""Logins that may be under way at the same time."""
_OF_ONE = 10
"""How many of these one address may have."""


class Load:
    """Counts requests that are under way; for the thread of the event loop.

    Args:
        most: How many may be under way of those who were let in.
    """

    def __init__(self, most: int) -> None:
        self._most = most
        self._under_way = 0
        self._strangers: Counter[str] = Counter()

    @contextmanager
    def known(self) -> Iterator[None]:
        """Counts a request of somebody who was let in, while the block lasts.

        Raises:
            Problem: There are too many (503).
        """
        if self._under_way >= self._most:
            raise _busy("too many requests are under way")
        self._under_way += 1
        try:
            yield
        finally:
            self._under_way -= 1

    @contextmanager
    def stranger(self, address: str) -> Iterator[None]:
        """Counts a request of somebody who is not known yet, while the block lasts.

        Args:
            address: Where it comes from.

        Raises:
            Problem: There are too many, all together or from there (503).
        """
        who = network_of(address)
        if self._strangers.total() >= _STRANGERS or self._strangers[who] >= _OF_ONE:
            raise _busy("too many logins are under way")
        self._strangers[who] += 1
        try:
            yield
        finally:
            self._strangers[who] -= 1
            if not self._strangers[who]:
                del self._strangers[who]


def _busy(detail: str) -> Problem:
    return Problem(503, "Busy", detail, headers={"Retry-After": "1"})
