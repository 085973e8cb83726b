"""Limits: how many requests, per time and at once, a caller or an unauthenticated network may make."""

from __future__ import annotations

import ipaddress
import time
from collections import Counter, OrderedDict
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from skiros_py.server.problems import Problem


def network_of(address: str) -> str:
    """Returns the key by which unauthenticated callers are counted: the address, or the network for IPv6."""
    try:
        number = ipaddress.ip_address(address)
    except ValueError:
        return address
    if isinstance(number, ipaddress.IPv4Address):
        return str(number)
    if number.ipv4_mapped is not None:
        return str(number.ipv4_mapped)
    return str(ipaddress.ip_network((int(number), 64), strict=False))


class Rates:
    """A token bucket for each of many callers; to be used in one thread.

    Existing rate limiters use the wall clock, so that setting it back by an hour locks all callers out for an hour, and
    start a thread every 10 ms while requests arrive, which would disturb a control cycle of 5 ms.

    Args:
        most: Number of permits in a full bucket.
        seconds: Time in which an empty bucket is refilled [s].
        people: Number of callers for whom buckets are kept; a new caller replaces the least recently seen one.
        clock: Returns the time [s]; monotonic.
    """

    def __init__(
        self, most: int, seconds: float, people: int = 10_000, clock: Callable[[], float] = time.monotonic
    ) -> None:
        self._most = most
        self._pace = most / seconds
        self._people = people
        self._clock = clock
        self._buckets: OrderedDict[str, tuple[float, float]] = OrderedDict()

    def take(self, who: str) -> bool:
        """Takes a permit; returns False if none is left."""
        left = self._left(who)
        self._buckets[who] = (left - 1 if left >= 1 else left, self._clock())
        self._buckets.move_to_end(who)
        if len(self._buckets) > self._people:
            self._buckets.popitem(last=False)
        return left >= 1

    def wait(self, who: str) -> float:
        """Returns the time until there is a permit [s]."""
        return max(0.0, (1 - self._left(who)) / self._pace)

    def _left(self, who: str) -> float:
        left, since = self._buckets.get(who, (float(self._most), 0.0))
        return min(self._most, left + (self._clock() - since) * self._pace)


_STRANGERS = 50
"""Maximum number of concurrent logins."""
_OF_ONE = 10
"""Maximum number of these from one address."""


class Load:
    """Counts requests in progress; to be used in the thread of the event loop only.

    Args:
        most: Maximum number of concurrent requests of authenticated callers.
    """

    def __init__(self, most: int) -> None:
        self._most = most
        self._under_way = 0
        self._strangers: Counter[str] = Counter()

    @contextmanager
    def known(self) -> Iterator[None]:
        """Counts a request of an authenticated caller for the duration of the block.

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
        """Counts a request of an unauthenticated caller for the duration of the block.

        Args:
            address: Address from which it comes.

        Raises:
            Problem: There are too many, in total or from this address (503).
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
