"""What others ask of the control thread: waits in a queue, and is done between two cycles."""

from __future__ import annotations

import logging
import threading
import time
from collections import deque
from collections.abc import Callable
from concurrent.futures import Future
from typing import Any, Generic, TypeVar

from skiros_py.errors import Busy, DeviceError, SkirosError

T = TypeVar("T")

_log = logging.getLogger(__name__)

_BUDGET = 0.02
"""How long what others ask may keep the next cycle waiting [s]; what is left then is done after it."""


class Commands:
    """The queue: filled by any thread, emptied by one. It takes nothing before :meth:`open`."""

    def __init__(self) -> None:
        self._waiting: deque[_Command[Any]] = deque()
        self._guard = threading.Lock()
        self._asked = threading.Event()
        self._takes = False

    def __len__(self) -> int:
        return len(self._waiting)

    def open(self) -> None:
        """Takes what is asked from now on."""
        self._takes = True

    def ask(self, work: Callable[[], T]) -> Future[T]:
        """Queues work, and returns the future of its result; cancelled in time, it is not done.

        Raises:
            Busy: Nothing is taken now.
        """
        answer: Future[T] = Future()
        with self._guard:
            if not self._takes:
                raise Busy("the station is not running: the server begins or ends", retry_after=5.0)
            self._waiting.append(_Command(answer, work))
        self._asked.set()
        return answer

    def ask_aside(self, work: Callable[[], object]) -> None:
        """Queues work whose result is not used: what it raises is logged.

        Raises:
            Busy: Nothing is taken now.
        """
        self.ask(work).add_done_callback(_log_failure)

    # ------------------------------------------------------------------ in the control thread

    def do_some(self) -> None:
        """Does what was asked for until now, as far as the time goes: who asks all the time must not stop the cycle."""
        end = time.perf_counter() + _BUDGET
        for _ in range(len(self._waiting)):
            self._waiting.popleft().do()
            if time.perf_counter() > end:
                return

    def wait(self, seconds: float) -> None:
        """Waits until somebody asks for something; what was asked for since the last look counts."""
        if not self._waiting:
            self._asked.wait(seconds)
        self._asked.clear()

    def wake(self) -> None:
        """Ends the wait; for any thread."""
        self._asked.set()

    def refuse_all(self) -> None:
        """Takes nothing any more, and says of what waits that it will not be done."""
        with self._guard:
            self._takes = False
        while self._waiting:
            self._waiting.popleft().refuse(Busy("the station was shut down before that was done", retry_after=5.0))


class _Command(Generic[T]):
    """Something that was asked for, and where the asker waits for what comes of it."""

    def __init__(self, answer: Future[T], work: Callable[[], T]) -> None:
        self._answer: Future[T] = answer
        self._work = work

    def do(self) -> None:
        """Does it, unless it was cancelled."""
        if not self._answer.set_running_or_notify_cancel():
            return
        try:
            self._answer.set_result(self._work())
        except Exception as error:  # noqa: BLE001 - it is raised where the work was asked for
            self._answer.set_exception(error)
        except BaseException as error:  # noqa: BLE001 - there it would end more than the request
            self._answer.set_exception(DeviceError(f"it was broken off: {error!r}"))

    def refuse(self, error: SkirosError) -> None:
        """Says that it will not be done."""
        if self._answer.set_running_or_notify_cancel():
            self._answer.set_exception(error)


def _log_failure(answer: Future[object]) -> None:
    error = None if answer.cancelled() else answer.exception()
    if error is not None and not isinstance(error, Busy):
        _log.error("what was asked of the control thread failed: %s", error, exc_info=trace_of(error))


def trace_of(error: BaseException) -> BaseException | None:
    """Returns what a log shall say of an error beside its words: those of our own faults say it all."""
    return None if isinstance(error, SkirosError) else error
