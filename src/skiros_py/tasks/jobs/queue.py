"""Whose turn it is."""

from __future__ import annotations

import math
from collections.abc import Iterable

from skiros_py.tasks.jobs.job import Job
from skiros_py.tasks.jobs.states import JobState

__all__ = ["next_job", "next_opening"]


def next_job(jobs: Iterable[Job], now: float) -> Job | None:
    """Returns the job that comes next, or None when none may start now.

    The higher priority comes first; of equal priority the earlier deadline; then the earlier order.

    Args:
        jobs: All jobs.
        now: Wall time [s since 1970].
    """
    ready = [job for job in jobs if job.state is JobState.ALLOWED_TO_START and _gate_is_open(job, now)]
    return min(ready, key=_rank, default=None)


def next_opening(jobs: Iterable[Job], now: float) -> float:
    """Returns when the next start gate opens [s since 1970]; infinity where none will."""
    gates = (job.order.not_before for job in jobs if job.state is JobState.ALLOWED_TO_START)
    return min((gate.timestamp() for gate in gates if gate is not None and gate.timestamp() > now), default=math.inf)


def _gate_is_open(job: Job, now: float) -> bool:
    return job.order.not_before is None or job.order.not_before.timestamp() <= now


def _rank(job: Job) -> tuple[int, float, int]:
    deadline = job.order.deadline
    return -job.order.priority, math.inf if deadline is None else deadline.timestamp(), job.number
