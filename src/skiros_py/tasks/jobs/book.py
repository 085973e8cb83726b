"""The open jobs in memory: a cache of the job store that notifies listeners."""

from __future__ import annotations

from collections.abc import Callable, ItemsView, Iterator, KeysView, Mapping, ValuesView
from functools import partial
from typing import Any

from skiros_py.listeners import Listeners
from skiros_py.tasks.jobs.announcements import CANCELLED, CLEARED
from skiros_py.tasks.jobs.job import Job
from skiros_py.tasks.jobs.order import JobOrder
from skiros_py.tasks.jobs.queue import JobQueue
from skiros_py.tasks.jobs.receipts import Receipt
from skiros_py.tasks.jobs.states import JobState, Trigger, next_state
from skiros_py.tasks.jobs.store import JobStore


class JobBook:
    """The jobs of a store.

    Every change outlives a power cut before listeners are called with it; they are called in a thread of the store.
    Writers hold the job manager's guard. Finished jobs are in the file only: over months there are too many for
    memory.

    Args:
        store: Where the jobs are stored.
        clock: Gives the wall time [s since 1970].

    Attributes:
        open: The jobs that are not over, by id, in the order in which they were ordered.
        jobs: All that were not removed.
        queue: Those that wait for their turn.
        unseen: Ids of those that were cut off (by the end of the program) or halted, and not reviewed since.
    """

    def __init__(self, store: JobStore, clock: Callable[[], float]) -> None:
        self._store = store
        self._clock = clock
        self._open = {job.id: job for job in store.open()}
        self._listeners = Listeners[[Job]]("jobs")
        self.open = OpenJobs(self._open)
        self.jobs = AllJobs(self.open, store)
        self.queue = JobQueue(self._open.values())
        self.unseen = {job.id for job in self._open.values() if _is_unseen(job)}
        self._on_remove = Listeners[[Job]]("removed jobs")

    def subscribe(self, listener: Callable[[Job], None]) -> Callable[[], None]:
        """Calls the listener with every new version of a job; returns how to unsubscribe. It must be quick."""
        return self._listeners.add(listener)

    def on_remove(self, listener: Callable[[Job], None]) -> Callable[[], None]:
        """Calls the listener with each job that is removed; returns how to unsubscribe. It must be quick."""
        return self._on_remove.add(listener)

    def add(self, order: JobOrder, *, start: bool, comment: str, receipt: Receipt | None = None) -> Job:
        """Adds a job for a new order."""
        state = JobState.ALLOWED_TO_START if start else JobState.NOT_ALLOWED_TO_START
        detail = "queued" if start else "waits for leave to start"
        now = self._clock()
        job = Job(order=order, number=0, state=state, detail=detail, ordered=now, changed=now)
        trigger = Trigger.START if start else Trigger.STORE
        return self._show(self._store.add(job, trigger, comment, receipt))

    def note(self, receipt: Receipt, job: Job) -> None:
        """Records that a request led to an existing job."""
        self._store.note(receipt, job, self._clock())

    def check(self, job: Job, trigger: Trigger) -> None:
        """Checks that a trigger is allowed for a job.

        Raises:
            WrongState: It is not allowed in its state.
        """
        next_state(job.state, trigger)

    def move(self, job: Job, trigger: Trigger, comment: str = "", **changes: Any) -> Job:
        """Changes a job's state and related fields.

        Raises:
            WrongState: The trigger is not allowed in its state.
        """
        state = next_state(job.state, trigger)
        ended = {} if state.is_open else {"ended": self._clock(), "seen": None}
        return self._keep(job.but(**{"state": state, **changes, **ended}), trigger, comment)

    def change(self, job: Job) -> Job:
        """Stores a new version of a job with unchanged state."""
        return self._keep(job, None, "")

    def remove(self, job: Job) -> Job:
        """Removes a job and returns its last version."""
        last = job.but(changed=self._clock())
        self._store.forget(last, CANCELLED if job.state.is_open else CLEARED)
        self._open.pop(job.id, None)
        self.queue.remove(job.id)
        self.unseen.discard(job.id)
        self._store.after_sync(partial(self._on_remove.notify, last))
        return last

    def _keep(self, job: Job, trigger: Trigger | None, comment: str) -> Job:
        stamped = job.model_copy(update={"changed": self._clock()})
        self._store.keep(stamped, trigger, comment)
        return self._show(stamped)

    def _show(self, job: Job) -> Job:
        if job.state.is_open:
            self._open[job.id] = job
        else:
            self._open.pop(job.id, None)
        self.queue.put(job)
        if _is_unseen(job):
            self.unseen.add(job.id)
        else:
            self.unseen.discard(job.id)
        self._store.after_sync(partial(self._listeners.notify, job))
        return job


def _is_unseen(job: Job) -> bool:
    """Returns True if the job itself holds the question because no task runs for it any more."""
    return job.state is JobState.INTERRUPTED and bool(job.choices) and job.question is None


class OpenJobs(Mapping[str, Job]):
    """The jobs that are not over. Iteration uses a snapshot.

    Args:
        jobs: The underlying dictionary, changed by its owner.
    """

    def __init__(self, jobs: dict[str, Job]) -> None:
        self._jobs = jobs

    def __getitem__(self, job: str) -> Job:
        return self._jobs[job]

    def __len__(self) -> int:
        return len(self._jobs)

    def __iter__(self) -> Iterator[str]:
        return iter(self._jobs.copy())

    def keys(self) -> KeysView[str]:
        """Returns their ids."""
        return self._jobs.copy().keys()

    def values(self) -> ValuesView[Job]:
        """Returns the jobs."""
        return self._jobs.copy().values()

    def items(self) -> ItemsView[str, Job]:
        """Returns ids and jobs."""
        return self._jobs.copy().items()


class AllJobs(Mapping[str, Job]):
    """All jobs that were not removed; those that are over are read from the file each time.

    Args:
        open: Those that are not over.
        store: Where all are kept.
    """

    def __init__(self, open: Mapping[str, Job], store: JobStore) -> None:  # noqa: A002 - the natural name here
        self._open = open
        self._store = store

    def __getitem__(self, job: str) -> Job:
        found = self._open.get(job) or self._store.job(job)
        if found is None:
            raise KeyError(job)
        return found

    def __len__(self) -> int:
        return len(self._store)

    def __iter__(self) -> Iterator[str]:
        return iter(self._store.ids())
