"""Accepts job orders, runs them in turn and keeps their records across restarts.

Commands may come from any thread: they are checked and stored at once and take effect at the end of the current
control cycle. Running tasks are accessed in the control thread only.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, ParamSpec, TypeVar

from skiros_py.errors import (
    Busy,
    DiskFault,
    FileError,
    Removed,
    SkirosError,
    StaleVersion,
    UnknownName,
    UsageError,
    WrongState,
)
from skiros_py.execution.runtime import Runtime
from skiros_py.messages import Message
from skiros_py.tasks.jobs.job import Intent, Job, JobOrder, JobState, Outcome, Transition, Trigger, next_state
from skiros_py.tasks.jobs.queue import Guard, JobBook
from skiros_py.tasks.jobs.run import ABORT, BY_HAND, WAITS, JobRun, hold_what_was_cut_off
from skiros_py.tasks.jobs.runner import JobRunner, ReadGoal
from skiros_py.tasks.jobs.store import JobStore, Receipt
from skiros_py.tasks.task_manager import TaskManager

T = TypeVar("T")
P = ParamSpec("P")

_MOST_OPEN = 50_000
_RETRY_AFTER = 30.0
"""Suggested retry delay when the queue is full [s]."""


@dataclass(frozen=True, slots=True)
class Submission:
    """An order for the queue.

    Attributes:
        order: The order. Submitting the same order again changes nothing.
        start: True if it may start by itself when its turn comes.
        comment: Why, for the record.
        receipt: Identifies the request: repeating it changes nothing, even under another order id.
        again: True to accept the order although a job with that id was removed before.
    """

    order: JobOrder
    start: bool = True
    comment: str = ""
    receipt: Receipt | None = None
    again: bool = False


class JobManager:
    """The queue of jobs of one runtime: takes orders, commands and answers.

    Repeating a command that has already taken effect changes nothing. Each command takes ``expects``: the
    :attr:`Job.version` the caller has seen, or None for any version. Each raises UnknownName if there is no such job,
    StaleVersion if it has changed since, and WrongState if the command is not allowed in the job's state.

    Args:
        tasks: Plans and executes.
        runtime: Where jobs run.
        store: Where jobs are stored; closed by its creator.
        parse: Reads goal texts.
        at_once: How many jobs may run at the same time.
        limit: How many jobs may be open at the same time.
        clock: Gives the wall time [s since 1970].

    Attributes:
        store: Pages of jobs, removed jobs, known requests, and announcements to forward.
        open: The jobs that are not over, by id, in the order in which they were ordered. Finished jobs are in the
            store: :meth:`find` reads one, :meth:`JobStore.page` many of them.
        limit: How many jobs may be open at the same time; may be set. Further orders are refused; existing jobs stay.
    """

    def __init__(
        self,
        tasks: TaskManager,
        runtime: Runtime,
        store: JobStore,
        parse: ReadGoal,
        *,
        at_once: int = 1,
        limit: int = _MOST_OPEN,
        clock: Callable[[], float] = time.time,
    ) -> None:
        self.store = store
        self._runtime = runtime
        self._guard = Guard(store.flush, lockstep=runtime.cycle.pace is None)
        self._book = JobBook(store, clock)
        self.open: Mapping[str, Job] = self._book.open
        self._runner = JobRunner(tasks, runtime, self._book, parse, self._guard, at_once=at_once)
        self.limit = limit
        self._parse = parse
        hold_what_was_cut_off(self._book, runtime.world)
        runtime.cycle.observe(self._runner.attend)

    @property
    def fault(self) -> str:
        """Why the disk cannot be written, so that everything is paused; empty if it can."""
        return self._runner.fault

    def shown(self, job: Job) -> Job:
        """Returns a job as readers see it: while the disk cannot be written, a running one is held."""
        return self._runner.held(self.open.get(job.id, job))

    @property
    def idle(self) -> bool:
        """True if no job is running and none would start now."""
        return self._runner.idle

    def find(self, job: str) -> Job | None:
        """Returns a job, open or over; None if there is none with that id."""
        return self._book.find(job)

    def job(self, job: str) -> Job:
        """Returns a job, open or over.

        Raises:
            UnknownName: There is no such job.
        """
        found = self._book.find(job)
        if found is None:
            raise UnknownName("job", job, self._book.open)
        return found

    def intents(self, job: str) -> tuple[Intent, ...]:
        """Returns the steps that were started for a job, in order, and how they ended.

        Raises:
            UnknownName: There is no such job.
        """
        return self.store.intents(self.job(job).id)

    def transitions(self, job: str) -> tuple[Transition, ...]:
        """Returns a job's state changes, in order, with their triggers.

        Raises:
            UnknownName: There is no such job.
        """
        return self.store.transitions(job) + self._runner.unstored(self.job(job))

    def trace(self, job: str) -> tuple[Mapping[str, Any], ...]:
        """Returns a job's trace as plain data, in order; the last second of a running job may be missing.

        Raises:
            UnknownName: There is no such job.
        """
        return self.store.trace(self.job(job).id).entries

    def subscribe(self, listener: Callable[[Job], None]) -> Callable[[], None]:
        """Calls the listener with every new version of a job, in the writing thread; returns how to unsubscribe."""
        return self._book.subscribe(listener)

    def on_remove(self, listener: Callable[[Job], None]) -> Callable[[], None]:
        """Calls the listener with each job that is cancelled or cleared, in the thread that did it."""
        return self._book.on_remove(listener)

    # ------------------------------------------------------------------ before the start

    def submit(
        self,
        order: JobOrder,
        *,
        start: bool = True,
        comment: str = "",
        receipt: Receipt | None = None,
        again: bool = False,
    ) -> Job:
        """Accepts an order; when this returns, it is on disk.

        The arguments are those of a :class:`Submission`.

        Returns:
            The job; for a known order or request, its current version.

        Raises:
            UsageError: Its goal cannot be understood.
            KeyReused: The receipt's key was used for another request.
            WrongState: There is another order of that id, or there was one.
            Removed: The same order came before, and its job was removed.
            Busy: Too many jobs are open.
            FileError: The stored job or request cannot be read, or the disk cannot be written.
        """
        (outcome,) = self.submit_all((Submission(order, start, comment, receipt, again),))
        self._guard.flush()
        if isinstance(outcome, Job):
            return outcome
        raise outcome

    def submit_all(self, wanted: Sequence[Submission]) -> list[Job | SkirosError]:
        """Accepts orders in one transaction; they are on disk after :meth:`JobStore.sync`.

        Returns:
            For each, its job as :meth:`submit` returns it, or the error that it raises.

        Raises:
            DiskFault: They cannot be stored; none was accepted.
        """
        checked = [_outcome(self._check, one) for one in wanted]
        outcomes: list[Job | SkirosError] = []
        added: list[Job] = []
        with self._guard.command(waits=False):
            with self.store.together():
                for one, found in zip(wanted, checked, strict=True):
                    outcomes.append(found if isinstance(found, SkirosError) else _outcome(self._add, one, added))
            if added:
                self._book.show(*added)
        return outcomes

    def _check(self, wanted: Submission) -> Job | None:
        """Checks an order without storing anything."""
        known = self._known(wanted)
        if known is None:  # otherwise its goal is not parsed again: the world has changed since
            self._parse(wanted.order.goal)
        return known

    def _add(self, wanted: Submission, added: list[Job]) -> Job:
        known = self._known(wanted)
        if known is not None:
            if wanted.receipt is not None and self.store.known(wanted.receipt) is None:
                self._book.note(wanted.receipt, known)
            return known
        if len(self.open) + len(added) >= self.limit:
            raise Busy(
                Message("{count} jobs are open, no more are taken: try again later", count=self.limit),
                retry_after=_RETRY_AFTER,
            )
        job = self._book.add(wanted.order, start=wanted.start, comment=wanted.comment, receipt=wanted.receipt)
        added.append(job)
        return job

    def _known(self, wanted: Submission) -> Job | None:
        """Returns the job of a repeated order or request; None if both are new."""
        order = wanted.order
        if wanted.receipt is not None and (before := self.store.known(wanted.receipt)) is not None:
            return before
        known = self._book.find(order.id)
        if known is None:
            _check_removed(order, None if wanted.again else self.store.removed(order.id))
        elif known.order != order:
            raise WrongState(
                "job '{job}' is there already, with another order: update that, or take another id", job=order.id
            )
        return known

    def update(self, order: JobOrder, comment: str = "", *, expects: int | None = None) -> Job:
        """Replaces the order of a job that has not started.

        Args:
            order: The new order. An identical order changes nothing.
            comment: Why, for the record.
            expects: The job's version, as seen.

        Raises:
            UnknownName: There is no such job.
            UsageError: Its goal cannot be understood.
            StaleVersion: It has changed since it was seen.
            WrongState: It has started.
        """
        self._parse(order.goal)
        with self._command(order.id, expects) as now:
            if now.order == order:
                return now
            return self._book.move(now, Trigger.UPDATE, comment, order=order)

    def start(self, job: str, comment: str = "", *, expects: int | None = None) -> Job:
        """Allows a job to start."""
        with self._command(job, expects) as now:
            if now.state is JobState.ALLOWED_TO_START:
                return now
            return self._book.move(now, Trigger.START, comment, detail="queued")

    def revoke_start(self, job: str, comment: str = "", *, expects: int | None = None) -> Job:
        """Revokes the permission to start."""
        with self._command(job, expects) as now:
            if now.state is JobState.NOT_ALLOWED_TO_START:
                return now
            return self._book.move(now, Trigger.REVOKE_START, comment, detail="waits for leave to start")

    def cancel(self, job: str, *, expects: int | None = None) -> Job:
        """Removes a job that has not started and returns its last version."""
        with self._command(job, expects) as now:
            if now.state.has_begun:
                raise WrongState("job '{job}' has begun: stop or abort it, then clear it", job=job)
            if not now.state.is_open:
                raise WrongState("job '{job}' has begun and is over: clear it", job=job)
            return self._book.remove(now)

    # ------------------------------------------------------------------ under way

    def pause(self, job: str, comment: str = "", *, expects: int | None = None) -> Job:
        """Pauses a job; one that waits for an answer pauses once the answer has arrived."""
        with self._command(job, expects) as now:
            if now.state is not JobState.INTERRUPTED:
                now = self._book.move(now, Trigger.PAUSE, comment, detail="paused")
            self._runner.schedule(self._runner.command, job, JobRun.pause)
            return now

    def resume(self, job: str, comment: str = "", *, expects: int | None = None) -> Job:
        """Resumes a paused job; a cut-off one is replanned when its turn comes.

        Raises:
            WrongState: It waits for an answer, the system is halted, or it is not paused.
        """
        with self._command(job, expects) as now:
            if now.state is JobState.RUNNING:
                return now
            run = self._runner.run(job)
            if run is not None and run.asks:
                raise WrongState("job '{job}' waits for an answer: {choices}", job=job, choices=", ".join(now.choices))
            self._require_ready(now)
            detail = WAITS if run is None else "goes on"
            changed = self._book.move(now, Trigger.RESUME, comment, detail=detail, choices=(), question=None)
            self._runner.schedule(self._runner.resume, job)
            return changed

    def answer(self, job: str, choice: str, *, by: str, expects: int | None = None) -> Job:
        """Answers a job's open question.

        Args:
            job: Its id.
            choice: One of its :attr:`Job.choices`.
            by: Who answers.
            expects: Its version, as seen.

        Raises:
            UnknownName: There is no such job, or it does not offer that choice.
            WrongState: Its question has changed, or the system is halted.
        """
        with self._command(job, expects) as now:
            if not now.choices:
                raise WrongState(
                    "job '{job}' waits for no answer, or not any more: it is {state}",
                    job=job,
                    state=now.state.name.lower(),
                )
            if choice not in now.choices:
                raise UnknownName("answer", choice, now.choices, where=f"of job '{job}'")
            run = self._runner.run(job)
            if run is not None:
                run.answer(choice, by=by, asked=now.question)
                return now
            if choice == ABORT:
                return self.abort(job, Message("answered by {by}", by=by))
            self._require_ready(now)
            if choice == BY_HAND:
                self._runner.schedule(self._runner.note_done, job, by)
                return now
            return self.resume(job, Message("{choice}, says {by}", choice=choice, by=by))

    # ------------------------------------------------------------------ the end

    def stop(self, job: str, comment: str = "", *, expects: int | None = None) -> Job:
        """Stops a running job; it is over once everything it moved is at rest."""
        return self._end(job, Trigger.STOP, Outcome.STOPPED, comment, expects)

    def abort(self, job: str, comment: str = "", *, expects: int | None = None) -> Job:
        """Aborts a job, started or not."""
        return self._end(job, Trigger.ABORT, Outcome.ABORTED, comment, expects)

    def clear(self, job: str, *, expects: int | None = None) -> Job:
        """Removes a finished job with all its records and returns its last version."""
        with self._command(job, expects) as now:
            if now.state.is_open:
                raise WrongState("job '{job}' is not over: stop, abort or cancel it", job=job)
            return self._book.remove(now)

    def _end(self, job: str, trigger: Trigger, outcome: Outcome, comment: str, expects: int | None) -> Job:
        with self._command(job, expects) as now:
            run = self._runner.run(job)
            if now.outcome is outcome or (run is not None and run.ending is outcome):
                return now
            if run is None:
                return self._book.move(now, trigger, comment, outcome=outcome, detail="", choices=(), question=None)
            next_state(now.state, trigger)  # raises if it is not allowed
            ending = self._book.change(now.but(detail=Message("is being {outcome}", outcome=outcome.value)))
            # Only now: what cannot be stored is refused, and then nothing happens.
            run.end_as(trigger, outcome, comment)
            self._runner.schedule(self._runner.command, job, JobRun.stop)
            return ending

    # ------------------------------------------------------------------ what must be so

    @contextmanager
    def _command(self, job: str, version: int | None) -> Iterator[Job]:
        """Gives the current job, if it has the expected version, while nothing else changes it."""
        with self._guard.command():
            now = self.job(job)
            if version is not None and now.version != version:
                seen = {"job": job, "version": now.version, "seen": version}
                raise StaleVersion(
                    Message(
                        "job '{job}' has changed: version {version}, not {seen} any more; look again, then decide",
                        **seen,
                    )
                )
            yield now

    def _require_ready(self, job: Job) -> None:
        halted = self._runtime.cycle.halted
        if halted:
            raise WrongState(
                "job '{job}' cannot go on: everything is halted ({why}); look, reset, then answer",
                job=job.id,
                why=halted,
            )


def _outcome(work: Callable[P, T], *args: P.args, **kwargs: P.kwargs) -> T | SkirosError:
    """Returns the result of a call, or why it was refused; a disk that cannot be written refuses all others too."""
    try:
        return work(*args, **kwargs)
    except DiskFault:
        raise
    except (UsageError, Busy, FileError) as error:
        return error


def _check_removed(order: JobOrder, last: Job | None) -> None:
    """Refuses an order that was done and removed before: it may be a late retry by a client that got no answer."""
    if last is None:
        return
    if last.order == order:
        said = {"job": order.id, "outcome": last.outcome or ""}
        raise Removed(
            "job '{job}' was removed ({outcome}), and its order is not taken twice: say that it is meant again", **said
        )
    raise WrongState("there was a job '{job}' with another order, and it was removed: take another id", job=order.id)
