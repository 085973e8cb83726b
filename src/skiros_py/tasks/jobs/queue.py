"""The queue of waiting jobs: finds the next one without scanning all jobs."""

from __future__ import annotations

import heapq
import math
import threading
from collections.abc import Iterable

from skiros_py.tasks.jobs.job import Job
from skiros_py.tasks.jobs.states import JobState

_Rank = tuple[int, float, int]
_Mark = tuple[int, int]
_Ready = tuple[_Rank, float, str, _Mark]
_Gated = tuple[float, _Rank, str, _Mark]

_SPARE = 100
"""How many stale entries are tolerated before the heap is cleaned up."""


class JobQueue:
    """The jobs that start by themselves; used by any thread, never waits for the disk.

    The higher priority comes first; of equal priority the earlier deadline; then the earlier order.

    Replaced or removed jobs leave a stale entry behind that is dropped when it reaches the top.

    Args:
        jobs: The jobs that are already waiting.
    """

    def __init__(self, jobs: Iterable[Job] = ()) -> None:
        self._guard = threading.Lock()
        self._marks: dict[str, _Mark] = {}
        self._ready: list[_Ready] = []
        self._gated: list[_Gated] = []
        for job in jobs:
            self.put(job)

    def put(self, job: Job) -> None:
        """Updates a job with its current version, whether it is waiting or not."""
        with self._guard:
            if job.state is not JobState.ALLOWED_TO_START:
                self._marks.pop(job.id, None)
                return
            mark = self._marks[job.id] = (job.number, job.version)
            heapq.heappush(self._gated, (_opening(job), rank(job), job.id, mark))
            self._tidy()

    def remove(self, job: str) -> None:
        """Forgets a job."""
        with self._guard:
            self._marks.pop(job, None)

    def next(self, now: float) -> str | None:
        """Returns the id of the job that comes next, or None when none may start now.

        Args:
            now: Wall time [s since 1970].
        """
        with self._guard:
            self._open_gates(now)
            while self._ready:
                rank, opening, job, mark = self._ready[0]
                if self._marks.get(job) == mark and opening <= now:
                    return job
                heapq.heappop(self._ready)
                if self._marks.get(job) == mark:  # the clock was set back
                    heapq.heappush(self._gated, (opening, rank, job, mark))
            return None

    def _open_gates(self, now: float) -> None:
        while self._gated and self._gated[0][0] <= now:
            opening, rank, job, mark = heapq.heappop(self._gated)
            if self._marks.get(job) == mark:
                heapq.heappush(self._ready, (rank, opening, job, mark))

    def _tidy(self) -> None:
        if len(self._ready) + len(self._gated) > 2 * len(self._marks) + _SPARE:
            self._ready = [entry for entry in self._ready if self._marks.get(entry[2]) == entry[3]]
            self._gated = [entry for entry in self._gated if self._marks.get(entry[2]) == entry[3]]
            heapq.heapify(self._ready)
            heapq.heapify(self._gated)


def _opening(job: Job) -> float:
    gate = job.order.not_before
    return -math.inf if gate is None else gate.timestamp()


def rank(job: Job) -> _Rank:
    """Returns the sort key of a job: the smallest comes first."""
    deadline = job.order.deadline
    return -job.order.priority, math.inf if deadline is None else deadline.timestamp(), job.number
