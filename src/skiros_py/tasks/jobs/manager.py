"""Accepts job orders, runs them in turn and keeps their records across restarts.

Commands may come from any thread: they are checked and stored at once and take effect at the end of the current
control cycle. Running tasks are accessed in the control thread only.
"""

from __future__ import annotations

import time
from collections.abc import Callable

from skiros_py.errors import Busy, Removed, WrongState
from skiros_py.execution.runtime import Runtime
from skiros_py.tasks.jobs.book import Guard, JobBook
from skiros_py.tasks.jobs.commands import JobCommands
from skiros_py.tasks.jobs.conductor import Conductor, ReadGoal
from skiros_py.tasks.jobs.job import Job, JobOrder, Trigger
from skiros_py.tasks.jobs.run import hold_what_was_cut_off
from skiros_py.tasks.jobs.store import JobStore, Receipt
from skiros_py.tasks.task_manager import TaskManager

_MOST_OPEN = 50_000
_RETRY_AFTER = 30.0
"""Suggested retry delay when the queue is full [s]."""


class JobManager(JobCommands):
    """The queue of jobs of one runtime.

    Args:
        tasks: Plans and executes.
        runtime: Where jobs run.
        store: Where jobs are stored; closed by its creator.
        parse: Reads goal texts.
        at_once: How many jobs may run at the same time.
        limit: How many jobs may be open at the same time.
        clock: Gives the wall time [s since 1970].

    Attributes:
        limit: How many jobs may be open at the same time; may be set. Further orders are refused; existing jobs stay.
    """

    def __init__(
        self,
        tasks: TaskManager,
        runtime: Runtime,
        store: JobStore,
        parse: ReadGoal,
        *,
        at_once: int = 1,
        limit: int = _MOST_OPEN,
        clock: Callable[[], float] = time.time,
    ) -> None:
        guard = Guard(store.flush, lockstep=runtime.cycle.pace is None)
        book = JobBook(store, clock)
        conductor = Conductor(tasks, runtime, store, book, parse, guard, at_once=at_once, clock=clock)
        super().__init__(book, store, runtime, conductor, guard)
        self.limit = limit
        self._parse = parse
        hold_what_was_cut_off(book, store, runtime.world)
        runtime.cycle.observe(conductor.attend)

    @property
    def idle(self) -> bool:
        """True if no job is running and none would start now."""
        return self._conductor.idle

    def submit(
        self,
        order: JobOrder,
        *,
        start: bool = True,
        comment: str = "",
        receipt: Receipt | None = None,
        again: bool = False,
    ) -> Job:
        """Accepts an order; when this returns, it is on disk.

        Args:
            order: The order. Submitting the same order again changes nothing.
            start: True if it may start by itself when its turn comes.
            comment: Why, for the record.
            receipt: Identifies the request: repeating it changes nothing, even under another order id.
            again: True to accept the order although a job with that id was removed before.

        Returns:
            The job; for a known order or request, its current version.

        Raises:
            UsageError: Its goal cannot be understood.
            KeyReused: The receipt's key was used for another request.
            WrongState: There is another order of that id, or there was one.
            Removed: The same order came before, and its job was removed.
            Busy: Too many jobs are open.
        """
        known = self._known(
            order, receipt, again=again
        )  # a known order is not parsed again: the world has changed since
        if known is not None:
            return known
        self._parse(order.goal)
        with self._guard.command():
            known = self._known(order, receipt, again=again)
            if known is not None:
                return known
            if len(self.open) >= self.limit:
                raise Busy(f"{self.limit} jobs are open, no more are taken: try again later", retry_after=_RETRY_AFTER)
            return self._book.add(order, start=start, comment=comment, receipt=receipt)

    def update(self, order: JobOrder, comment: str = "", *, expects: int | None = None) -> Job:
        """Replaces the order of a job that has not started.

        Args:
            order: The new order. An identical order changes nothing.
            comment: Why, for the record.
            expects: The job's version, as seen.

        Raises:
            UnknownName: There is no such job.
            UsageError: Its goal cannot be understood.
            StaleVersion: It has changed since it was seen.
            WrongState: It has started.
        """
        self._parse(order.goal)
        with self._guard.command():
            now = self._expected(order.id, expects)
            if now.order == order:
                return now
            return self._book.move(now, Trigger.UPDATE, comment, order=order)

    def _known(self, order: JobOrder, receipt: Receipt | None, *, again: bool) -> Job | None:
        """Returns the job of a repeated order or request; None if both are new."""
        with self._guard.command():
            if receipt is not None and (before := self.store.known(receipt)) is not None:
                return before
            known = self.jobs.get(order.id)
            if known is None:
                _check_removed(order, None if again else self.store.removed(order.id))
                return None
            if known.order != order:
                raise WrongState(
                    f"job '{order.id}' is there already, with another order: update that, or take another id"
                )
            if receipt is not None:
                self._book.note(receipt, known)
            return known


def _check_removed(order: JobOrder, last: Job | None) -> None:
    """Refuses an order that was done and removed before: it may be a late retry by a client that got no answer."""
    if last is None:
        return
    if last.order == order:
        came = f" ({last.outcome})" if last.outcome else ""
        raise Removed(
            f"job '{order.id}' was removed{came}, and its order is not taken twice: say that it is meant again"
        )
    raise WrongState(f"there was a job '{order.id}' with another order, and it was removed: take another id")
