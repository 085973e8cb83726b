"""Jobs that are cut off, halted, held and answered; on the tiny domain with a robot that pretends."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from skiros_py.errors import UsageError
from skiros_py.tasks.jobs.job import Job, JobOrder, JobState, Outcome
from skiros_py.tasks.jobs.manager import JobManager
from skiros_py.tasks.jobs.store import JobStore
from skiros_py.tasks.policy import Policy
from skiros_py.testing import Bench, tiny_world

GOAL = "In(ball_1, slot_1)"
GIANTS = ("scene:giant_1 a tiny:Giant ; sk:in scene:box_a .", "scene:giant_2 a tiny:Giant ; sk:in scene:box_a .")
ASKING = Policy(ask=True)


class Cell:
    """One life of the program on a file of jobs."""

    def __init__(self, bench: Bench, store: JobStore, at_once: int = 1) -> None:
        self.bench = bench
        self.jobs = JobManager(bench.tasks, bench.runtime, store, lambda texts: bench.goal(*texts), at_once=at_once)

    @property
    def job(self) -> Job:
        return self.jobs.job("j")

    def submit(self, *goal: str, **more: object) -> None:
        self.jobs.submit(JobOrder(id="j", goal=goal or (GOAL,), **more))

    def until(self, reached: Callable[[], object]) -> None:
        self.bench.until(lambda: bool(reached()))

    def moves(self, skill: str) -> bool:
        return any(i.skill == skill and i.ended is None for i in self.jobs.intents("j"))


@contextmanager
def cell(path: Path, *facts: str, at_once: int = 1) -> Iterator[Cell]:
    store = JobStore(path / "jobs.db")
    try:
        with Bench(tiny_world(*facts)) as bench:
            yield Cell(bench, store, at_once)
    finally:
        store.close()


def test_an_interruption_before_a_restart_is_not_announced_again(tmp_path: Path) -> None:
    with cell(tmp_path) as first:
        first.submit()
        first.until(lambda: first.moves("pick"))
    with cell(tmp_path) as second:
        second.jobs.answer("j", "retry", by="ann")
        second.until(lambda: second.moves("place"))
    with cell(tmp_path) as third:
        assert "place" in third.job.detail
        assert "pick" not in third.job.detail


def test_a_job_that_waits_for_a_person_is_unchanged_by_another_restart(tmp_path: Path) -> None:
    with cell(tmp_path) as first:
        first.submit()
        first.until(lambda: first.moves("pick"))
    with cell(tmp_path) as second:
        held = second.job
    with cell(tmp_path) as third:
        assert third.job == held
        third.jobs.answer("j", "retry", by="ann")
        third.until(lambda: third.job.state is JobState.ENDED)


def test_a_step_done_by_hand_that_cannot_be_believed_leaves_the_job_waiting(tmp_path: Path) -> None:
    with cell(tmp_path) as first:
        first.submit()
        first.until(lambda: first.moves("pick"))
    with cell(tmp_path) as second:
        with second.bench.world.transaction("test", "somebody took it along") as tx:
            tx.remove("ball_1")
        second.jobs.answer("j", "done by hand", by="ann")
        second.bench.advance(0.1)
        assert second.job.state is JobState.INTERRUPTED
        assert "cannot be believed" in second.job.detail
        assert "retry" in second.job.choices


def test_a_step_done_by_hand_while_its_manager_is_gone_leaves_the_job_waiting(tmp_path: Path) -> None:
    with cell(tmp_path) as first:
        first.submit()
        first.until(lambda: first.moves("pick"))
    with cell(tmp_path) as second:
        second.bench.managers.close("arm_1")
        second.jobs.answer("j", "done by hand", by="ann")
        second.bench.advance(0.1)
        assert "unknown skill 'pick'" in second.job.detail


def test_a_job_that_waits_for_an_answer_cannot_be_resumed(tmp_path: Path) -> None:
    with cell(tmp_path, *GIANTS) as one:
        one.submit("In(giant_1, slot_2)", policy=ASKING)
        one.until(lambda: one.job.choices)
        with pytest.raises(UsageError, match="waits for an answer: retry"):
            one.jobs.resume("j")
        one.jobs.answer("j", "skip", by="ann")
        one.until(lambda: not one.job.state.is_open)
        assert one.job.outcome is Outcome.NO_PLAN


def test_a_second_question_replaces_the_first_and_is_answered_separately(tmp_path: Path) -> None:
    with cell(tmp_path, *GIANTS) as one:
        one.submit("In(giant_1, slot_1)", "In(giant_2, slot_2)", policy=ASKING)
        one.until(lambda: one.job.choices)
        first = one.job
        one.jobs.answer("j", "skip", by="ann")
        one.until(lambda: one.job.question != first.question and one.job.choices)
        assert "giant_1" in first.detail
        assert "giant_2" in one.job.detail


def test_a_job_paused_during_a_question_stays_paused_after_the_answer(tmp_path: Path) -> None:
    with cell(tmp_path, *GIANTS) as one:
        one.submit("In(giant_1, slot_2)", GOAL, policy=ASKING)
        one.until(lambda: one.job.choices)
        one.jobs.pause("j", "lunch")
        one.bench.advance(0.1)
        one.jobs.answer("j", "skip", by="ann")
        one.bench.advance(10.0)
        assert (one.job.state, one.job.detail) == (JobState.INTERRUPTED, "paused")
        assert not one.jobs.intents("j")
        one.jobs.resume("j")
        one.until(lambda: not one.job.state.is_open)
        assert one.job.outcome is Outcome.PARTIALLY_SUCCEEDED


def test_during_a_halt_answers_are_refused_and_the_job_keeps_waiting(tmp_path: Path) -> None:
    with cell(tmp_path) as one:
        one.submit()
        one.until(lambda: one.moves("drive"))
        one.bench.cycle.stop_all("button")
        one.bench.advance(0.1)
        with pytest.raises(UsageError, match="everything is halted"):
            one.jobs.answer("j", "retry", by="ann")
        assert one.job.choices == ("retry", "abort")
        one.bench.cycle.reset()
        one.jobs.answer("j", "retry", by="ann")
        one.until(lambda: not one.job.state.is_open)
        assert one.job.outcome is Outcome.SUCCEEDED


def test_a_halt_before_the_first_tick_holds_the_job_and_no_other(tmp_path: Path) -> None:
    with cell(tmp_path) as one:
        one.submit()
        one.bench.cycle.step()
        one.bench.cycle.stop_all("button")
        one.bench.advance(0.1)
        assert one.job.state is JobState.INTERRUPTED
        one.bench.cycle.reset()
        one.jobs.abort("j")
        one.jobs.submit(JobOrder(id="next", goal=(GOAL,)))
        one.until(lambda: not one.jobs.job("next").state.is_open)
        assert one.jobs.job("next").outcome is Outcome.SUCCEEDED


def test_an_exception_in_a_listener_does_not_prevent_the_job(tmp_path: Path) -> None:
    def broken(_job: Job) -> None:
        raise ValueError("on purpose")

    with cell(tmp_path) as one:
        one.jobs.subscribe(broken)
        one.submit()
        one.until(lambda: not one.job.state.is_open)
        assert one.job.outcome is Outcome.SUCCEEDED
