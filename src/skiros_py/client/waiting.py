"""Waiting for a state of a job."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable, Iterator

from skiros_py.api.jobs import Job
from skiros_py.client.call import AsyncSender, Sender
from skiros_py.client.calls import jobs
from skiros_py.client.errors import TookTooLong, Unreachable

_FIRST, _LONGEST = 0.05, 1.0
"""First and longest polling interval [s]."""
_OUTAGE = 60.0
"""How long the server may be unreachable, for example during a restart [s]."""


def is_over(job: Job) -> bool:
    """Returns whether a job is over, regardless of its outcome."""
    return job.outcome is not None


def wait_for(client: Sender, job: str, until: Callable[[Job], bool], timeout: float | None) -> Job:
    """Waits until a condition holds for a job; see ``Jobs.wait``."""
    looks = _Looks(job, timeout)
    for pause in looks:
        try:
            if until(found := looks.seen(client.send(jobs.get_job(job)))):
                return found
        except Unreachable as error:
            looks.missed(error)
        time.sleep(pause)
    raise looks.given_up()


async def wait_for_async(client: AsyncSender, job: str, until: Callable[[Job], bool], timeout: float | None) -> Job:
    """Waits like :func:`wait_for`, without blocking the event loop."""
    looks = _Looks(job, timeout)
    for pause in looks:
        try:
            if until(found := looks.seen(await client.send(jobs.get_job(job)))):
                return found
        except Unreachable as error:
            looks.missed(error)
        await asyncio.sleep(pause)
    raise looks.given_up()


class _Looks:
    """When to poll again, and when to give up."""

    def __init__(self, job: str, timeout: float | None) -> None:
        self._job = job
        self._timeout = timeout
        self._end = time.monotonic() + (float("inf") if timeout is None else timeout)
        self._heard = time.monotonic()
        self._last = "nothing is known of it"

    def __iter__(self) -> Iterator[float]:
        """Yields for each poll how long to wait after it [s]; there is one more poll at the very end."""
        pause = _FIRST
        while (left := self._end - time.monotonic()) > 0.0:
            yield min(pause, left)
            pause = min(1.5 * pause, _LONGEST)
        yield 0.0

    def seen(self, job: Job) -> Job:
        """Records the job as seen."""
        self._heard = time.monotonic()
        self._last = f"it is {job.state.text}{f': {job.detail}' if job.detail else ''}"
        return job

    def missed(self, error: Unreachable) -> None:
        """Records that there was no answer.

        Raises:
            Unreachable: There has been no answer for too long.
        """
        if time.monotonic() - self._heard > _OUTAGE:
            raise error

    def given_up(self) -> TookTooLong:
        """Returns the error with the job's last seen state."""
        return TookTooLong(f"job '{self._job}' did not come so far within {self._timeout:g} s: {self._last}")
