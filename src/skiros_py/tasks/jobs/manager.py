"""Takes job orders, lets them run one after the other, and keeps what is known of them over restarts.

Commands may come from any thread: they are checked and written down at once, and take effect at the end of the present
control cycle. What runs is touched in the control thread only.
"""

from __future__ import annotations

import math
import threading
import time
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

from skiros_py.errors import SkirosError, UnknownName, UsageError
from skiros_py.execution.station import Station
from skiros_py.skills.conditions import Condition
from skiros_py.tasks.jobs.book import JobBook
from skiros_py.tasks.jobs.by_hand import done_by_hand
from skiros_py.tasks.jobs.cut_off import ABORT, BY_HAND, CUT_OFF, hold_what_was_cut_off, hold_what_was_halted
from skiros_py.tasks.jobs.job import Intent, Job, JobOrder, Outcome, Transition
from skiros_py.tasks.jobs.queue import next_job, next_opening
from skiros_py.tasks.jobs.run import JobRun
from skiros_py.tasks.jobs.states import JobState, Trigger
from skiros_py.tasks.jobs.store import JobStore
from skiros_py.tasks.task_manager import TaskManager

__all__ = ["JobManager"]


class JobManager:
    """The queue of jobs of one station.

    Args:
        tasks: Plans and does.
        station: What it does it with.
        store: Where jobs are kept; whoever made it closes it.
        parse: Reads goal texts.
        at_once: How many jobs may be under way at the same time.
        clock: Gives the wall time [s since 1970].
    """

    def __init__(
        self,
        tasks: TaskManager,
        station: Station,
        store: JobStore,
        parse: Callable[[Sequence[str]], tuple[Condition, ...]],
        *,
        at_once: int = 1,
        clock: Callable[[], float] = time.time,
    ) -> None:
        self._tasks = tasks
        self._station = station
        self._store = store
        self._parse = parse
        self._at_once = at_once
        self._clock = clock
        self._guard = threading.RLock()
        self._book = JobBook(store, clock)
        self._runs: dict[str, JobRun] = {}
        self._wishes: deque[Callable[[], None]] = deque()
        self._looked, self._opening = -1, math.inf
        hold_what_was_cut_off(self._book, store)
        station.cycle.observe(self._attend)

    # ------------------------------------------------------------------ looking

    @property
    def jobs(self) -> Mapping[str, Job]:
        """All jobs that were not cleared, by id, in the order in which they were ordered."""
        return self._book.jobs

    @property
    def idle(self) -> bool:
        """True when nothing is under way, and nothing would start by itself now."""
        return not (self._runs or self._wishes) and next_job(self._book.jobs.values(), self._clock()) is None

    def intents(self, job: str) -> tuple[Intent, ...]:
        """Returns the steps that were begun for a job, in order, and how they ended.

        Raises:
            UnknownName: There is no such job.
        """
        return self._store.intents(self._job(job).id)

    def transitions(self, job: str) -> tuple[Transition, ...]:
        """Returns a job's changes of state, in order, with who wanted them.

        Raises:
            UnknownName: There is no such job.
        """
        return self._store.transitions(self._job(job).id)

    def trace(self, job: str) -> tuple[Mapping[str, Any], ...]:
        """Returns what happened for a job, as plain data, in order; the last second of what runs may be missing.

        Raises:
            UnknownName: There is no such job.
        """
        return self._store.trace(self._job(job).id)

    def subscribe(self, listener: Callable[[Job], None]) -> Callable[[], None]:
        """Calls the listener with every new version of a job, in the thread that made it; returns how to end that."""
        return self._book.subscribe(listener)

    # ------------------------------------------------------------------ ordering

    def submit(self, order: JobOrder, *, start: bool = True, comment: str = "") -> Job:
        """Takes an order; when this returns, it is on the disk.

        Args:
            order: What is wanted. The very same order once more changes nothing.
            start: True where it may start by itself when its turn comes.
            comment: Why, for the record.

        Raises:
            UsageError: Its goal cannot be understood, or there is another order of that id.
        """
        self._parse(order.goal)
        with self._guard:
            known = self._book.jobs.get(order.id)
            if known is not None and known.order != order:
                raise UsageError(
                    f"job '{order.id}' is there already, with another order: update that, or take another id"
                )
            return known or self._book.add(order, start=start, comment=comment)

    def update(self, order: JobOrder, comment: str = "") -> Job:
        """Orders something else under the id of a job that has not begun.

        Raises:
            UnknownName: There is no such job.
            UsageError: It has begun, or its goal cannot be understood.
        """
        self._parse(order.goal)
        return self._move(order.id, Trigger.UPDATE, comment, order=order)

    # ------------------------------------------------------------------ commands

    def start(self, job: str, comment: str = "") -> Job:
        """Gives a job leave to start; one that has it already is left alone."""
        if self._job(job).state is JobState.ALLOWED_TO_START:
            return self._job(job)
        return self._move(job, Trigger.START, comment, detail="queued")

    def revoke_start(self, job: str, comment: str = "") -> Job:
        """Takes back the leave to start."""
        if self._job(job).state is JobState.NOT_ALLOWED_TO_START:
            return self._job(job)
        return self._move(job, Trigger.REVOKE_START, comment, detail="waits for leave to start")

    def pause(self, job: str, comment: str = "") -> Job:
        """Lets a job come to a standstill where it is."""
        with self._guard:
            if self._job(job).state is JobState.INTERRUPTED:
                self._wish(job, JobRun.pause)  # what waits for an answer shall stand when that has come
                return self._job(job)
            changed = self._move(job, Trigger.PAUSE, comment, detail="paused")
            self._wish(job, JobRun.pause)
            return changed

    def resume(self, job: str, comment: str = "") -> Job:
        """Goes on with a job that stands; one that was cut off is planned anew from what is believed now.

        Raises:
            UnknownName: There is no such job.
            UsageError: It waits for an answer, or everything is halted, or it does not stand.
        """
        with self._guard:
            now = self._job(job)
            if now.state is JobState.RUNNING:
                return now
            if job in self._runs and self._runs[job].asks:
                raise UsageError(f"job '{job}' waits for an answer: {', '.join(now.choices)}")
            self._require_ready(job)
            changed = self._move(job, Trigger.RESUME, comment, detail="goes on", choices=(), question=None)
            self._wishes.append(partial(self._go_on, job))
            return changed

    def stop(self, job: str, comment: str = "") -> Job:
        """Ends a job that is under way; it is over when everything it moved stands."""
        return self._end(job, Trigger.STOP, Outcome.STOPPED, comment)

    def abort(self, job: str, comment: str = "") -> Job:
        """Gives a job up, begun or not."""
        return self._end(job, Trigger.ABORT, Outcome.ABORTED, comment)

    def cancel(self, job: str) -> None:
        """Removes a job that has not begun.

        Raises:
            UnknownName: There is no such job.
            UsageError: It has begun.
        """
        with self._guard:
            state = self._job(job).state
            if not state.is_open or state.has_begun:
                raise UsageError(f"job '{job}' has begun: stop or abort it, then clear it")
            self._book.remove(job)

    def clear(self, job: str) -> None:
        """Removes a job that is over, with all that is known of it.

        Raises:
            UnknownName: There is no such job.
            UsageError: It is not over.
        """
        with self._guard:
            if self._job(job).state.is_open:
                raise UsageError(f"job '{job}' is not over: stop, abort or cancel it")
            self._book.remove(job)

    def answer(self, job: str, choice: str, *, by: str) -> Job:
        """Answers what a job waits for.

        Args:
            job: Its id.
            choice: One of its :attr:`Job.choices`.
            by: Who answers.

        Raises:
            UnknownName: There is no such job, or it does not offer that choice.
            UsageError: It asks something else by now, or everything is halted.
        """
        with self._guard:
            now = self._job(job)
            if choice not in now.choices:
                raise UnknownName("answer", choice, now.choices, where=f"of job '{job}'")
            if job in self._runs:
                self._runs[job].answer(choice, by=by, asked=now.question)
                return now
            if choice == ABORT:
                return self.abort(job, f"answered by {by}")
            self._require_ready(job)
            if choice == BY_HAND:
                self._wishes.append(partial(self._note_done, job, by))
                return now
            return self.resume(job, f"{choice}, says {by}")

    def _end(self, job: str, trigger: Trigger, outcome: Outcome, comment: str) -> Job:
        with self._guard:
            now = self._job(job)
            if now.outcome is outcome or (job in self._runs and self._runs[job].ending is outcome):
                return now
            if job not in self._runs:
                return self._move(job, trigger, comment, outcome=outcome, detail="", choices=())
            self._book.check(now, trigger)
            run = self._runs[job]
            run.end_as(trigger, outcome, comment)
            self._wish(job, JobRun.stop)
            return self._book.change(now.but(detail=f"is being {outcome.value}"))

    def _require_ready(self, job: str) -> None:
        halted = self._station.cycle.halted
        if halted:
            raise UsageError(f"job '{job}' cannot go on: everything is halted ({halted}); look, reset, then answer")

    def _wish(self, job: str, what: Callable[[JobRun], None]) -> None:
        """Has something done to what runs for a job, in the control thread."""

        def fulfil() -> None:
            if job in self._runs:
                what(self._runs[job])

        self._wishes.append(fulfil)

    def _move(self, job: str, trigger: Trigger, comment: str = "", **changes: object) -> Job:
        with self._guard:
            return self._book.move(self._job(job), trigger, comment, **changes)

    def _job(self, job: str) -> Job:
        if job not in self._book.jobs:
            raise UnknownName("job", job, self._book.jobs)
        return self._book.jobs[job]

    # ------------------------------------------------------------------ in the control thread

    def _attend(self) -> None:
        """Does what was asked for, follows what runs, and begins what is next."""
        while self._wishes:
            self._wishes.popleft()()
        for job, run in tuple(self._runs.items()):
            self._follow(job, run)
        if len(self._runs) < self._at_once and not self._station.cycle.halted and self._may_have_changed():
            jobs, now = self._book.jobs.values(), self._clock()
            coming = next_job(jobs, now)
            if coming is not None:
                self._dispatch(coming)
            else:
                self._looked, self._opening = self._book.version, next_opening(jobs, now)

    def _may_have_changed(self) -> bool:
        """Tells whether a job may start now that could not when that was last looked at."""
        return self._book.version != self._looked or self._clock() >= self._opening

    def _follow(self, job: str, run: JobRun) -> None:
        with self._guard:
            if run.follow(self._job(job)):
                del self._runs[job]

    def _dispatch(self, job: Job) -> None:
        with self._guard:
            if self._book.jobs.get(job.id) != job:  # somebody was quicker
                return
            if job.order.expires and job.order.deadline and job.order.deadline.timestamp() < self._clock():
                self._move(job.id, Trigger.FAIL, "its deadline has passed", outcome=Outcome.EXPIRED, detail="")
                return
            self._begin(self._move(job.id, Trigger.DISPATCH, detail="planning", started=self._clock()))

    def _go_on(self, job: str) -> None:
        with self._guard:
            if job in self._runs:
                self._runs[job].resume()
            elif self._job(job).state is JobState.RUNNING:
                self._begin(self._job(job))

    def _begin(self, job: Job) -> None:
        if self._station.cycle.halted:
            hold_what_was_halted(self._book, job, self._station.cycle.halted)
            return
        for intent in self._cut_off(job.id):
            self._store.settle(job.id, intent.number, CUT_OFF)
        try:
            goal = self._parse(job.order.goal)
            undertaking = self._tasks.begin(goal, name=job.id, policy=job.order.policy)
        except SkirosError as error:
            self._move(job.id, Trigger.FAIL, outcome=Outcome.FAILED, reasons=(str(error),), detail="")
            return
        self._book.change(job.but(attempts=job.attempts + 1))
        self._runs[job.id] = JobRun(undertaking, self._station, self._book, self._store)

    def _note_done(self, job: str, by: str) -> None:
        """Believes what a person says they did in the place of the step that was cut off, and goes on."""
        with self._guard:
            now = self._book.jobs.get(job)
            if now is None or now.state is not JobState.INTERRUPTED or job in self._runs:  # somebody was quicker
                return
            try:
                for intent in self._cut_off(job):
                    done_by_hand(self._station.world, self._tasks.capabilities, intent, by)
                    self._store.settle(job, intent.number, f"done by hand, says {by}")
                self.resume(job, f"{BY_HAND}, says {by}")
            except SkirosError as error:
                self._book.change(now.but(detail=f"that it was done by hand cannot be believed: {error}; answer again"))

    def _cut_off(self, job: str) -> tuple[Intent, ...]:
        """Returns the steps of which nobody knows how they ended."""
        return tuple(intent for intent in self._store.intents(job) if intent.ended is None)
