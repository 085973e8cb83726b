"""The intake of orders: those that arrive at about the same time are stored together."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from concurrent.futures import Future
from functools import partial
from queue import Empty, SimpleQueue
from typing import Generic, NamedTuple, TypeVar

from skiros_py.errors import Overloaded
from skiros_py.messages import Message
from skiros_py.tasks.jobs.job import Job
from skiros_py.tasks.jobs.manager import JobManager, Submission

T = TypeVar("T")

MOST_WAITING = 100
"""Maximum number of waiting orders: with more of them, an answer would take seconds."""
_TOGETHER = 16
"""Maximum number stored in one transaction, for which the control cycle may have to wait."""


class Request(NamedTuple, Generic[T]):
    """An order on its way.

    Attributes:
        read: Reads it: returns what is to be stored, or the answer if it is known already.
        answer_of: Returns the answer, given the job.
        answer: The answer, once everything is on disk.
    """

    read: Callable[[], Submission | T]
    answer_of: Callable[[Job], T]
    answer: Future[T]


class OrderIntake(Generic[T]):
    """Reads, checks and stores orders in a thread of its own. Start it, and close it.

    Args:
        jobs: Returns the queue of jobs of the current session.
    """

    def __init__(self, jobs: Callable[[], JobManager]) -> None:
        self._jobs = jobs
        self._places = threading.BoundedSemaphore(MOST_WAITING)
        self._requests: SimpleQueue[Request[T] | None] = SimpleQueue()
        self._thread = threading.Thread(target=self._work, name="skiros-orders", daemon=True)

    def start(self) -> None:
        """Starts the thread."""
        self._thread.start()

    def close(self) -> None:
        """Answers the waiting requests, and ends the thread; may be called twice."""
        self._requests.put(None)
        self._thread.join()

    def ask(self, read: Callable[[], Submission | T], answer_of: Callable[[Job], T]) -> Future[T]:
        """Queues an order; the arguments are those of :class:`Request`.

        Raises:
            Overloaded: Too many orders wait.
        """
        if not self._places.acquire(blocking=False):
            raise Overloaded(Message("{count} orders wait to be stored: send them more slowly", count=MOST_WAITING))
        answer: Future[T] = Future()
        answer.set_running_or_notify_cancel()  # who no longer waits cannot cancel it: the order is stored anyway
        answer.add_done_callback(lambda _: self._places.release())
        self._requests.put(Request(read, answer_of, answer))
        return answer

    def _work(self) -> None:
        for group in iter(self._next_group, None):
            self._accept(group)

    def _next_group(self) -> list[Request[T]] | None:
        group: list[Request[T]] = []
        request = self._requests.get()
        while request is not None:
            group.append(request)
            if len(group) == _TOGETHER:
                return group
            try:
                request = self._requests.get_nowait()
            except Empty:
                return group
        if group:
            self._requests.put(None)
        return group or None

    def _accept(self, group: Sequence[Request[T]]) -> None:
        """Stores what is new, and answers after the next sync of the disk, for which the next group does not wait."""
        done: list[tuple[Request[T], T]] = []
        new: list[tuple[Request[T], Submission]] = []
        for request in group:
            try:
                found = request.read()
            except Exception as error:  # noqa: BLE001 - raised where the answer is awaited
                request.answer.set_exception(error)
            else:
                if isinstance(found, Submission):
                    new.append((request, found))
                else:
                    done.append((request, found))
        try:
            jobs = self._jobs()
            outcomes = jobs.submit_all([submission for _, submission in new])
            for (request, _), outcome in zip(new, outcomes, strict=True):
                if isinstance(outcome, Job):
                    done.append((request, request.answer_of(outcome)))
                else:
                    request.answer.set_exception(outcome)
            jobs.store.sync().add_done_callback(partial(_answer, done))
        except Exception as error:  # noqa: BLE001 - raised where the answers are awaited
            for request in group:
                if not request.answer.done():
                    request.answer.set_exception(error)


def _answer(done: Sequence[tuple[Request[T], T]], sync: Future[None]) -> None:
    fault = sync.exception()
    for request, found in done:
        if fault is None:
            request.answer.set_result(found)
        else:
            request.answer.set_exception(fault)
