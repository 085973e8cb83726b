"""Waiting for jobs: by a limited number of callers, and no longer than the server runs."""

from __future__ import annotations

import threading
import time

from skiros_py.station.session import Session
from skiros_py.tasks.jobs.job import Job, JobState
from skiros_py.tasks.jobs.manager import JobManager

_MOST = 8
"""Maximum number of waiting callers: each occupies a thread that other requests may need."""
_GLANCE = 0.25
"""Period at which waiting callers check whether the server ends [s]."""


class JobWaiter:
    """Sets up the queue of each session, and lets callers wait for jobs.

    Args:
        limit: Maximum number of open jobs.
    """

    def __init__(self, limit: int) -> None:
        self._limit = limit
        self._places = threading.BoundedSemaphore(_MOST)
        self._ending = False

    def open(self, session: Session) -> None:
        """Sets up the queue of a session; called in the control thread."""
        session.jobs.limit = self._limit

    def wait(self, jobs: JobManager, job: Job, seconds: float) -> Job:
        """Waits until a job is over or interrupted, and returns it; immediately if too many callers wait already.

        Args:
            jobs: The queue.
            job: The job.
            seconds: Maximum wait [s].
        """
        rests = threading.Event()
        unsubscribe = jobs.subscribe(lambda one: rests.set() if one.id == job.id and not _is_under_way(one) else None)
        try:
            if _is_under_way(jobs.find(job.id) or job):
                self.wait_for(rests, seconds)
            return jobs.find(job.id) or job
        finally:
            unsubscribe()

    def wait_for(self, event: threading.Event, seconds: float) -> None:
        """Waits for an event, at most so long [s]; not at all if too many callers wait already."""
        end = time.monotonic() + seconds
        if event.is_set() or not self._places.acquire(blocking=False):
            return
        try:
            while not (event.is_set() or self._ending) and (left := end - time.monotonic()) > 0.0:
                event.wait(min(left, _GLANCE))
        finally:
            self._places.release()

    def close(self) -> None:
        """Ends all waiting."""
        self._ending = True


def _is_under_way(job: Job) -> bool:
    return job.state.is_open and job.state is not JobState.INTERRUPTED
