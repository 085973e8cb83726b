"""Jobs in a data directory that is not served."""

from __future__ import annotations

import time
from contextlib import ExitStack, closing
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

from skiros_py.errors import FileError, UnknownName

if TYPE_CHECKING:
    from skiros_py.api.jobs import Job, JobPlan
    from skiros_py.tasks.jobs import Job as Known


class JobFiles:
    """The jobs of a data directory, for looking at. Use it in a ``with``.

    Args:
        data: The data directory.

    Raises:
        FileError: There are no jobs in it, somebody uses it, or it cannot be read.
    """

    def __init__(self, data: Path) -> None:
        from skiros_py.tasks.jobs import JobStore
        from skiros_py.world.journal.data_directory import DirectoryLock

        path = data / "jobs.db"
        if not path.exists():
            raise FileError(data, f"no jobs are kept here; 'skiros serve --data {data}' takes some")
        with ExitStack() as stack:
            stack.callback(DirectoryLock(data).release)
            self._store = stack.enter_context(closing(JobStore(path)))
            self._stack = stack.pop_all()

    def get(self, job: str) -> Job:
        """Returns a job.

        Raises:
            UnknownName: There is no such job.
        """
        from skiros_py.station.jobs.views import job_view

        return job_view(self._job(job), time.time())

    def list(self, states: tuple[str, ...], limit: int) -> tuple[Job, ...]:
        """Returns the first jobs that are in some states; in any where none is given."""
        from skiros_py.api.jobs import StateName
        from skiros_py.station.jobs.views import STATES, job_view

        wanted = [STATES[StateName(state)] for state in states] if states else None
        page = self._store.page(states=wanted, limit=limit)
        return tuple(job_view(job, time.time()) for job in page.jobs)

    def plan(self, job: str) -> JobPlan:
        """Returns the last plan of a job."""
        from skiros_py.station.jobs.accounts import plan_of

        return plan_of(self._job(job), self._store.trace(job))

    def trace(self, job: str) -> tuple[dict[str, Any], ...]:
        """Returns what happened for a job."""
        return self._store.trace(self._job(job).id)

    def _job(self, job: str) -> Known:
        known = self._store.job(job)
        if known is None:
            raise UnknownName("job", job, self._store.ids())
        return known

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._stack.close()
