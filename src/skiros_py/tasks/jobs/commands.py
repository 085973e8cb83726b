"""Commands to existing jobs from users and other systems, checked and stored at once; and queries about jobs."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from skiros_py.errors import StaleVersion, UnknownName, WrongState
from skiros_py.execution.runtime import Runtime
from skiros_py.tasks.jobs.book import Guard, JobBook
from skiros_py.tasks.jobs.conductor import Conductor
from skiros_py.tasks.jobs.job import Intent, Job, JobState, Outcome, Transition, Trigger, next_state
from skiros_py.tasks.jobs.run import ABORT, BY_HAND, WAITS, JobRun
from skiros_py.tasks.jobs.store import JobStore


class JobCommands:
    """Accepts commands; repeating a command that has already taken effect changes nothing. Answers questions.

    Each command takes ``expects``: the :attr:`Job.version` the caller has seen, or None for any version. Each raises
    UnknownName if there is no such job, StaleVersion if it has changed since, and WrongState if the command is not
    allowed in the job's state.

    Args:
        book: The current jobs.
        store: Where jobs are stored.
        runtime: Where they run.
        conductor: Runs them.
        guard: Held while a job changes.

    Attributes:
        store: Pages of jobs, removed jobs, known requests, and announcements to forward.
        jobs: All jobs that were not removed, by id, in the order in which they were ordered. Finished jobs are read
            from the file each time: use :meth:`JobStore.page` to read many of them.
        open: The jobs that are not over, by id, in the same order.
    """

    def __init__(self, book: JobBook, store: JobStore, runtime: Runtime, conductor: Conductor, guard: Guard) -> None:
        self.store = store
        self.jobs: Mapping[str, Job] = book.jobs
        self.open: Mapping[str, Job] = book.open
        self._book = book
        self._runtime = runtime
        self._conductor = conductor
        self._guard = guard

    def job(self, job: str) -> Job:
        """Returns a job, open or over.

        Raises:
            UnknownName: There is no such job.
        """
        found = self._book.jobs.get(job)
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
        return self.store.transitions(self.job(job).id)

    def trace(self, job: str, *, skip: int = 0, limit: int | None = None) -> tuple[Mapping[str, Any], ...]:
        """Returns a job's trace as plain data, in order; the last second of a running job may be missing.

        Args:
            job: Its id.
            skip: How many entries to skip at the beginning.
            limit: How many at most; None for all.

        Raises:
            UnknownName: There is no such job.
        """
        return self.store.trace(self.job(job).id, skip=skip, limit=limit)

    def subscribe(self, listener: Callable[[Job], None]) -> Callable[[], None]:
        """Calls the listener with every new version of a job, in the writing thread; returns how to unsubscribe."""
        return self._book.subscribe(listener)

    def on_remove(self, listener: Callable[[Job], None]) -> Callable[[], None]:
        """Calls the listener with each job that is cancelled or cleared, in the thread that did it."""
        return self._book.on_remove(listener)

    # ------------------------------------------------------------------ before the start

    def start(self, job: str, comment: str = "", *, expects: int | None = None) -> Job:
        """Allows a job to start."""
        with self._guard.command():
            now = self._expected(job, expects)
            if now.state is JobState.ALLOWED_TO_START:
                return now
            return self._book.move(now, Trigger.START, comment, detail="queued")

    def revoke_start(self, job: str, comment: str = "", *, expects: int | None = None) -> Job:
        """Revokes the permission to start."""
        with self._guard.command():
            now = self._expected(job, expects)
            if now.state is JobState.NOT_ALLOWED_TO_START:
                return now
            return self._book.move(now, Trigger.REVOKE_START, comment, detail="waits for leave to start")

    def cancel(self, job: str, *, expects: int | None = None) -> Job:
        """Removes a job that has not started and returns its last version."""
        with self._guard.command():
            now = self._expected(job, expects)
            if now.state.has_begun:
                raise WrongState(f"job '{job}' has begun: stop or abort it, then clear it")
            if not now.state.is_open:
                raise WrongState(f"job '{job}' has begun and is over: clear it")
            return self._book.remove(now)

    # ------------------------------------------------------------------ under way

    def pause(self, job: str, comment: str = "", *, expects: int | None = None) -> Job:
        """Pauses a job; one that waits for an answer pauses once the answer has arrived."""
        with self._guard.command():
            now = self._expected(job, expects)
            if now.state is not JobState.INTERRUPTED:
                now = self._book.move(now, Trigger.PAUSE, comment, detail="paused")
            self._conductor.wish(job, JobRun.pause)
            return now

    def resume(self, job: str, comment: str = "", *, expects: int | None = None) -> Job:
        """Resumes a paused job; a cut-off one is replanned when its turn comes.

        Raises:
            WrongState: It waits for an answer, the system is halted, or it is not paused.
        """
        with self._guard.command():
            now = self._expected(job, expects)
            if now.state is JobState.RUNNING:
                return now
            run = self._conductor.run(job)
            if run is not None and run.asks:
                raise WrongState(f"job '{job}' waits for an answer: {', '.join(now.choices)}")
            self._require_ready(now)
            detail = WAITS if run is None else "goes on"
            changed = self._book.move(now, Trigger.RESUME, comment, detail=detail, choices=(), question=None)
            self._conductor.go_on(job)
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
        with self._guard.command():
            now = self._expected(job, expects)
            if not now.choices:
                raise WrongState(f"job '{job}' waits for no answer, or not any more: it is {now.state.name.lower()}")
            if choice not in now.choices:
                raise UnknownName("answer", choice, now.choices, where=f"of job '{job}'")
            run = self._conductor.run(job)
            if run is not None:
                run.answer(choice, by=by, asked=now.question)
                return now
            if choice == ABORT:
                return self.abort(job, f"answered by {by}")
            self._require_ready(now)
            if choice == BY_HAND:
                self._conductor.note_done(job, by)
                return now
            return self.resume(job, f"{choice}, says {by}")

    # ------------------------------------------------------------------ the end

    def stop(self, job: str, comment: str = "", *, expects: int | None = None) -> Job:
        """Stops a running job; it is over once everything it moved is at rest."""
        return self._end(job, Trigger.STOP, Outcome.STOPPED, comment, expects)

    def abort(self, job: str, comment: str = "", *, expects: int | None = None) -> Job:
        """Aborts a job, started or not."""
        return self._end(job, Trigger.ABORT, Outcome.ABORTED, comment, expects)

    def clear(self, job: str, *, expects: int | None = None) -> Job:
        """Removes a finished job with all its records and returns its last version."""
        with self._guard.command():
            now = self._expected(job, expects)
            if now.state.is_open:
                raise WrongState(f"job '{job}' is not over: stop, abort or cancel it")
            return self._book.remove(now)

    def _end(self, job: str, trigger: Trigger, outcome: Outcome, comment: str, expects: int | None) -> Job:
        with self._guard.command():
            now = self._expected(job, expects)
            run = self._conductor.run(job)
            if now.outcome is outcome or (run is not None and run.ending is outcome):
                return now
            if run is None:
                return self._book.move(now, trigger, comment, outcome=outcome, detail="", choices=(), question=None)
            next_state(now.state, trigger)  # raises if it is not allowed
            run.end_as(trigger, outcome, comment)
            self._conductor.wish(job, JobRun.stop)
            return self._book.change(now.but(detail=f"is being {outcome.value}"))

    # ------------------------------------------------------------------ what must be so

    def _expected(self, job: str, version: int | None) -> Job:
        """Returns the current job if it has the expected version."""
        now = self.job(job)
        if version is not None and now.version != version:
            raise StaleVersion(
                f"job '{job}' has changed: version {now.version}, not {version} any more; look again, then decide"
            )
        return now

    def _require_ready(self, job: Job) -> None:
        halted = self._runtime.cycle.halted
        if halted:
            raise WrongState(f"job '{job.id}' cannot go on: everything is halted ({halted}); look, reset, then answer")
