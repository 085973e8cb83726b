"""The port to planners, and their selection: the first that supports a task's requirements."""

from __future__ import annotations

import time
from collections.abc import Callable, Collection, Iterable, Iterator
from concurrent.futures import CancelledError, Future, wait
from dataclasses import dataclass
from threading import Lock
from typing import Generic, Protocol, Self, TypeVar

from skiros_py.errors import PlanningError, SkirosError
from skiros_py.ports.values import Pending

T = TypeVar("T")

_POLL = 0.005
"""Poll interval for cancellation; and for answers without a method ``wait`` [s]."""


@dataclass(frozen=True, slots=True)
class Solved:
    """A plan as the planner wrote it.

    Attributes:
        steps: For each step the action and its objects, in PDDL names, in the order in which they start.
        starts: Start time of each step [s]; empty if the planner has no notion of time.
        durations: Duration of each step [s]; empty if the planner has no notion of time.
    """

    steps: tuple[tuple[str, ...], ...]
    starts: tuple[float, ...] = ()
    durations: tuple[float, ...] = ()


@dataclass(frozen=True, slots=True)
class Unsolvable:
    """The planner says that no plan exists.

    Attributes:
        reason: The reason it gives, if any.
        proven: False if it gave up searching without a proof.
    """

    reason: str = ""
    proven: bool = True


Answer = Solved | Unsolvable


class FuturePending(Generic[T]):
    """A value that a thread computes; a :class:`~skiros_py.ports.values.Pending`.

    Args:
        future: The value.
        stop: Cancels the work; callable from any thread, also after the value has arrived.
        stopped: The message if it was cancelled.
    """

    latency = 0.0

    def __init__(self, future: Future[T], stop: Callable[[], object], stopped: str = "planning was stopped") -> None:
        self._future = future
        self._stop = stop
        self._stopped = stopped

    def done(self) -> bool:
        """Returns True when :meth:`result` will not block."""
        return self._future.done()

    def wait(self, seconds: float) -> None:
        """Waits until the value is available, but not longer than some time [s]."""
        wait((self._future,), seconds)

    def result(self) -> T:
        """Waits for the value.

        Raises:
            SkirosError: There is none: the work failed or was cancelled.
        """
        try:
            return self._future.result()
        except CancelledError:
            raise PlanningError(self._stopped) from None

    def cancel(self) -> None:
        """Cancels the work; does nothing if the value is available."""
        if not self._future.done():
            self._stop()
            self._future.cancel()


class Planner(Protocol):
    """Solves PDDL tasks.

    The planning process makes it once and calls :meth:`solve` in forked copies: threads are started there, not before.
    """

    @property
    def name(self) -> str:
        """Its display name."""

    @property
    def supports(self) -> frozenset[str]:
        """The PDDL requirements it supports: ":strips", ":typing", ":durative-actions", …."""

    def solve(self, domain: str, problem: str) -> Pending[Answer]:
        """Starts solving; several calls may be under way at once.

        The pending answer's ``result`` raises PlanningError when the planner fails. It may have two more methods:
        ``cancel()``, called when it is no longer needed, kills the running program; ``wait(seconds)`` returns when it
        has arrived or the time is over.
        """

    def close(self) -> None:
        """Kills running calls and waits for them."""


def wait_for(pending: Pending[Answer], check: Callable[[float], object]) -> Answer:
    """Waits for an answer; cancels it if it is no longer needed.

    Args:
        pending: The pending answer.
        check: Called every few milliseconds with the time waited so far [s]; raises if the answer is no longer needed.

    Raises:
        PlanningError: The planner failed.
    """
    started = time.monotonic()
    pause = getattr(pending, "wait", time.sleep)
    try:
        while not pending.done():
            check(time.monotonic() - started)
            pause(_POLL)
        return pending.result()
    finally:
        cancel = getattr(pending, "cancel", None)
        if cancel is not None:
            cancel()


PREFERRED = ("fast-downward", "kairos")
"""Tried before others, in this order: the first for classical tasks, the second for what the first does not support."""

_ADL = {
    ":typing", ":negative-preconditions", ":disjunctive-preconditions", ":equality", ":existential-preconditions",
    ":universal-preconditions", ":conditional-effects",
}  # fmt: skip
_MEANS: dict[str, set[str]] = {
    ":adl": _ADL,
    ":quantified-preconditions": {":existential-preconditions", ":universal-preconditions"},
    ":fluents": {":numeric-fluents"},
}
"""Requirements that stand for several others."""


def lacking(requirements: Iterable[str], supports: Iterable[str]) -> tuple[str, ...]:
    """Returns the requirements of a task that a planner does not support."""
    return tuple(sorted(_meant(requirements) - _meant(supports) - {":strips"}))


class Planners:
    """The available planners; each is created when first needed.

    Args:
        names: Their names.
        make: Creates one; if it raises, the error is recorded and the planner is unavailable.
        wanted: The only planner to use, if the user chose one.
    """

    def __init__(self, names: Iterable[str], make: Callable[[str], Planner], wanted: str | None = None) -> None:
        known = sorted(names)
        preferred = [name for name in PREFERRED if name in known]
        self._names = (wanted,) if wanted else (*preferred, *(name for name in known if name not in preferred))
        self._make = make
        self._made: dict[str, Planner] = {}
        self._broken: dict[str, str] = {}
        self._making = Lock()
        self.closed = False

    @classmethod
    def only(cls, planner: Planner) -> Self:
        """Returns a choice with a single planner."""
        return cls((planner.name,), lambda _name: planner, planner.name)

    def fitting(self, requirements: Collection[str]) -> Iterator[Planner]:
        """Yields the planners that support a task, in order of preference."""
        for name in self._names:
            planner = self._planner(name)
            if planner is not None and not lacking(requirements, planner.supports):
                yield planner

    def warm_up(self) -> None:
        """Creates the preferred planner, so that the first task need not wait for it."""
        for name in self._names[:1]:
            warm_up = getattr(self._planner(name), "warm_up", None)
            if warm_up is not None:
                warm_up()

    def why_none(self, requirements: Collection[str]) -> str:
        """Explains for each planner why it does not fit a task."""
        each = "; ".join(f"{name} {self._why_not(name, requirements)}" for name in self._names)
        return f"no planner takes {' '.join(requirements)}: {each or 'none is installed'}"

    def close(self) -> None:
        """Kills running calls and waits for them; may be called twice."""
        self.closed = True
        for planner in self._made.values():
            planner.close()

    def _planner(self, name: str) -> Planner | None:
        if self.closed:
            raise PlanningError("planning was stopped")
        with self._making:
            if name not in self._made and name not in self._broken:
                try:
                    self._made[name] = self._make(name)
                except SkirosError as error:
                    self._broken[name] = str(error)
        return self._made.get(name)

    def _why_not(self, name: str, requirements: Collection[str]) -> str:
        planner = self._planner(name)
        if planner is None:
            return f"is not there ({self._broken[name]})"
        return f"does not take {' '.join(lacking(requirements, planner.supports))}"


def _meant(requirements: Iterable[str]) -> set[str]:
    """Expands requirements that stand for several others."""
    given = set(requirements)
    return given.difference(_MEANS).union(*(_MEANS[word] for word in given if word in _MEANS))
