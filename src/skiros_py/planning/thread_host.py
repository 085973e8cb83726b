"""Planning in threads of this process: for tests, and if nothing else needs the interpreter meanwhile."""

from __future__ import annotations

import ctypes
import time
from concurrent.futures import ThreadPoolExecutor
from threading import Event, Lock, Timer, get_ident
from typing import TypeVar

from skiros_py.errors import PlanningError
from skiros_py.interruptions import Interruption
from skiros_py.planning.planners.choosing import Planners
from skiros_py.planning.planners.planner import Planner
from skiros_py.planning.requests import Answer, Asked, Request, answered
from skiros_py.world.world import World

T = TypeVar("T")

_PATIENCE = 1.0
"""How long cancelled work may continue before it is interrupted: a user-defined condition may hang [s]."""


class _Stopped(Interruption):
    """Raised in a thread whose cancelled work does not stop."""


class ThreadHost:
    """Answers requests in threads.

    Args:
        world: The world that requests refer to.
        planners: The planner that solves the PDDL, or several to choose from. They are not closed.
    """

    def __init__(self, world: World, planners: Planner | Planners) -> None:
        self._world = world
        self._planners = planners if isinstance(planners, Planners) else Planners.only(planners)
        self._threads = ThreadPoolExecutor(thread_name_prefix="skiros-planning")
        self._closed = Event()
        self._lock = Lock()
        self._working: dict[int, Event] = {}

    def ask(self, request: Request[T]) -> Asked[T]:
        """Submits a request about the current world.

        Raises:
            PlanningError: It was closed.
        """
        stop = Event()
        version, state = self._world.state()

        def work() -> Answer[T]:
            with self._lock:
                self._working[get_ident()] = stop
            try:
                value = answered(request, state, self._planners, lambda: stop.is_set() or self._closed.is_set())
                return Answer(version, value)
            except _Stopped:
                raise PlanningError("planning was stopped") from None
            finally:
                with self._lock:
                    del self._working[get_ident()]
                    _raise_in(get_ident(), None)

        try:
            return Asked(self._threads.submit(work), lambda: self._end(stop))
        except RuntimeError:
            raise PlanningError("planning was stopped") from None

    def _end(self, stop: Event) -> None:
        """Cancels one request; work that does not poll for cancellation is interrupted soon after."""
        stop.set()
        timer = Timer(_PATIENCE, self._interrupt, (stop,))
        timer.daemon = True
        timer.start()

    def _interrupt(self, stop: Event | None = None) -> None:
        with self._lock:
            for thread, other in self._working.items():
                if stop is None or other is stop:
                    _raise_in(thread, _Stopped)

    def close(self) -> None:
        """Cancels all pending requests."""
        self._closed.set()
        self._threads.shutdown(wait=False, cancel_futures=True)
        end = time.monotonic() + _PATIENCE
        while self._working and time.monotonic() < end:
            time.sleep(0.005)
        self._interrupt()
        self._threads.shutdown(wait=True)


def _raise_in(thread: int, kind: type[BaseException] | None) -> None:
    """Raises an exception in a thread at its next Python instruction; None revokes one that has not been raised yet."""
    exception = None if kind is None else ctypes.py_object(kind)
    ctypes.pythonapi.PyThreadState_SetAsyncExc(ctypes.c_ulong(thread), exception)
