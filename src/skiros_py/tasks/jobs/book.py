"""All jobs as they are now: what the store has, at hand, and told to whoever listens."""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any

from skiros_py.tasks.jobs.job import Job, JobOrder
from skiros_py.tasks.jobs.states import JobState, Trigger, next_state
from skiros_py.tasks.jobs.store import JobStore

__all__ = ["JobBook"]

_log = logging.getLogger(__name__)


class JobBook:
    """The jobs of a store; every change is on the disk before anybody hears of it.

    Whoever writes holds the job manager's guard.

    Args:
        store: Where they are kept.
        clock: Gives the wall time [s since 1970].

    Attributes:
        version: Grows with every change of any job.
    """

    def __init__(self, store: JobStore, clock: Callable[[], float]) -> None:
        self._store = store
        self._clock = clock
        self._jobs = {job.id: job for job in store.all()}
        self._listeners: list[Callable[[Job], None]] = []
        self.version = 0

    @property
    def jobs(self) -> Mapping[str, Job]:
        """All jobs by id, in the order in which they were ordered; what was handed out does not change."""
        return MappingProxyType(self._jobs)

    def subscribe(self, listener: Callable[[Job], None]) -> Callable[[], None]:
        """Calls the listener with every new version of a job; returns how to end that. It must be quick."""
        self._listeners.append(listener)
        return lambda: self._listeners.remove(listener)

    def add(self, order: JobOrder, *, start: bool, comment: str) -> Job:
        """Takes a new order."""
        state = JobState.ALLOWED_TO_START if start else JobState.NOT_ALLOWED_TO_START
        detail = "queued" if start else "waits for leave to start"
        job = Job(order=order, number=self._store.next_number(), state=state, detail=detail, ordered=self._clock())
        return self._keep(job, Trigger.START if start else Trigger.UPDATE, comment)

    def check(self, job: Job, trigger: Trigger) -> None:
        """Sees that something may happen to a job.

        Raises:
            UsageError: It cannot happen in its state.
        """
        next_state(job.state, trigger)

    def move(self, job: Job, trigger: Trigger, comment: str = "", **changes: Any) -> Job:
        """Changes a job's state, and what goes with it.

        Raises:
            UsageError: That cannot happen in its state.
        """
        state = next_state(job.state, trigger)
        ended = {} if state.is_open else {"ended": self._clock()}
        return self._keep(job.but(state=state, **ended, **changes), trigger, comment)

    def change(self, job: Job) -> Job:
        """Takes a new version of a job whose state is the same."""
        return self._keep(job, None, "")

    def remove(self, job: str) -> None:
        """Forgets a job."""
        self._store.forget(job)
        self.version += 1
        self._jobs = {id_: known for id_, known in self._jobs.items() if id_ != job}

    def _keep(self, job: Job, trigger: Trigger | None, comment: str) -> Job:
        self._store.keep(job, trigger, comment)
        self._jobs = self._jobs | {job.id: job}
        self.version += 1
        for listener in tuple(self._listeners):
            try:
                listener(job)
            except Exception:  # noqa: BLE001 - whoever only looks on must not break what is going on
                _log.exception("a listener of jobs broke")
        return job
