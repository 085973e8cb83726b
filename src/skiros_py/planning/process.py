"""Client side of planning: in a separate process, or in threads of this one.

The control thread only posts requests and polls for answers. The process follows the world's change feed; each request
is answered in a forked copy of it. A process that dies or is suspended is restarted and its requests are repeated.
"""

from __future__ import annotations

import pickle
import signal
import time
import uuid
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from threading import Event, Lock, Timer, get_ident
from typing import Any, TypeVar

from skiros_py.errors import DeviceError, PlanningError, SkirosError
from skiros_py.interruptions import Interruption, cancel_pending, raise_in
from skiros_py.planning.planners.planner import Planner, Planners
from skiros_py.planning.replica import MARK, PROCESSOR_TIME
from skiros_py.planning.requests import Answer, Asked, Request, answered
from skiros_py.processes import packed
from skiros_py.programs import kill_group, kill_marked
from skiros_py.world.queries.outside import FollowingReplica
from skiros_py.world.world import World

T = TypeVar("T")

_PROGRAM = "skiros_py.planning.replica:PlanningReplica"
_TRIES = 3
"""How often a request is tried if the process dies."""
_POLL = 0.05
"""Poll interval for cancellation [s]."""
_LEAVING = 0.2
"""How long orphaned copies may take to end their planners [s]."""


class PlanningProcess:
    """Answers requests in a separate process, started at once. Thread-safe. The owner must close it.

    Args:
        world: The world that requests refer to.
        make_planners: Creates the planners to choose from; called in the process.

    Raises:
        PlanningError: The planners cannot be sent to another process.
    """

    def __init__(self, world: World, make_planners: Callable[[], Planners]) -> None:
        self._threads = ThreadPoolExecutor(thread_name_prefix="skiros-planning")
        self._closed = Event()
        self._mark = uuid.uuid4().hex
        planners = _packed("the planners", make_planners)
        self._replica = FollowingReplica(world, _PROGRAM, planners, self._mark, on_death=self._kill_programs)
        self._threads.submit(self._replica.start)

    def ask(self, request: Request[T]) -> Asked[T]:
        """Submits a request about the current world and returns at once.

        Raises:
            PlanningError: It was closed, or the request cannot be pickled.
        """
        stop = Event()
        order = _packed("the request", request)
        try:
            return Asked(self._threads.submit(self._answer, order, stop), stop.set)
        except RuntimeError:
            raise PlanningError("planning was stopped") from None

    @property
    def pid(self) -> int | None:
        """Id of the process; None if it does not run."""
        return self._replica.pid

    def close(self) -> None:
        """Ends the process and all pending requests; may be called twice."""
        self._closed.set()
        self._threads.shutdown(wait=True, cancel_futures=True)
        self._replica.close()

    # ------------------------------------------------------------ in waiting threads

    def _answer(self, order: bytes, stop: Event) -> Answer[Any]:
        why = ""
        for _ in range(_TRIES):
            try:
                version, pending = self._replica.ask(order)
                ended = pending.wait_unless(lambda: stop.is_set() or self._closed.is_set(), _POLL)
            except DeviceError as error:
                why = str(error)
                continue
            if ended is None:
                raise PlanningError("planning was stopped")
            if ended.code == -signal.SIGVTALRM:
                raise PlanningError(f"planning took more than {PROCESSOR_TIME:g} s of processor time")
            if ended.code == 0:
                value = pickle.loads(ended.answer)  # noqa: S301  from our own process
                if isinstance(value, SkirosError):
                    raise value
                return Answer(version, value)
            why = f"the planning process ended with status {ended.code}"
        raise PlanningError(f"planning broke {_TRIES} times: {why}")

    def _kill_programs(self, pid: int) -> None:
        """Ends what a process that died has left: its copies, and their programs."""
        time.sleep(_LEAVING)
        kill_group(pid)
        kill_marked(MARK, self._mark)


def _packed(what: str, thing: object) -> bytes:
    try:
        return packed(thing)
    except Exception as error:  # noqa: BLE001 - unpicklable objects may raise anything
        raise PlanningError(f"{what} cannot be sent to the planning process: {type(error).__name__}: {error}") from None


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
        self._interrupted: set[int] = set()

    def ask(self, request: Request[T]) -> Asked[T]:
        """Submits a request about the current world.

        Raises:
            PlanningError: It was closed.
        """
        stop = Event()
        state = self._world.snapshot()

        def work() -> Answer[T]:
            with self._lock:
                self._working[get_ident()] = stop
            try:
                value = answered(request, state, self._planners, lambda: stop.is_set() or self._closed.is_set())
                return Answer(state.version, value)
            except _Stopped:
                raise PlanningError("planning was stopped") from None
            finally:
                with self._lock:
                    del self._working[get_ident()]
                    if get_ident() in self._interrupted:
                        self._interrupted.remove(get_ident())
                        cancel_pending(_Stopped)

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
                    self._interrupted.add(thread)
                    raise_in(thread, _Stopped)

    def close(self) -> None:
        """Cancels all pending requests."""
        self._closed.set()
        self._threads.shutdown(wait=False, cancel_futures=True)
        end = time.monotonic() + _PATIENCE
        while self._working and time.monotonic() < end:
            time.sleep(0.005)
        self._interrupt()
        self._threads.shutdown(wait=True)
