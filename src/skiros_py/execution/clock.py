"""The clock of one task: the time of the run, less the time for which the task was paused."""

from __future__ import annotations

from typing import Protocol

_RAMP = 0.3
"""Time in which a clock slows down to standing still, and takes up speed again [s]."""


class Run(Protocol):
    """What gives the time of the run."""

    @property
    def now(self) -> float:
        """Time since the start of the run [s]."""
        ...


class RunClock:
    """Stands still while its task is paused, and gets there smoothly.

    A motion that is sampled at :attr:`now` therefore brakes along its own path and takes it up again where it left it.

    Args:
        run: Gives the time of the run.

    Attributes:
        rate: How fast it goes: 1 with the run, 0 standing still.
        lag: How far it is behind the run [s].
        steady: True while it goes with the run; then it needs no :meth:`advance`.
    """

    __slots__ = ("_now", "_run", "_wanted", "lag", "rate", "steady")

    def __init__(self, run: Run) -> None:
        self._run = run
        self._now = 0.0
        self.rate = 1.0
        self.lag = 0.0
        self.steady = True
        self._wanted = 1.0

    @property
    def now(self) -> float:
        """The task's own time [s]; the same as the run's for a task that never was paused."""
        return self._run.now - self.lag if self.steady else self._now

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
        self._now = self.now
        self._wanted = 0.0
        self.steady = False

    def speed_up(self) -> None:
        """Lets it go with the run again."""
        self._wanted = 1.0
        self.steady = self.rate == 1.0

    def advance(self) -> None:
        """Moves on to the time of the run, in each cycle in which it is not steady."""
        time = self._run.now
        elapsed = time - self.lag - self._now
        before, step = self.rate, elapsed / _RAMP
        self.rate = min(1.0, before + step) if self._wanted else max(0.0, before - step)
        self._now += elapsed * (before + self.rate) / 2.0
        self.lag = time - self._now
        self.steady = self.rate == self._wanted == 1.0

    def jump(self, seconds: float) -> None:
        """Moves on by so much while it stands: one step of a paused task."""
        self._now += seconds
        self.lag -= seconds
