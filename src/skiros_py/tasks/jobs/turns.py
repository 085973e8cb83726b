"""Whose turn it is: new orders in their order, and before those of equal priority what was begun once and goes on."""

from __future__ import annotations

from collections.abc import Callable

from skiros_py.tasks.jobs.book import JobBook
from skiros_py.tasks.jobs.queue import rank
from skiros_py.tasks.jobs.states import JobState


class Turns:
    """The jobs that may begin, and those that begin anew; used in the control thread, apart from :meth:`next`.

    What was begun once and has to be planned anew, since the program ended or everything was halted meanwhile, waits
    like any other: others may work with its robots by now. There are few of these.

    Args:
        book: The jobs as they are now.
        clock: Gives the wall time [s since 1970].
    """

    def __init__(self, book: JobBook, clock: Callable[[], float]) -> None:
        self._book = book
        self._clock = clock
        self._back: dict[str, None] = {}

    def come_back(self, job: str) -> None:
        """Has a job wait that goes on."""
        self._back = dict.fromkeys((*self.coming_back, job))

    def leave(self, job: str) -> None:
        """Has a job wait no more that was to go on."""
        self._back.pop(job, None)

    @property
    def coming_back(self) -> tuple[str, ...]:
        """The jobs that wait to go on: none that was paused or ended meanwhile."""
        return tuple(job for job in tuple(self._back) if self._is_running(job))

    def next(self) -> str | None:
        """Returns the id of the job whose turn it is; None where none may start now."""
        new = self._book.queue.next(self._clock())
        back = self._first_back()
        if back is None or new is None:
            return back or new
        return back if self._priority(back) >= self._priority(new) else new

    def _first_back(self) -> str | None:
        """Returns the first of those that wait to go on."""
        waiting = (self._book.open.get(job) for job in self.coming_back)
        first = min((job for job in waiting if job is not None), key=rank, default=None)
        return None if first is None else first.id

    def _is_running(self, id_: str) -> bool:
        job = self._book.open.get(id_)
        return job is not None and job.state is JobState.RUNNING

    def _priority(self, id_: str) -> int:
        job = self._book.open.get(id_)
        return 0 if job is None else job.order.priority
