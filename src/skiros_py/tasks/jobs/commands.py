"""What people and other systems may want of a job that is there: checked and written down at once."""

from __future__ import annotations

from skiros_py.errors import StaleVersion, UnknownName, WrongState
from skiros_py.execution.runtime import Runtime
from skiros_py.tasks.jobs.book import JobBook
from skiros_py.tasks.jobs.conductor import Conductor
from skiros_py.tasks.jobs.cut_off import ABORT, BY_HAND, WAITS
from skiros_py.tasks.jobs.guard import Guard
from skiros_py.tasks.jobs.job import Job, Outcome
from skiros_py.tasks.jobs.lookups import JobLookups
from skiros_py.tasks.jobs.run import JobRun
from skiros_py.tasks.jobs.states import JobState, Trigger
from skiros_py.tasks.jobs.store import JobStore


class JobCommands(JobLookups):
    """Takes commands; one that is given again, where it has had its effect already, changes nothing.

    Each takes ``expects``: the :attr:`Job.version` that whoever commands has seen, or None for whatever it is now; and
    each raises UnknownName where there is no such job, StaleVersion where it has changed since, and WrongState where
    it cannot be done in the job's state.

    Args:
        book: The jobs as they are now.
        store: Where they are kept.
        runtime: Where they are done.
        conductor: Lets them run.
        guard: Held while a job changes.
    """

    def __init__(self, book: JobBook, store: JobStore, runtime: Runtime, conductor: Conductor, guard: Guard) -> None:
        super().__init__(book, store)
        self._runtime = runtime
        self._conductor = conductor
        self._guard = guard

    # ------------------------------------------------------------------ before the start

    def start(self, job: str, comment: str = "", *, expects: int | None = None) -> Job:
        """Gives a job leave to start."""
        with self._guard.command():
            now = self._expected(job, expects)
            if now.state is JobState.ALLOWED_TO_START:
                return now
            return self._book.move(now, Trigger.START, comment, detail="queued")

    def revoke_start(self, job: str, comment: str = "", *, expects: int | None = None) -> Job:
        """Takes back the leave to start."""
        with self._guard.command():
            now = self._expected(job, expects)
            if now.state is JobState.NOT_ALLOWED_TO_START:
                return now
            return self._book.move(now, Trigger.REVOKE_START, comment, detail="waits for leave to start")

    def cancel(self, job: str, *, expects: int | None = None) -> Job:
        """Removes a job that has not begun, and returns it as it was last."""
        with self._guard.command():
            now = self._expected(job, expects)
            if now.state.has_begun:
                raise WrongState(f"job '{job}' has begun: stop or abort it, then clear it")
            if not now.state.is_open:
                raise WrongState(f"job '{job}' has begun and is over: clear it")
            return self._book.remove(now)

    # ------------------------------------------------------------------ under way

    def pause(self, job: str, comment: str = "", *, expects: int | None = None) -> Job:
        """Lets a job come to a standstill where it is; what waits for an answer stands when that has come."""
        with self._guard.command():
            now = self._expected(job, expects)
            if now.state is not JobState.INTERRUPTED:
                now = self._book.move(now, Trigger.PAUSE, comment, detail="paused")
            self._conductor.wish(job, JobRun.pause)
            return now

    def resume(self, job: str, comment: str = "", *, expects: int | None = None) -> Job:
        """Goes on with a job that stands; one that was cut off is planned anew, when its turn comes.

        Raises:
            WrongState: It waits for an answer, or everything is halted, or it does not stand.
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
        """Answers what a job waits for.

        Args:
            job: Its id.
            choice: One of its :attr:`Job.choices`.
            by: Who answers.
            expects: Its version, as seen.

        Raises:
            UnknownName: There is no such job, or it does not offer that choice.
            WrongState: It asks something else by now, or everything is halted.
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
        """Ends a job that is under way; it is over when everything it moved stands."""
        return self._end(job, Trigger.STOP, Outcome.STOPPED, comment, expects)

    def abort(self, job: str, comment: str = "", *, expects: int | None = None) -> Job:
        """Gives a job up, begun or not."""
        return self._end(job, Trigger.ABORT, Outcome.ABORTED, comment, expects)

    def clear(self, job: str, *, expects: int | None = None) -> Job:
        """Removes a job that is over, with all that is known of it, and returns it as it was last."""
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
            self._book.check(now, trigger)
            run.end_as(trigger, outcome, comment)
            self._conductor.wish(job, JobRun.stop)
            return self._book.change(now.but(detail=f"is being {outcome.value}"))

    # ------------------------------------------------------------------ what must be so

    def _expected(self, job: str, version: int | None) -> Job:
        """Returns a job as it is now, if that is what somebody has seen."""
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
