"""Limits: how often and how much at once a caller, or a stranger's network, may ask."""

from __future__ import annotations

import ipaddress
import time
from collections import Counter, OrderedDict
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from skiros_py.server.problems import Problem


def network_of(address: str) -> str:
    """Returns what tells one stranger from another: the address, or of IPv6, where everybody has many, the network."""
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
    """A bucket of permits for each of many people, filled again as time passes; for one thread.

    The rate limiters that exist go by the wall clock, so that a clock put back an hour locks everybody out for an hour,
    and start a thread each 10 ms while requests come, which a control cycle of 5 ms can do without.

    Args:
        most: How many permits a bucket holds.
        seconds: In what time an empty bucket is full again [s].
        people: For how many people buckets are kept; a newcomer replaces the one seen longest ago.
        clock: Gives the time [s]; never goes back.
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
        """Takes a permit; False where there is none left."""
        left = self._left(who)
        self._buckets[who] = (left - 1 if left >= 1 else left, self._clock())
        self._buckets.move_to_end(who)
        if len(self._buckets) > self._people:
            self._buckets.popitem(last=False)
        return left >= 1

    def wait(self, who: str) -> float:
        """Returns how long it takes until there is a permit [s]."""
        return max(0.0, (1 - self._left(who)) / self._pace)

    def _left(self, who: str) -> float:
        left, since = self._buckets.get(who, (float(self._most), 0.0))
        return min(self._most, left + (self._clock() - since) * self._pace)


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
