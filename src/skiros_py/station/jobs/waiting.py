"""Waiting for jobs: by a limited number of callers, and no longer than the server runs."""

from __future__ import annotations

import threading
import time

from skiros_py.station.session import Session
from skiros_py.tasks.jobs import Job, JobManager, JobState

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
        if not self._places.acquire(blocking=False):
            return job
        try:
            return self._wait(jobs, job, time.monotonic() + seconds)
        finally:
            self._places.release()

    def wait_for(self, event: threading.Event, seconds: float) -> None:
        """Waits for an event, in the same way."""
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

    def _wait(self, jobs: JobManager, job: Job, end: float) -> Job:
        changed = threading.Event()
        unsubscribe = jobs.subscribe(lambda one: changed.set() if one.id == job.id else None)
        try:
            now = jobs.find(job.id) or job
            while _is_under_way(now) and not self._ending and (left := end - time.monotonic()) > 0.0:
                changed.wait(min(left, _GLANCE))
                changed.clear()
                now = jobs.find(job.id) or now
            return now
        finally:
            unsubscribe()


def _is_under_way(job: Job) -> bool:
    return job.state.is_open and job.state is not JobState.INTERRUPTED
