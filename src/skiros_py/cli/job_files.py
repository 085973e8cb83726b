"""Jobs in a data directory without a running server."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from contextlib import closing, contextmanager
from pathlib import Path

from skiros_py.api.jobs import Job, JobPage, JobPlan, JobTrace, StateName
from skiros_py.errors import FileError, UnknownName
from skiros_py.station.jobs.views import STATES, job_view, next_cursor, plan_of
from skiros_py.tasks.jobs.job import Job as Known
from skiros_py.tasks.jobs.store import JobStore
from skiros_py.world.journal.data_directory import DirectoryLock


@contextmanager
def kept_jobs(data: Path) -> Iterator[JobFiles]:
    """Opens the jobs of a data directory for reading.

    Raises:
        FileError: There are no jobs in it, somebody uses it, or it cannot be read.
    """
    path = data / "jobs.db"
    if not path.exists():
        raise FileError(data, f"no jobs are kept here; 'skiros serve --data {data}' takes some")
    lock = DirectoryLock(data)
    try:
        with closing(JobStore(path)) as store:
            yield JobFiles(store)
    finally:
        lock.release()


class JobFiles:
    """The jobs of a store, with the methods of ``client.jobs``."""

    def __init__(self, store: JobStore) -> None:
        self._store = store

    def get(self, job: str) -> Job:
        """Returns a job.

        Raises:
            UnknownName: There is no such job.
        """
        return job_view(self._job(job), time.time())

    def list(self, *, states: Sequence[str], limit: int, cursor: str | None = None) -> JobPage:
        """Returns the first jobs, or those after a cursor, that are in some states; in any where none is given."""
        wanted = [STATES[StateName(state)] for state in states] if states else None
        page = self._store.page(states=wanted, limit=limit, after=None if cursor is None else int(cursor))
        return JobPage(items=tuple(job_view(job, time.time()) for job in page.jobs), next=next_cursor(page))

    def plan(self, job: str) -> JobPlan:
        """Returns the last plan of a job."""
        return plan_of(self._job(job), self._store.trace(job).entries)

    def trace(self, job: str, *, limit: int, cursor: str | None = None) -> JobTrace:  # noqa: ARG002 - as of a server
        """Returns the trace of a job, on one page."""
        return JobTrace(items=self._store.trace(self._job(job).id).entries)

    def _job(self, job: str) -> Known:
        known = self._store.job(job)
        if known is None:
            raise UnknownName("job", job, self._store.ids())
        return known
