"""An answer that is on its way from a worker process or a device."""

from __future__ import annotations

from typing import Protocol, TypeVar

T = TypeVar("T")
T_co = TypeVar("T_co", covariant=True)


class Pending(Protocol[T_co]):
    """A value that arrives later.

    In lockstep the simulated time between request and use is ``latency``, however long the worker really took: a run is
    a function of its seed.

    Attributes:
        latency: Declared time from request to answer [s].
    """

    @property
    def latency(self) -> float:
        """Declared time from request to answer [s]."""
        ...

    def done(self) -> bool:
        """Returns True when :meth:`result` will not block."""
        ...

    def result(self) -> T_co:
        """Waits for the answer and returns it.

        Raises:
            DeviceError: The worker died or broke.
        """
        ...


class Done(Pending[T]):
    """An answer that is already there."""

    def __init__(self, value: T, latency: float = 0.0) -> None:
        self._value = value
        self._latency = latency

    @property
    def latency(self) -> float:
        """Declared time from request to answer [s]."""
        return self._latency

    def done(self) -> bool:
        """Returns True."""
        return True

    def result(self) -> T:
        """Returns the value."""
        return self._value
