"""How often somebody may do something."""

from __future__ import annotations

import time
from collections import OrderedDict
from collections.abc import Callable


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
