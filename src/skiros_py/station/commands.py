"""Work that other threads request from the control thread: queued, and executed between two cycles."""

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
"""Maximum delay of the next cycle by queued work [s]; the rest is executed after that cycle."""


class Commands:
    """The queue: filled by any thread, emptied by one. It accepts nothing before :meth:`open`."""

    def __init__(self) -> None:
        self._waiting: deque[_Command[Any]] = deque()
        self._guard = threading.Lock()
        self._asked = threading.Event()
        self._takes = False

    def __len__(self) -> int:
        return len(self._waiting)

    def open(self) -> None:
        """Accepts work from now on."""
        self._takes = True

    def ask(self, work: Callable[[], T]) -> Future[T]:
        """Queues work, and returns the future of its result; if cancelled in time, the work is not executed.

        Raises:
            Busy: The queue accepts nothing now.
        """
        answer: Future[T] = Future()
        with self._guard:
            if not self._takes:
                raise Busy("the station is not running: the server begins or ends", retry_after=5.0)
            self._waiting.append(_Command(answer, work))
        self._asked.set()
        return answer

    def ask_aside(self, work: Callable[[], object]) -> None:
        """Queues work whose result is not used; exceptions are logged.

        Raises:
            Busy: The queue accepts nothing now.
        """
        self.ask(work).add_done_callback(_log_failure)

    # ------------------------------------------------------------------ in the control thread

    def do_some(self) -> None:
        """Executes the work queued so far, within a time limit: continuous requests must not stop the cycle."""
        end = time.perf_counter() + _BUDGET
        for _ in range(len(self._waiting)):
            self._waiting.popleft().do()
            if time.perf_counter() > end:
                return

    def wait(self, seconds: float) -> None:
        """Waits until work is queued; work queued since the last check counts."""
        if not self._waiting:
            self._asked.wait(seconds)
        self._asked.clear()

    def wake(self) -> None:
        """Ends the wait; callable from any thread."""
        self._asked.set()

    def refuse_all(self) -> None:
        """Closes the queue, and refuses the work that waits."""
        with self._guard:
            self._takes = False
        while self._waiting:
            self._waiting.popleft().refuse(Busy("the station was shut down before that was done", retry_after=5.0))


class _Command(Generic[T]):
    """Requested work, and the future of its result."""

    def __init__(self, answer: Future[T], work: Callable[[], T]) -> None:
        self._answer: Future[T] = answer
        self._work = work

    def do(self) -> None:
        """Executes it, unless it was cancelled."""
        if not self._answer.set_running_or_notify_cancel():
            return
        try:
            self._answer.set_result(self._work())
        except Exception as error:  # noqa: BLE001 - raised in the thread that requested the work
            self._answer.set_exception(error)
        except BaseException as error:  # noqa: BLE001 - in that thread it would end more than the request
            self._answer.set_exception(DeviceError(f"it was broken off: {error!r}"))

    def refuse(self, error: SkirosError) -> None:
        """Reports that it will not be executed."""
        if self._answer.set_running_or_notify_cancel():
            self._answer.set_exception(error)


def _log_failure(answer: Future[object]) -> None:
    error = None if answer.cancelled() else answer.exception()
    if error is not None and not isinstance(error, Busy):
        _log.error("what was asked of the control thread failed: %s", error, exc_info=trace_of(error))


def trace_of(error: BaseException) -> BaseException | None:
    """Returns the error whose traceback is logged besides its message; None for our own, whose message suffices."""
    return None if isinstance(error, SkirosError) else error
