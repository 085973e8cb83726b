"""The open jobs in memory: a cache of the job store that notifies listeners, with the queue of those that wait."""

from __future__ import annotations

import math
import threading
from bisect import bisect_left, bisect_right, insort
from collections.abc import Callable, Iterable, Iterator, Mapping, ValuesView
from contextlib import contextmanager
from functools import partial
from operator import itemgetter
from typing import Any

from skiros_py.listeners import Listeners
from skiros_py.tasks.jobs.job import Job, JobOrder, JobState, Trigger, next_state
from skiros_py.tasks.jobs.store import CANCELLED, CLEARED, JobStore, Receipt


class Guard:
    """The lock held while a job is changed.

    A command waits for the disk after releasing it; the control thread does so in lockstep only.

    Regardless of the number of concurrent commands, the control cycle waits for at most one of them: the others wait
    on a second lock. With a single lock the cycle waited ten times as long.

    Args:
        flush: Waits for the disk.
        lockstep: True if simulated time stands still meanwhile.
    """

    def __init__(self, flush: Callable[[], None], *, lockstep: bool) -> None:
        self._flush = flush
        self._lockstep = lockstep
        self._door = threading.Lock()
        self._room = threading.RLock()
        self._holder: int | None = None

    @contextmanager
    def command(self, *, waits: bool = True) -> Iterator[None]:
        """Holds the lock for a command; reentrant, since listeners may issue commands.

        Args:
            waits: False not to wait for the disk afterwards.
        """
        if self._holder == threading.get_ident():
            yield
            return
        with self._door, self._inside():
            yield
        if waits:
            self._flush()

    def flush(self) -> None:
        """Waits for the disk, unless this thread holds the lock, which others may need for that."""
        if self._holder != threading.get_ident():
            self._flush()

    @contextmanager
    def control(self) -> Iterator[None]:
        """Holds the lock for the control thread."""
        with self._inside():
            yield
        if self._lockstep:
            self._flush()

    @contextmanager
    def _inside(self) -> Iterator[None]:
        with self._room:
            outer, self._holder = self._holder, threading.get_ident()
            try:
                yield
            finally:
                self._holder = outer


_Rank = tuple[int, float, int]
_Entry = tuple[float, _Rank, str]
"""When a job may start [s since 1970], its rank, its id."""

_opening: Callable[[_Entry], float] = itemgetter(0)
_rank: Callable[[_Entry], _Rank] = itemgetter(1)


class JobQueue:
    """The jobs that start by themselves; used by any thread, never waits for the disk.

    The higher priority comes first; of equal priority the earlier deadline; then the earlier order.

    Args:
        jobs: The jobs that are already waiting.
    """

    def __init__(self, jobs: Iterable[Job] = ()) -> None:
        self._guard = threading.Lock()
        self._entries: dict[str, _Entry] = {}
        self._ready: list[_Entry] = []  # in the order of their ranks
        self._gated: list[_Entry] = []  # in the order in which they may start
        for job in jobs:
            self.put(job)

    def put(self, job: Job) -> None:
        """Updates a job with its current version, whether it is waiting or not."""
        with self._guard:
            self._remove(job.id)
            if job.state is JobState.ALLOWED_TO_START:
                gate = job.order.not_before
                entry = self._entries[job.id] = -math.inf if gate is None else gate.timestamp(), rank(job), job.id
                insort(self._gated, entry)

    def remove(self, job: str) -> None:
        """Forgets a job."""
        with self._guard:
            self._remove(job)

    def next(self, now: float) -> str | None:
        """Returns the id of the job that comes next, or None when none may start now.

        Args:
            now: Wall time [s since 1970].
        """
        with self._guard:
            due = bisect_right(self._gated, now, key=_opening)
            for entry in self._gated[:due]:
                insort(self._ready, entry, key=_rank)
            del self._gated[:due]
            return next((job for opening, _, job in self._ready if opening <= now), None)  # the clock may be set back

    def _remove(self, job: str) -> None:
        entry = self._entries.pop(job, None)
        if entry is not None:
            at = bisect_left(self._gated, entry)
            if self._gated[at : at + 1] == [entry]:
                del self._gated[at]
            else:
                del self._ready[bisect_left(self._ready, entry[1], key=_rank)]


def rank(job: Job) -> _Rank:
    """Returns the sort key of a job: the smallest comes first."""
    deadline = job.order.deadline
    return -job.order.priority, math.inf if deadline is None else deadline.timestamp(), job.number


class JobBook:
    """The jobs of a store.

    Every change outlives a power cut before listeners are called with it; they are called in a thread of the store.
    Writers hold the job manager's guard. Finished jobs are in the file only: over months there are too many for
    memory.

    Args:
        store: Where the jobs are stored.
        clock: Gives the wall time [s since 1970].

    Attributes:
        store: Where the jobs are stored.
        clock: Gives the wall time [s since 1970].
        open: The jobs that are not over, by id, in the order in which they were ordered.
        queue: Those that wait for their turn.
        unseen: Ids of those that were cut off (by the end of the program) or halted, and not reviewed since.
    """

    def __init__(self, store: JobStore, clock: Callable[[], float]) -> None:
        self.store = store
        self.clock = clock
        self._open = {job.id: job for job in store.open()}
        self._listeners = Listeners[[Job]]("jobs")
        self.open = OpenJobs(self._open)
        self.queue = JobQueue(self._open.values())
        self.unseen = {job.id for job in self._open.values() if _is_unseen(job)}
        self._on_remove = Listeners[[Job]]("removed jobs")

    def subscribe(self, listener: Callable[[Job], None]) -> Callable[[], None]:
        """Calls the listener with every new version of a job; returns how to unsubscribe. It must be quick."""
        return self._listeners.add(listener)

    def on_remove(self, listener: Callable[[Job], None]) -> Callable[[], None]:
        """Calls the listener with each job that is removed; returns how to unsubscribe. It must be quick."""
        return self._on_remove.add(listener)

    def find(self, job: str) -> Job | None:
        """Returns a job, open or over; None if there is none with that id."""
        return self.open.get(job) or self.store.job(job)

    def add(self, order: JobOrder, *, start: bool, comment: str, receipt: Receipt | None = None) -> Job:
        """Stores a job for a new order; :meth:`show` makes it known, once it is committed."""
        state = JobState.ALLOWED_TO_START if start else JobState.NOT_ALLOWED_TO_START
        detail = "queued" if start else "waits for leave to start"
        now = self.clock()
        job = Job(order=order, number=0, state=state, detail=detail, ordered=now, changed=now)
        trigger = Trigger.START if start else Trigger.STORE
        return self.store.add(job, trigger, comment, receipt)

    def note(self, receipt: Receipt, job: Job) -> None:
        """Records that a request led to an existing job."""
        self.store.note(receipt, job, self.clock())

    def move(self, job: Job, trigger: Trigger, comment: str = "", **changes: Any) -> Job:
        """Changes a job's state and related fields.

        Raises:
            WrongState: The trigger is not allowed in its state.
        """
        return self.move_at(None, job, trigger, comment, **changes)

    def move_at(self, wall: float | None, job: Job, trigger: Trigger, comment: str = "", **changes: Any) -> Job:
        """Changes a job's state and related fields.

        Args:
            wall: When that was, if it could not be stored then [s since 1970]; None for now.
            job: The job.
            trigger: What led to it.
            comment: Why.
            **changes: The fields.

        Raises:
            WrongState: The trigger is not allowed in its state.
        """
        state = next_state(job.state, trigger)
        ended = {} if state.is_open else {"ended": self.clock(), "seen": None}
        return self._keep(job.but(**{"state": state, **changes, **ended}), trigger, comment, wall)

    def change(self, job: Job) -> Job:
        """Stores a new version of a job with unchanged state."""
        return self._keep(job, None, "")

    def remove(self, job: Job) -> Job:
        """Removes a job and returns its last version."""
        last = job.but(changed=self.clock())
        self.store.forget(last, CANCELLED if job.state.is_open else CLEARED)
        self._open.pop(job.id, None)
        self.queue.remove(job.id)
        self.unseen.discard(job.id)
        self.store.after_sync(partial(self._on_remove.notify, last))
        return last

    def _keep(self, job: Job, trigger: Trigger | None, comment: str, wall: float | None = None) -> Job:
        stamped = job.model_copy(update={"changed": self.clock()})
        self.store.keep(stamped, trigger, comment, wall)
        self.show(stamped)
        return stamped

    def show(self, *jobs: Job) -> None:
        """Makes the current versions of jobs known, which are committed."""
        for job in jobs:
            if job.state.is_open:
                self._open[job.id] = job
            else:
                self._open.pop(job.id, None)
            self.queue.put(job)
            if _is_unseen(job):
                self.unseen.add(job.id)
            else:
                self.unseen.discard(job.id)
        self.announce(*jobs)

    def announce(self, *jobs: Job) -> None:
        """Notifies the listeners of jobs, once everything written so far is on disk or that has failed."""

        def tell() -> None:
            for job in jobs:
                self._listeners.notify(job)

        self.store.after_sync(tell)


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

    def values(self) -> ValuesView[Job]:
        """Returns the jobs."""
        return self._jobs.copy().values()
