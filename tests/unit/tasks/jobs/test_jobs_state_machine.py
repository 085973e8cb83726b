"""Random handling of a queue of jobs, by people who repeat and mix up their commands, over halts and restarts.

A small model says what each command leads to in each state, after the standard's table. Whatever happens: the file has
what the manager shows, each change of state is one of the table and announced once, versions grow, numbers are given
once, and a command that is refused changes nothing.
"""

from __future__ import annotations

import tempfile
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, precondition, rule

from skiros_py.errors import KeyReused, Removed, StaleVersion, UnknownName, WrongState
from skiros_py.tasks.jobs.job import Job, JobOrder, JobState, Trigger, allowed, next_state
from skiros_py.tasks.jobs.manager import JobManager
from skiros_py.tasks.jobs.store import JobStore, Receipt
from skiros_py.tasks.policy import Policy
from skiros_py.testing import Bench, tiny_world

S = JobState
IDS = st.sampled_from("abc")
GOALS = ("In(ball_1, box_a)", "In(ball_1, slot_1)", "In(giant_1, slot_2)", "At(robot_1, box_b)")
GATE = 100.0
ORDERS = st.builds(
    lambda id_, goal, gate: JobOrder(
        id=id_, goal=(goal,), not_before=datetime.fromtimestamp(GATE, UTC) if gate else None, policy=Policy(ask=True)
    ),
    IDS,
    st.sampled_from(GOALS),
    st.sampled_from([False, False, True]),
)

REMOVED, SAME, REFUSED = "removed", "same", "refused"
MODEL: dict[str, dict[JobState, Any]] = {
    "start": {S.NOT_ALLOWED_TO_START: S.ALLOWED_TO_START, S.ALLOWED_TO_START: SAME},
    "revoke_start": {S.ALLOWED_TO_START: S.NOT_ALLOWED_TO_START, S.NOT_ALLOWED_TO_START: SAME},
    "pause": {S.RUNNING: S.INTERRUPTED, S.INTERRUPTED: SAME},
    "stop": {S.RUNNING: {S.RUNNING, S.ENDED}, S.INTERRUPTED: {S.INTERRUPTED, S.ENDED}},
    "abort": {
        S.NOT_ALLOWED_TO_START: S.ABORTED,
        S.ALLOWED_TO_START: S.ABORTED,
        S.RUNNING: {S.RUNNING, S.ABORTED},
        S.INTERRUPTED: {S.INTERRUPTED, S.ABORTED},
    },
    "cancel": {S.NOT_ALLOWED_TO_START: REMOVED, S.ALLOWED_TO_START: REMOVED},
    "clear": {S.ENDED: REMOVED, S.ABORTED: REMOVED},
}
"""What a command leads to in each state; where several, what runs has to stand first; else it is refused."""


class Jobs(RuleBasedStateMachine):
    """A queue of jobs."""

    def __init__(self) -> None:
        super().__init__()
        self._folder = tempfile.TemporaryDirectory()
        self.clock = 0.0
        self.seen: dict[str, Job] = {}
        self.numbers: set[int] = set()
        self.receipts: dict[str, tuple[str, JobOrder]] = {}
        self.removed: dict[str, JobOrder] = {}
        self.told = 0
        self.states: dict[str, JobState] = {}
        self._begin()

    def _begin(self) -> None:
        self.bench = Bench(tiny_world("scene:giant_1 a tiny:Giant ; sk:in scene:box_a ."))
        self.bench.__enter__()
        self.store = JobStore(Path(self._folder.name) / "jobs.db")
        self.jobs = JobManager(
            self.bench.tasks, self.bench.runtime, self.store, lambda t: self.bench.goal(*t), clock=lambda: self.clock
        )
        self.jobs.subscribe(self._hear)

    def _hear(self, job: Job) -> None:
        before = self.seen.get(job.id)
        if before is None or before.number != job.number:
            assert job.number not in self.numbers
            self.numbers.add(job.number)
        else:
            assert job.version == before.version + 1
        self.seen[job.id] = job

    def _all(self) -> dict[str, Job]:
        return {job.id: job for job in self.jobs.store.page(limit=1000).jobs}

    # ------------------------------------------------------------------ orders

    @initialize(goals=st.lists(st.sampled_from(GOALS), min_size=2, max_size=2), number=st.sampled_from([0, 1, 500]))
    def some_are_there(self, goals: list[str], number: int) -> None:
        for id_, goal in zip("ab", goals, strict=True):
            self.jobs.submit(JobOrder(id=id_, goal=(goal,), policy=Policy(ask=True)))
        self.time_goes_by(number)

    @rule(order=ORDERS, start=st.booleans(), key=st.sampled_from(["", "", "k1", "k2"]), again=st.booleans())
    def submit(self, order: JobOrder, start: bool, key: str, again: bool) -> None:
        before = self._all()
        receipt = Receipt("mes", key, order.model_dump_json()) if key else None
        if key in self.receipts:
            id_, first = self.receipts[key]
            if first == order:
                assert self.jobs.submit(order, start=start, receipt=receipt).id == id_
            else:
                with pytest.raises(KeyReused):
                    self.jobs.submit(order, start=start, receipt=receipt)
            assert self._all() == before
        elif order.id in before and before[order.id].order != order:
            with pytest.raises(WrongState):
                self.jobs.submit(order, start=start, receipt=receipt)
            assert self._all() == before
        elif order.id not in before and order.id in self.removed and not again:
            with pytest.raises(Removed if order == self.removed[order.id] else WrongState):
                self.jobs.submit(order, start=start, receipt=receipt)
            assert self._all() == before
        else:
            job = self.jobs.submit(order, start=start, receipt=receipt, again=again)
            fresh = S.ALLOWED_TO_START if start else S.NOT_ALLOWED_TO_START
            assert job == before[order.id] if order.id in before else job.state is fresh
            if key:
                self.receipts[key] = order.id, order

    @rule(order=ORDERS, behind=st.sampled_from([0, 0, 1]))
    def update(self, order: JobOrder, behind: int) -> None:
        now = self._all().get(order.id)
        expects = None if now is None else now.version - behind
        if now is None:
            self._refused(UnknownName, lambda: self.jobs.update(order, expects=expects))
        elif behind:
            self._refused(StaleVersion, lambda: self.jobs.update(order, expects=expects))
        elif now.order == order:
            assert self.jobs.update(order, expects=expects) == now
        elif now.state in (S.NOT_ALLOWED_TO_START, S.ALLOWED_TO_START):
            updated = self.jobs.update(order, expects=expects)
            assert (updated.order, updated.state) == (order, now.state)
        else:
            self._refused(WrongState, lambda: self.jobs.update(order, expects=expects))

    def _refused(self, kind: type[Exception], command: Any) -> None:
        before = self._all()
        with pytest.raises(kind):
            command()
        assert self._all() == before

    # ------------------------------------------------------------------ commands

    @rule(id_=IDS, command=st.sampled_from(sorted(MODEL)), behind=st.sampled_from([None, 0, 1]))
    def command(self, id_: str, command: str, behind: int | None) -> None:
        now = self._all().get(id_)
        expects = None if behind is None or now is None else now.version - behind
        obey = getattr(self.jobs, command)
        follows = MODEL[command].get(now.state, REFUSED) if now else REFUSED
        if now is None:
            self._refused(UnknownName, lambda: obey(id_))
        elif behind:
            self._refused(StaleVersion, lambda: obey(id_, expects=expects))
        elif self._has_had_its_effect(now, command):
            assert obey(id_, expects=expects) == now
        elif follows == REFUSED:
            self._refused(WrongState, lambda: obey(id_, expects=expects))
        else:
            obey(id_, expects=expects)
            self._check(now, follows)
            again = self._all().get(id_)
            if follows != REMOVED:
                assert obey(id_) == again, "the same command again changes nothing"

    def _has_had_its_effect(self, job: Job, command: str) -> bool:
        return job.outcome is not None and (command, job.outcome.value) in (("stop", "stopped"), ("abort", "aborted"))

    def _check(self, before: Job, follows: Any) -> None:
        after = self._all().get(before.id)
        if follows == REMOVED:
            assert after is None
            self.removed[before.id] = before.order
        elif follows == SAME:
            assert after == before
        else:
            assert after is not None
            assert after.state in (follows if isinstance(follows, set) else {follows})

    @rule(id_=IDS)
    def resume(self, id_: str) -> None:
        now = self._all().get(id_)
        if now is None:
            self._refused(UnknownName, lambda: self.jobs.resume(id_))
        elif now.state is S.RUNNING:
            assert self.jobs.resume(id_) == now
        elif now.state is not S.INTERRUPTED or self.bench.cycle.halted:
            self._refused(WrongState, lambda: self.jobs.resume(id_))
        elif now.question is None:
            assert self.jobs.resume(id_).state is S.RUNNING

    @rule(id_=IDS, at=st.integers(0, 5))
    def answer(self, id_: str, at: int) -> None:
        job = self._all().get(id_)
        if job is not None and job.choices and not self.bench.cycle.halted:
            choice = job.choices[at % len(job.choices)]
            try:
                self.jobs.answer(id_, choice, by="ann")
            except WrongState:
                assert job.question is not None, "only a question of a run may be gone or another one by now"

    # ------------------------------------------------------------------ what happens

    @rule(number=st.sampled_from([10, 500, 3000]))
    def time_goes_by(self, number: int) -> None:
        for _ in range(number):
            self.bench.cycle.step()

    @precondition(lambda self: self.clock < GATE)
    @rule()
    def the_gate_opens(self) -> None:
        self.clock = GATE

    @rule()
    def halt(self) -> None:
        self.bench.cycle.stop_all("button")
        self.bench.cycle.step()
        assert not [job for job in self.jobs.open.values() if job.state is S.RUNNING]

    @precondition(lambda self: self.bench.cycle.halted)
    @rule()
    def reset(self) -> None:
        self.bench.cycle.reset()

    @rule()
    def restart(self) -> None:
        before = self._all()
        self._end()
        self._begin()
        for id_, job in self._all().items():
            if before[id_].state.has_begun:
                assert job.state is S.INTERRUPTED
                assert job.choices
            else:
                assert job == before[id_]
        assert set(self._all()) == set(before)
        self.seen.update(self._all())

    # ------------------------------------------------------------------ what always holds

    @invariant()
    def the_file_has_what_is_shown(self) -> None:
        kept = {job.id: job for job in self.store.page(limit=1000).jobs}
        assert kept == self._all()
        assert dict(self.jobs.open) == {id_: job for id_, job in kept.items() if job.state.is_open}

    @invariant()
    def each_change_is_of_the_table_and_announced_once(self) -> None:
        for each in self.store.announcements(self.told, 1000):
            assert each.number == self.told + 1
            self.told = each.number
            before = self.states.get(each.job.id)
            if each.trigger in ("cancelled", "cleared"):
                assert before is not None
                assert before.is_open == (each.trigger == "cancelled")
                del self.states[each.job.id]
            elif before is None:
                assert each.job.state in (S.NOT_ALLOWED_TO_START, S.ALLOWED_TO_START)
                self.states[each.job.id] = each.job.state
            else:
                assert Trigger(each.trigger) in allowed(before)
                self.states[each.job.id] = next_state(before, Trigger(each.trigger))
                assert each.job.state is self.states[each.job.id]
        assert self.states == {id_: job.state for id_, job in self._all().items()}

    @invariant()
    def what_is_over_has_an_outcome_and_an_end(self) -> None:
        for job in self.jobs.store.page().jobs:
            assert job.state.is_open == (job.outcome is None)
            assert job.state.is_open == (job.ended is None)

    def _end(self) -> None:
        self.store.close()
        self.bench.close()

    def teardown(self) -> None:
        self._end()
        self._folder.cleanup()


TestJobs = Jobs.TestCase
TestJobs.settings = settings(
    max_examples=30, stateful_step_count=30, deadline=None, suppress_health_check=list(HealthCheck)
)
