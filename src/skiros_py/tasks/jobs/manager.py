"""Takes job orders, lets them run one after the other, and keeps what is known of them over restarts.

Commands may come from any thread: they are checked and written down at once, and take effect at the end of the present
control cycle. What runs is touched in the control thread only.
"""

from __future__ import annotations

import time
from collections.abc import Callable

from skiros_py.errors import Busy, Removed, WrongState
from skiros_py.execution.runtime import Runtime
from skiros_py.tasks.jobs.book import JobBook
from skiros_py.tasks.jobs.commands import JobCommands
from skiros_py.tasks.jobs.conductor import Conductor, ReadGoal
from skiros_py.tasks.jobs.cut_off import hold_what_was_cut_off
from skiros_py.tasks.jobs.guard import Guard
from skiros_py.tasks.jobs.job import Job
from skiros_py.tasks.jobs.order import JobOrder
from skiros_py.tasks.jobs.receipts import Receipt
from skiros_py.tasks.jobs.states import Trigger
from skiros_py.tasks.jobs.store import JobStore
from skiros_py.tasks.task_manager import TaskManager

_MOST_OPEN = 50_000
_RETRY_AFTER = 30.0
"""When a full queue may have room again [s]: a job takes its time."""


class JobManager(JobCommands):
    """The queue of jobs of one runtime.

    Args:
        tasks: Plans and does.
        runtime: What it does it with.
        store: Where jobs are kept; whoever made it closes it.
        parse: Reads goal texts.
        at_once: How many jobs may be under way at the same time.
        limit: How many jobs may be open at the same time.
        clock: Gives the wall time [s since 1970].

    Attributes:
        limit: How many jobs may be open at the same time; may be set. What is more is refused, what is there stays.
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
        """True when nothing is under way, and nothing would start by itself now."""
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
        """Takes an order; when this returns, it is on the disk.

        Args:
            order: What is wanted. The very same order once more changes nothing.
            start: True where it may start by itself when its turn comes.
            comment: Why, for the record.
            receipt: Marks the request: the very same request once more changes nothing, whatever id the order has.
            again: True where it is meant although there was a job of that id that was removed.

        Returns:
            The job; where the order or the request was known, as that job is now.

        Raises:
            UsageError: Its goal cannot be understood.
            KeyReused: The receipt's key was used for another request.
            WrongState: There is another order of that id, or there was one.
            Removed: The same order came before, and its job was removed.
            Busy: Too many jobs are open.
        """
        known = self._known(
            order, receipt, again=again
        )  # what was taken once is not read again: the world has gone on since
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
        """Orders something else under the id of a job that has not begun.

        Args:
            order: What is wanted now. The order that is there already changes nothing.
            comment: Why, for the record.
            expects: The job's version, as seen.

        Raises:
            UnknownName: There is no such job.
            UsageError: Its goal cannot be understood.
            StaleVersion: It has changed since it was seen.
            WrongState: It has begun.
        """
        self._parse(order.goal)
        with self._guard.command():
            now = self._expected(order.id, expects)
            if now.order == order:
                return now
            return self._book.move(now, Trigger.UPDATE, comment, order=order)

    def _known(self, order: JobOrder, receipt: Receipt | None, *, again: bool) -> Job | None:
        """Returns the job of an order or request that comes once more; None where both are new."""
        with self._guard.command():
            if receipt is not None and (before := self.known(receipt)) is not None:
                return before
            known = self.jobs.get(order.id)
            if known is None:
                _check_removed(order, None if again else self.removed(order.id))
                return None
            if known.order != order:
                raise WrongState(
                    f"job '{order.id}' is there already, with another order: update that, or take another id"
                )
            if receipt is not None:
                self._book.note(receipt, known)
            return known


def _check_removed(order: JobOrder, last: Job | None) -> None:
    """Refuses an order that was done and removed before: it may come late, from somebody who got no answer."""
    if last is None:
        return
    if last.order == order:
        came = f" ({last.outcome})" if last.outcome else ""
        raise Removed(
            f"job '{order.id}' was removed{came}, and its order is not taken twice: say that it is meant again"
        )
    raise WrongState(f"there was a job '{order.id}' with another order, and it was removed: take another id")
