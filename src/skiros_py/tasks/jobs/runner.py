"""Runs jobs in the control thread: starts them in turn, tracks them and applies commands."""

from __future__ import annotations

import logging
import time
from collections import deque
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, ParamSpec

from skiros_py.errors import DiskFault, SkirosError
from skiros_py.execution.running import RunningModule
from skiros_py.execution.runtime import Runtime
from skiros_py.messages import Message, joined
from skiros_py.skills.conditions import Condition
from skiros_py.tasks.context import Mode
from skiros_py.tasks.handle import TaskHandle
from skiros_py.tasks.jobs.job import Intent, Job, JobState, Outcome, Transition, Trigger
from skiros_py.tasks.jobs.queue import Guard, JobBook, rank
from skiros_py.tasks.jobs.run import BY_HAND, CUT_OFF, WAITS, JobRun, done_by_hand, hold_what_was_halted, moved
from skiros_py.tasks.task_manager import TaskManager

_log = logging.getLogger(__name__)

P = ParamSpec("P")

ReadGoal = Callable[[Sequence[str]], tuple[Condition, ...]]
"""Reads goal texts."""

_MOST_ASIDE = 20
"""How many jobs waiting for a user may be set aside for others; further ones keep their slots until one is answered."""

_BETWEEN_TRIES = 1.0
"""Wall time between two attempts to write to a disk that could not be written [s]."""


class JobRunner:
    """Runs jobs, up to a maximum number at a time.

    A job that waits for a user keeps its slot only while it holds a device or a thing. Otherwise the next job gets the
    slot; once answered, the waiting job resumes before all others as soon as a slot is free. A job that was cut off by
    the end of the program, or halted, has no slot; when resumed, it waits for its turn.

    Args:
        tasks: Plans and executes.
        runtime: Where jobs run.
        book: The current jobs.
        parse: Reads goal texts.
        guard: Held while a job changes. A command holds it while it waits for the disk, so the control cycle acquires
            it only when there is something to write.
        at_once: How many jobs may run at the same time.

    Attributes:
        fault: Why the disk cannot be written; empty if it can. Everything is paused meanwhile, and resumes by itself.
    """

    def __init__(
        self, tasks: TaskManager, runtime: Runtime, book: JobBook, parse: ReadGoal, guard: Guard, *, at_once: int
    ) -> None:
        self._tasks = tasks
        self._runtime = runtime
        self._book = book
        self._parse = parse
        self._guard = guard
        self._at_once = at_once
        self._runs: dict[str, JobRun] = {}
        self._back: dict[str, None] = {}  # started jobs that wait like any other: others may use their robots by now
        self._requests: deque[Callable[[], None]] = deque()
        self.fault = ""
        self._next_try = 0.0
        self._held: set[str] = set()
        self._held_since = 0.0
        self._paused: list[TaskHandle | RunningModule] = []

    # ------------------------------------------------------------------ asked in any thread, with the guard

    @property
    def idle(self) -> bool:
        """True if no job is running and none would start now."""
        return not (self._runs or self._requests) and self._coming is None

    def run(self, job: str) -> JobRun | None:
        """Returns the run of a job; None if it has none."""
        return self._runs.get(job)

    def schedule(self, method: Callable[P, None], *args: P.args, **kwargs: P.kwargs) -> None:
        """Schedules a call of one of the methods below in the control thread."""
        self._requests.append(partial(method, *args, **kwargs))

    # ------------------------------------------------------------------ in the control thread

    def attend(self) -> None:
        """Executes scheduled requests, tracks running jobs and starts the next ones.

        While the disk cannot be written, everything stands still: no step starts whose intent is not stored, and what
        could not be stored is stored as soon as there is room.
        """
        try:
            if not self.fault:
                self._attend()
                if (fault := self._book.store.fault) is not None:
                    raise fault
            elif time.monotonic() >= self._next_try:
                self._runtime.world.log.flush()
                self._book.store.probe()
                self._attend()
                self._resume_held()
        except DiskFault as fault:
            self._hold_for(fault)
        if self.fault:
            self._pause_all()

    def _hold_for(self, fault: DiskFault) -> None:
        self._next_try = time.monotonic() + _BETWEEN_TRIES
        if not self.fault:
            _log.error("everything is paused until the disk can be written: %s", fault)
            self.fault = joined(": ", (fault.path.name, fault.reason))
            self._held_since = self._book.clock()
            self._held |= {job for job in self._runs if self._book.open[job].state is JobState.RUNNING}
            for id_ in self._held:
                self._book.announce(self.held(self._book.open[id_]))

    def _pause_all(self) -> None:
        """Pauses running tasks and modules, also those that were started since."""
        modules = (run for manager in self._runtime.managers.values() for run in manager.running.values())
        for module in modules:
            if module.status == "running":
                self._paused.append(module)
                module.pause()
        for task in self._tasks.active:
            if task.control.mode is Mode.RUN:
                self._paused.append(task)
                task.pause()

    def _resume_held(self) -> None:
        """Records that jobs were held, and resumes everything that was paused.

        Raises:
            DiskFault: The disk is full again.
        """
        for id_ in tuple(self._held):
            job = self._book.open.get(id_)
            if job is not None and job.state is JobState.RUNNING:
                held = self.held(job).detail
                job = self._book.move_at(self._held_since, job, Trigger.HOLD, self.fault, detail=held)
            if job is not None and job.state is JobState.INTERRUPTED and not job.choices:
                self._book.move(job, Trigger.RESUME, Message("the disk can be written again"), detail="goes on")
            self._held.remove(id_)
        _log.warning("the disk can be written again: everything goes on")
        self.fault = ""
        while self._paused:
            self._paused.pop().resume()

    def held(self, job: Job) -> Job:
        """Returns a job as it is shown: a running one is held while the disk cannot be written."""
        if job.id not in self._held or job.state is not JobState.RUNNING:
            return job
        detail = Message("held: {fault}; it goes on by itself", fault=self.fault)
        return job.model_copy(update={"state": JobState.INTERRUPTED, "detail": detail})

    def unstored(self, job: Job) -> tuple[Transition, ...]:
        """Returns the changes of a job's state that cannot be stored yet."""
        held = self.held(job)
        if held is job:
            return ()
        hold = Trigger.HOLD.value
        return (Transition(wall=self._held_since, trigger=hold, state=held.state, comment=self.fault),)

    def _attend(self) -> None:
        while self._requests:
            request = self._requests.popleft()
            try:
                request()
            except DiskFault:
                self._requests.appendleft(request)
                raise
        for job, run in tuple(self._runs.items()):
            self._follow(job, run)
        if self._runtime.cycle.halted:
            self._hold_what_comes_back()
        else:
            self._give_places()

    def command(self, id_: str, what: Callable[[JobRun], None]) -> None:
        """Applies a command to a job's run, if it still has one."""
        if id_ in self._runs:
            what(self._runs[id_])

    def resume(self, id_: str) -> None:
        """Resumes a paused job; if it has no run, it is replanned when its turn comes."""
        with self._guard.control():
            if id_ in self._runs:
                self._runs[id_].resume()
            else:
                self._back[id_] = None

    def note_done(self, id_: str, by: str) -> None:
        """Applies the effects of a cut-off step that the user reports as done by hand."""
        with self._guard.control():
            job = self._book.open.get(id_)
            if job is None or job.state is not JobState.INTERRUPTED or id_ in self._runs:  # changed meanwhile
                return
            before = self._runtime.world.version
            try:
                for intent in self._cut_off(id_):
                    done_by_hand(self._runtime.world, self._tasks.skills, intent, by)
                    self._book.store.settle(id_, intent.number, Message("done by hand, says {by}", by=by))
            except SkirosError as error:
                detail = Message("that it was done by hand cannot be believed: {error}; answer again", error=error)
                self._book.change(job.but(detail=detail))
                return
            materials = moved(self._runtime.world, job.but(seen=before), self._book.store.intents(id_))
            goes_on = {"detail": WAITS, "choices": (), "question": None, "materials": materials}
            self._book.move(job, Trigger.RESUME, Message("{choice}, says {by}", choice=BY_HAND, by=by), **goes_on)
            self._back[id_] = None

    def _give_places(self) -> None:
        """Gives free slots to set-aside jobs that have their answer, then to the next job."""
        for run in self._runs.values():
            if run.aside and not run.asks and self._has_room:
                run.take_place()
        if self._coming is not None and (self._has_room or self._make_room()):
            self._dispatch()

    @property
    def _coming(self) -> Job | None:
        """The job whose turn it is.

        While a cut-off or halted job has not been reviewed, no new one is started: where the robot is and what it
        holds is equally uncertain for that one. Jobs that have their answer continue.
        """
        new = None if self._book.unseen else self._book.queue.next(self._book.clock())
        first = None if new is None else self._book.open.get(new)
        back = min(self._coming_back, key=rank, default=None)
        if back is None or first is None:
            return back or first
        return back if back.order.priority >= first.order.priority else first

    @property
    def _coming_back(self) -> tuple[Job, ...]:
        """The started jobs waiting to be resumed, without those paused or ended meanwhile; there are few."""
        jobs = (self._book.open.get(id_) for id_ in tuple(self._back))
        return tuple(job for job in jobs if job is not None and job.state is JobState.RUNNING)

    @property
    def _has_room(self) -> bool:
        return sum(not run.aside for run in self._runs.values()) < self._at_once

    def _make_room(self) -> bool:
        """Sets aside one job that waits for a user and holds no device or thing, so that others need not wait.

        Returns:
            True if there was one.
        """
        aside = sum(run.aside for run in self._runs.values())
        for job, run in self._runs.items() if aside < _MOST_ASIDE else ():
            if run.asks and not run.aside and not self._tasks.holds(job):
                run.set_aside()
                return True
        return False

    def _follow(self, job: str, run: JobRun) -> None:
        run.write_trace()
        if run.has_news:
            with self._guard.control():
                if run.follow(self._book.open[job]):
                    del self._runs[job]

    def _dispatch(self) -> None:
        with self._guard.control():
            job = self._coming
            if job is None:  # changed meanwhile
                return
            if job.state is JobState.RUNNING:
                self._begin(self._book.change(job.but(**self._begun(job))))
            elif job.order.expires and job.order.deadline and job.order.deadline.timestamp() < self._book.clock():
                self._book.move(
                    job, Trigger.FAIL, Message("its deadline has passed"), outcome=Outcome.EXPIRED, detail=""
                )
            else:
                self._begin(self._book.move(job, Trigger.DISPATCH, started=self._book.clock(), **self._begun(job)))

    def _begun(self, job: Job) -> dict[str, Any]:
        """Returns the fields that change when a job starts; they are written together to wait for the disk once."""
        return {"detail": "planning", "attempts": job.attempts + 1, "seen": self._runtime.world.version}

    def _hold_what_comes_back(self) -> None:
        while self._coming_back:
            with self._guard.control():
                for job in self._coming_back:
                    self._begin(job)

    def _begin(self, job: Job) -> None:
        self._back[job.id] = None  # until it is stored what becomes of it
        if self._runtime.cycle.halted:
            hold_what_was_halted(self._book, job, self._runtime.cycle.halted)
        else:
            for intent in self._cut_off(job.id):
                self._book.store.settle(job.id, intent.number, CUT_OFF)
            self._start(job)
        del self._back[job.id]

    def _start(self, job: Job) -> None:
        try:
            goal = self._parse(job.order.goal)
            task = self._tasks.begin(goal, name=job.id, policy=job.order.policy)
        except SkirosError as error:
            self._book.move(job, Trigger.FAIL, outcome=Outcome.FAILED, reasons=(str(error),), detail="")
        else:
            self._runs[job.id] = JobRun(task, self._runtime, self._book)

    def _cut_off(self, job: str) -> tuple[Intent, ...]:
        """Returns the steps whose outcome is unknown."""
        return tuple(intent for intent in self._book.store.intents(job) if intent.ended is None)
