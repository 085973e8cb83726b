"""What happens to jobs in the control thread: they begin when their turn comes, are followed, and obey."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

from skiros_py.errors import SkirosError
from skiros_py.execution.runtime import Runtime
from skiros_py.skills.conditions import Condition
from skiros_py.tasks.jobs.book import JobBook
from skiros_py.tasks.jobs.cut_off import BY_HAND, CUT_OFF, WAITS, done_by_hand, hold_what_was_halted
from skiros_py.tasks.jobs.guard import Guard
from skiros_py.tasks.jobs.job import Intent, Job, Outcome
from skiros_py.tasks.jobs.moves import moved
from skiros_py.tasks.jobs.queue import rank
from skiros_py.tasks.jobs.run import JobRun
from skiros_py.tasks.jobs.states import JobState, Trigger
from skiros_py.tasks.jobs.store import JobStore
from skiros_py.tasks.task_manager import TaskManager

ReadGoal = Callable[[Sequence[str]], tuple[Condition, ...]]
"""Reads goal texts."""

_MOST_ASIDE = 20
"""So many jobs that wait for persons make room for others; those after them keep their places until one is answered."""


class Conductor:
    """Lets jobs run: never more than so many at once.

    What waits for a person keeps its place only while it has a device or a thing in its hands. Else the next job gets
    the place, and the answer lets it go on as soon as there is one again, before all others. What was cut off or halted
    has no place; when it goes on, it waits for its turn.

    Args:
        tasks: Plans and does.
        runtime: What it does it with.
        store: Where jobs are kept.
        book: The jobs as they are now.
        parse: Reads goal texts.
        guard: Held by whoever changes a job. A command holds it while it waits for the disk: the control cycle takes
            it only where there is something to write.
        at_once: How many jobs may be under way at the same time.
        clock: Gives the wall time [s since 1970].
    """

    def __init__(
        self,
        tasks: TaskManager,
        runtime: Runtime,
        store: JobStore,
        book: JobBook,
        parse: ReadGoal,
        guard: Guard,
        *,
        at_once: int,
        clock: Callable[[], float],
    ) -> None:
        self._tasks = tasks
        self._runtime = runtime
        self._store = store
        self._book = book
        self._parse = parse
        self._guard = guard
        self._at_once = at_once
        self._clock = clock
        self._turns = Turns(book, clock)
        self._runs: dict[str, JobRun] = {}
        self._wishes: deque[Callable[[], None]] = deque()

    # ------------------------------------------------------------------ asked in any thread, with the guard

    @property
    def idle(self) -> bool:
        """True when nothing is under way, and nothing would start by itself now."""
        return not (self._runs or self._wishes) and self._coming is None

    def run(self, job: str) -> JobRun | None:
        """Returns what runs for a job; None where nothing does."""
        return self._runs.get(job)

    def wish(self, job: str, what: Callable[[JobRun], None]) -> None:
        """Has something done to what runs for a job, in the control thread."""

        def fulfil() -> None:
            if job in self._runs:
                what(self._runs[job])

        self._wishes.append(fulfil)

    def go_on(self, job: str) -> None:
        """Has a job go on that stands; where nothing runs for it, it is planned anew when its turn comes."""
        self._wishes.append(partial(self._go_on, job))

    def note_done(self, job: str, by: str) -> None:
        """Has that believed what a person says they did in the place of the step that was cut off."""
        self._wishes.append(partial(self._note_done, job, by))

    # ------------------------------------------------------------------ in the control thread

    def attend(self) -> None:
        """Does what was asked for, follows what runs, and begins what is next."""
        while self._wishes:
            self._wishes.popleft()()
        for job, run in tuple(self._runs.items()):
            self._follow(job, run)
        if self._runtime.cycle.halted:
            self._hold_what_comes_back()
        else:
            self._give_places()

    def _give_places(self) -> None:
        """Lets those go on that were set aside and have their answer; then the one whose turn it is."""
        for run in self._runs.values():
            if run.aside and not run.asks and self._has_room:
                run.take_place()
        coming = self._coming
        if coming is not None and (self._has_room or self._make_room()):
            self._dispatch(coming)

    @property
    def _coming(self) -> str | None:
        """Id of the job whose turn it is.

        While a job was cut off or halted and nobody has looked, no other is begun: what a robot holds, and where it
        stands, is as uncertain for that one. What has its answer goes on.
        """
        coming = self._turns.next()
        if coming is None or not self._book.unseen:
            return coming
        back = self._turns.coming_back
        return coming if coming in back else next(iter(back), None)

    @property
    def _has_room(self) -> bool:
        return sum(not run.aside for run in self._runs.values()) < self._at_once

    def _make_room(self) -> bool:
        """Sets one aside that waits for a person and has no device or thing: nobody has to wait for that person, too.

        Returns:
            Whether there was one.
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

    def _dispatch(self, id_: str) -> None:
        with self._guard.control():
            job = self._book.open.get(id_)
            if job is None or self._coming != id_:  # somebody was quicker
                return
            if job.state is JobState.RUNNING:
                self._begin(self._book.change(job.but(**self._begun(job))))
            elif job.order.expires and job.order.deadline and job.order.deadline.timestamp() < self._clock():
                self._book.move(job, Trigger.FAIL, "its deadline has passed", outcome=Outcome.EXPIRED, detail="")
            else:
                self._begin(self._book.move(job, Trigger.DISPATCH, started=self._clock(), **self._begun(job)))

    def _begun(self, job: Job) -> dict[str, Any]:
        """Returns what changes of a job that begins: written down together, for the disk is waited for."""
        return {"detail": "planning", "attempts": job.attempts + 1, "seen": self._runtime.world.version}

    def _go_on(self, id_: str) -> None:
        with self._guard.control():
            if id_ in self._runs:
                self._runs[id_].resume()
            else:
                self._turns.come_back(id_)

    def _hold_what_comes_back(self) -> None:
        for id_ in self._turns.coming_back:
            with self._guard.control():
                job = self._book.open.get(id_)
                if job is not None and job.state is JobState.RUNNING:
                    self._begin(job)

    def _begin(self, job: Job) -> None:
        self._turns.leave(job.id)
        if self._runtime.cycle.halted:
            hold_what_was_halted(self._book, job, self._runtime.cycle.halted)
            return
        for intent in self._cut_off(job.id):
            self._store.settle(job.id, intent.number, CUT_OFF)
        try:
            goal = self._parse(job.order.goal)
            task = self._tasks.begin(goal, name=job.id, policy=job.order.policy)
        except SkirosError as error:
            self._book.move(job, Trigger.FAIL, outcome=Outcome.FAILED, reasons=(str(error),), detail="")
            return
        self._runs[job.id] = JobRun(task, self._runtime, self._book, self._store)

    def _note_done(self, id_: str, by: str) -> None:
        with self._guard.control():
            job = self._book.open.get(id_)
            if job is None or job.state is not JobState.INTERRUPTED or id_ in self._runs:  # somebody was quicker
                return
            before = self._runtime.world.version
            try:
                self._believe(id_, by)
            except SkirosError as error:
                detail = f"that it was done by hand cannot be believed: {error}; answer again"
                self._book.change(job.but(detail=detail))
                return
            materials = moved(self._runtime.world, job.but(seen=before), self._store.intents(id_))
            goes_on = {"detail": WAITS, "choices": (), "question": None, "materials": materials}
            self._book.move(job, Trigger.RESUME, f"{BY_HAND}, says {by}", **goes_on)
            self._turns.come_back(id_)

    def _believe(self, job: str, by: str) -> None:
        for intent in self._cut_off(job):
            done_by_hand(self._runtime.world, self._tasks.capabilities, intent, by)
            self._store.settle(job, intent.number, f"done by hand, says {by}")

    def _cut_off(self, job: str) -> tuple[Intent, ...]:
        """Returns the steps of which nobody knows how they ended."""
        return tuple(intent for intent in self._store.intents(job) if intent.ended is None)


class Turns:
    """The jobs that may begin, and those that begin anew; used in the control thread, apart from :meth:`next`.

    What was begun once and has to be planned anew, since the program ended or everything was halted meanwhile, waits
    like any other: others may work with its robots by now. There are few of these.

    Args:
        book: The jobs as they are now.
        clock: Gives the wall time [s since 1970].
    """

    def __init__(self, book: JobBook, clock: Callable[[], float]) -> None:
        self._book = book
        self._clock = clock
        self._back: dict[str, None] = {}

    def come_back(self, job: str) -> None:
        """Has a job wait that goes on."""
        self._back = dict.fromkeys((*self.coming_back, job))

    def leave(self, job: str) -> None:
        """Has a job wait no more that was to go on."""
        self._back.pop(job, None)

    @property
    def coming_back(self) -> tuple[str, ...]:
        """The jobs that wait to go on: none that was paused or ended meanwhile."""
        return tuple(job for job in tuple(self._back) if self._is_running(job))

    def next(self) -> str | None:
        """Returns the id of the job whose turn it is; None where none may start now."""
        new = self._book.queue.next(self._clock())
        back = self._first_back()
        if back is None or new is None:
            return back or new
        return back if self._priority(back) >= self._priority(new) else new

    def _first_back(self) -> str | None:
        """Returns the first of those that wait to go on."""
        waiting = (self._book.open.get(job) for job in self.coming_back)
        first = min((job for job in waiting if job is not None), key=rank, default=None)
        return None if first is None else first.id

    def _is_running(self, id_: str) -> bool:
        job = self._book.open.get(id_)
        return job is not None and job.state is JobState.RUNNING

    def _priority(self, id_: str) -> int:
        job = self._book.open.get(id_)
        return 0 if job is None else job.order.priority
