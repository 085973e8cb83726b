"""The clock of one task: the time of the run, less the time for which the task was paused."""

from __future__ import annotations

_RAMP = 0.3
"""Time in which a clock slows down to standing still, and takes up speed again [s]."""


class RunClock:
    """Stands still while its task is paused, and gets there smoothly.

    A motion that is sampled at :attr:`now` therefore brakes along its own path and takes it up again where it left it.

    Args:
        time: Time of the run now [s].

    Attributes:
        now: The task's own time [s]; the same as the run's for a task that never was paused.
        rate: How fast it goes: 1 with the run, 0 standing still.
        lag: How far it is behind the run [s].
        steady: True while it goes with the run and nothing else is wanted of it.
    """

    __slots__ = ("_wanted", "lag", "now", "rate", "steady")

    def __init__(self, time: float = 0.0) -> None:
        self.now = time
        self.rate = 1.0
        self.lag = 0.0
        self.steady = True
        self._wanted = 1.0

    @property
    def stands(self) -> bool:
        """True when it stands still and shall stay so."""
        return self.rate == self._wanted == 0.0

    @property
    def slowing(self) -> bool:
        """True when it stands still, or is on its way there."""
        return self._wanted == 0.0

    def slow_down(self) -> None:
        """Lets it come to a standstill."""
        self._wanted = 0.0
        self.steady = False

    def speed_up(self) -> None:
        """Lets it go with the run again."""
        self._wanted = 1.0
        self.steady = self.rate == 1.0

    def advance(self, time: float) -> None:
        """Moves on to a time of the run, each cycle.

        Args:
            time: Time of the run [s].
        """
        if self.steady:
            self.now = time - self.lag
            return
        self._ramp(time - self.lag - self.now)
        self.lag = time - self.now
        self.steady = self.rate == self._wanted == 1.0

    def jump(self, seconds: float) -> None:
        """Moves on by so much while it stands: one step of a paused task."""
        self.now += seconds
        self.lag -= seconds

    def _ramp(self, elapsed: float) -> None:
        before, step = self.rate, elapsed / _RAMP
        self.rate = min(1.0, before + step) if self._wanted else max(0.0, before - step)
        self.now += elapsed * (before + self.rate) / 2.0
