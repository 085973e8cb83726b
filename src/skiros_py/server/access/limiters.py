"""Limiters of requests, per time and at once, for each caller or network; their numbers are in `server/settings.py`."""

from __future__ import annotations

import ipaddress
import threading
import time
from collections import Counter, OrderedDict
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import lru_cache

from skiros_py.server.problems import Problem


@lru_cache(1024)
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


class Slots:
    """Limits how many things are in progress, in total and for each caller; thread-safe.

    Args:
        what: The things, in the plural.
        most: Maximum number in total.
        each: Maximum number of one caller.
        retry_after: When a refused caller may try again [s].
        refusal: HTTP status and code of the problem with which callers are refused.
    """

    def __init__(
        self, what: str, most: int, each: int, retry_after: float = 1.0, refusal: tuple[int, str] = (503, "Busy")
    ) -> None:
        self._what = what
        self._most = most
        self._each = each
        self._retry_after = retry_after
        self._refusal = refusal
        self._taken: Counter[str] = Counter()
        self._guard = threading.Lock()

    @property
    def taken(self) -> int:
        """Number of things in progress."""
        return self._taken.total()

    @contextmanager
    def take(self, who: str) -> Iterator[None]:
        """Takes a slot for the duration of the block.

        Raises:
            Problem: All slots are taken, or too many of them by this caller.
        """
        with self._guard:
            if self.taken >= self._most or self._taken[who] >= self._each:
                detail = f"too many {self._what} at a time: {self._most} in total, {self._each} of one caller"
                raise Problem(*self._refusal, detail, headers={"Retry-After": f"{self._retry_after:.0f}"})
            self._taken[who] += 1
        try:
            yield
        finally:
            with self._guard:
                self._taken[who] -= 1
                self._taken += Counter()  # removes callers without slots
