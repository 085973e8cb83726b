"""Queries about jobs; callable from any thread, never blocked by commands."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from typing import Any

from skiros_py.errors import UnknownName
from skiros_py.tasks.jobs.announcements import Announcement
from skiros_py.tasks.jobs.book import JobBook
from skiros_py.tasks.jobs.job import Intent, Job, Transition
from skiros_py.tasks.jobs.receipts import Receipt
from skiros_py.tasks.jobs.states import JobState
from skiros_py.tasks.jobs.store import JobStore, Page


class JobLookups:
    """Answers questions about jobs.

    Args:
        book: The current jobs.
        store: Where they are stored.

    Attributes:
        store: Where they are stored; used to forward announcements.
    """

    def __init__(self, book: JobBook, store: JobStore) -> None:
        self.store = store
        self._book = book

    @property
    def jobs(self) -> Mapping[str, Job]:
        """All jobs that were not removed, by id, in the order in which they were ordered; reads are slow.

        Finished jobs are read from the file each time: use :meth:`page` to read many of them.
        """
        return self._book.jobs

    @property
    def open(self) -> Mapping[str, Job]:
        """The jobs that are not over, by id, in the order in which they were ordered."""
        return self._book.open

    def job(self, job: str) -> Job:
        """Returns a job, open or over.

        Raises:
            UnknownName: There is no such job.
        """
        found = self._book.jobs.get(job)
        if found is None:
            raise UnknownName("job", job, self._book.open)
        return found

    def removed(self, job: str) -> Job | None:
        """Returns the last version, without details, of a job removed in the last days; None if there is none."""
        return self.store.removed(job)

    def page(
        self,
        *,
        states: Collection[JobState] | None = None,
        since: float | None = None,
        after: int | None = None,
        limit: int = 100,
        newest_first: bool = False,
    ) -> Page:
        """Returns some of the jobs, open or over, in the order in which they were ordered, or back from the last one.

        Args:
            states: Those in these states only; None for all.
            since: Those only that changed at that time or later [s since 1970]; None for all.
            after: The :attr:`Page.next` of the page before, read in the same order; None for the first page.
            limit: How many at most.
            newest_first: True to go back from the last one.
        """
        return self.store.page(states=states, since=since, after=after, limit=limit, newest_first=newest_first)

    def known(self, receipt: Receipt) -> Job | None:
        """Returns the job that the same request led to before, removed or not; None if there was none.

        Raises:
            KeyReused: The key was used for another request.
        """
        return self.store.known(receipt)

    def intents(self, job: str) -> tuple[Intent, ...]:
        """Returns the steps that were started for a job, in order, and how they ended.

        Raises:
            UnknownName: There is no such job.
        """
        return self.store.intents(self.job(job).id)

    def transitions(self, job: str) -> tuple[Transition, ...]:
        """Returns a job's state changes, in order, with their triggers.

        Raises:
            UnknownName: There is no such job.
        """
        return self.store.transitions(self.job(job).id)

    def trace(self, job: str, *, skip: int = 0, limit: int | None = None) -> tuple[Mapping[str, Any], ...]:
        """Returns a job's trace as plain data, in order; the last second of a running job may be missing.

        Args:
            job: Its id.
            skip: How many entries to skip at the beginning.
            limit: How many at most; None for all.

        Raises:
            UnknownName: There is no such job.
        """
        return self.store.trace(self.job(job).id, skip=skip, limit=limit)

    def announcements(self, after: int, most: int) -> tuple[Announcement, ...]:
        """Returns announcements to forward; see :meth:`JobStore.announcements`."""
        return self.store.announcements(after, most)

    @property
    def last_announcement(self) -> int:
        """Number of the last announcement, deleted or not; 0 before the first."""
        return self.store.last_announcement

    def forget_announcements(self, upto: int) -> None:
        """Deletes delivered announcements; see :meth:`JobStore.forget_announcements`."""
        self.store.forget_announcements(upto)

    def subscribe(self, listener: Callable[[Job], None]) -> Callable[[], None]:
        """Calls the listener with every new version of a job, in the writing thread; returns how to unsubscribe."""
        return self._book.subscribe(listener)

    def on_remove(self, listener: Callable[[Job], None]) -> Callable[[], None]:
        """Calls the listener with each job that is cancelled or cleared, in the thread that did it."""
        return self._book.on_remove(listener)
