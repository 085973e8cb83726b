"""Never more jobs are under way than may be, whatever is paused, cut off, held or answered."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from skiros_py.behaviours import AssertEffects, Sequence, Wait
from skiros_py.errors import WrongState
from skiros_py.skills.skill import Skill
from skiros_py.tasks.jobs.job import JobOrder, JobState, Outcome
from skiros_py.tasks.jobs.manager import JobManager
from skiros_py.tasks.jobs.store import JobStore
from skiros_py.tasks.policy import Policy
from skiros_py.testing import Bench, tiny_world
from skiros_py.testing.tiny import DRIVE, PICK, PLACE, pretend

GIANT = "scene:giant_1 a tiny:Giant ; sk:in scene:box_a ."
UNREACHABLE = "In(giant_1, slot_2)"
BALL, RED = "In(ball_1, slot_1)", "In(red_ball_1, slot_2)"
ASKING = Policy(ask=True, attempts=1)
SLOW = tuple(pretend(skill, Sequence.of(Wait(0.5), AssertEffects(0.0))) for skill in (DRIVE, PICK, PLACE))
DROPPING: tuple[Skill, ...] = (pretend(DRIVE), pretend(PICK), pretend(PLACE, Wait(0.1)))
"""The place says that it worked, and the ball is still in the hand."""


class Cell:
    """One life of the program on a file of jobs; sees to it that never more are under way than may be."""

    def __init__(self, bench: Bench, store: JobStore, at_once: int) -> None:
        self.bench = bench
        self.jobs = JobManager(bench.tasks, bench.runtime, store, lambda texts: bench.goal(*texts), at_once=at_once)
        self.most = 0
        bench.cycle.observe(self._count)

    def order(self, job: str, *goal: str, priority: int = 0, policy: Policy | None = None, again: bool = False) -> None:
        order = JobOrder(id=job, goal=goal, priority=priority, policy=policy or Policy())
        self.jobs.submit(order, again=again)

    def until(self, job: str, *states: JobState) -> None:
        self.bench.until(lambda: self.jobs.job(job).state in states)

    def until_over(self, *jobs: str) -> list[Outcome | None]:
        for job in jobs:
            self.until(job, JobState.ENDED, JobState.ABORTED)
        return [self.jobs.job(job).outcome for job in jobs]

    def ended(self) -> list[str]:
        """Returns the jobs that are over, in the order in which they ended."""
        over = [job for job in self.jobs.store.page().jobs if job.ended is not None]
        return [job.id for job in sorted(over, key=lambda job: job.ended or 0.0)]

    def _count(self) -> None:
        going_on = (one for one in self.bench.tasks.active if one.question is None)
        self.most = max(self.most, sum(one.status != "paused" for one in going_on))


@contextmanager
def cell(path: Path, *facts: str, skills: tuple[Skill, ...] = SLOW, at_once: int = 1) -> Iterator[Cell]:
    store = JobStore(path / "jobs.db")
    try:
        with Bench(tiny_world(*facts), skills) as bench:
            yield Cell(bench, store, at_once)
    finally:
        store.close()


def cut_off(path: Path, job: str, other: str) -> None:
    """Lets the program end while something moves for a job, and another has begun as well."""
    with cell(path, at_once=2) as one:
        one.order(job, BALL)
        one.bench.until(lambda: any(intent.ended is None for intent in one.jobs.intents(job)))
        one.order(other, RED)
        one.until(other, JobState.RUNNING)


def test_no_job_starts_before_all_interrupted_jobs_are_answered(tmp_path: Path) -> None:
    cut_off(tmp_path, "cut", "other")
    with cell(tmp_path) as one:
        one.order("new", "At(robot_1, box_a)", priority=9)
        one.bench.advance(2.0)
        assert one.jobs.job("new").state is JobState.ALLOWED_TO_START
        assert one.jobs.idle
        one.jobs.answer("cut", "retry", by="ann")
        assert one.until_over("cut") == [Outcome.SUCCEEDED]
        one.bench.advance(2.0)
        assert one.jobs.job("new").state is JobState.ALLOWED_TO_START
        one.jobs.answer("other", "abort", by="ann")
        one.until_over("new")


@pytest.mark.parametrize("answer", ["retry", "done by hand"])
def test_an_answered_interrupted_job_waits_for_its_turn(tmp_path: Path, answer: str) -> None:
    cut_off(tmp_path, "cut", "other")
    with cell(tmp_path) as one:
        one.jobs.answer("other", "retry", by="ann")
        one.bench.advance(0.02)
        one.jobs.answer("cut", answer, by="ann")
        one.bench.advance(0.02)
        assert (one.jobs.job("cut").state, one.jobs.job("cut").detail) == (JobState.RUNNING, "waits for its turn")
        assert one.until_over("cut", "other") == [Outcome.SUCCEEDED] * 2
        assert one.ended() == ["other", "cut"]
        assert one.most == 1


def test_a_continued_job_runs_before_new_jobs_of_equal_priority_and_after_higher_ones(tmp_path: Path) -> None:
    cut_off(tmp_path, "cut", "first")
    with cell(tmp_path) as one:
        one.jobs.answer("first", "retry", by="ann")
        one.bench.advance(0.02)
        one.order("later", "At(robot_1, box_b)")
        one.order("urgent", "At(robot_1, box_a)", priority=1)
        one.jobs.answer("cut", "retry", by="ann")
        one.until_over("first", "later", "urgent", "cut")
        assert one.ended() == ["first", "urgent", "cut", "later"]


def test_a_job_that_waits_to_continue_can_be_paused_resumed_and_stopped(tmp_path: Path) -> None:
    cut_off(tmp_path, "cut", "other")
    with cell(tmp_path) as one:
        one.jobs.answer("other", "retry", by="ann")
        one.bench.advance(0.02)
        one.jobs.answer("cut", "retry", by="ann")
        one.bench.advance(0.02)
        one.jobs.pause("cut")
        one.until_over("other")
        one.bench.advance(1.0)
        assert one.jobs.job("cut").state is JobState.INTERRUPTED
        one.order("third", "At(robot_1, box_a)")
        one.until("third", JobState.RUNNING)
        one.jobs.resume("cut")
        one.bench.advance(0.02)
        assert one.jobs.stop("cut").outcome is Outcome.STOPPED
        one.until_over("third")
        one.bench.advance(1.0)
        assert one.jobs.idle


def test_a_halt_interrupts_a_job_that_waits_to_continue(tmp_path: Path) -> None:
    cut_off(tmp_path, "cut", "other")
    with cell(tmp_path) as one:
        one.jobs.answer("other", "retry", by="ann")
        one.bench.advance(0.02)
        one.jobs.answer("cut", "retry", by="ann")
        one.bench.advance(0.02)
        one.bench.cycle.stop_all("button")
        one.bench.advance(0.1)
        assert one.jobs.job("cut").state is JobState.INTERRUPTED
        one.bench.cycle.reset()
        for job in ("cut", "other"):
            one.jobs.answer(job, "retry", by="ann")
        assert one.until_over("cut", "other") == [Outcome.SUCCEEDED] * 2
        assert one.most == 1


def test_a_job_reordered_after_a_stop_while_waiting_starts_once(tmp_path: Path) -> None:
    cut_off(tmp_path, "cut", "other")
    with cell(tmp_path) as one:
        one.jobs.answer("other", "retry", by="ann")
        one.bench.advance(0.02)
        one.jobs.answer("cut", "retry", by="ann")
        one.bench.advance(0.02)
        one.jobs.stop("cut")
        one.jobs.clear("cut")
        one.order("cut", BALL, again=True)
        assert one.until_over("other", "cut") == [Outcome.SUCCEEDED] * 2
        assert one.jobs.job("cut").attempts == 1


# ------------------------------------------------------------------ waiting for a person


def test_a_job_that_waits_for_a_person_does_not_keep_the_queue_waiting(tmp_path: Path) -> None:
    with cell(tmp_path, GIANT) as one:
        one.order("asks", UNREACHABLE, BALL, policy=ASKING)
        one.until("asks", JobState.INTERRUPTED)
        asked = one.jobs.job("asks")
        one.order("next", RED)
        assert one.until_over("next") == [Outcome.SUCCEEDED]
        assert one.jobs.job("asks") == asked
        one.jobs.answer("asks", "skip", by="ann")
        assert one.until_over("asks") == [Outcome.PARTIALLY_SUCCEEDED]
        assert one.most == 1


def test_an_answered_job_continues_when_a_slot_is_free_and_before_new_jobs(tmp_path: Path) -> None:
    with cell(tmp_path, GIANT) as one:
        one.order("asks", UNREACHABLE, BALL, policy=ASKING)
        one.until("asks", JobState.INTERRUPTED)
        one.order("next", RED)
        one.order("last", "At(robot_1, box_b)", priority=9)
        one.until("last", JobState.RUNNING)
        one.jobs.answer("asks", "skip", by="ann")
        one.bench.advance(0.02)
        assert (one.jobs.job("asks").state, one.jobs.job("asks").detail) == (JobState.RUNNING, "waits for its turn")
        one.until_over("asks", "next", "last")
        assert one.ended() == ["last", "asks", "next"]
        assert one.most == 1


def test_a_waiting_job_that_holds_a_part_keeps_its_slot(tmp_path: Path) -> None:
    with cell(tmp_path, skills=DROPPING) as one:
        one.order("asks", BALL, policy=ASKING)
        one.until("asks", JobState.INTERRUPTED)
        one.order("next", "At(robot_1, box_b)")
        one.bench.advance(5.0)
        assert one.jobs.job("next").state is JobState.ALLOWED_TO_START
        one.jobs.stop("asks")
        assert one.until_over("asks", "next") == [Outcome.STOPPED, Outcome.SUCCEEDED]


def test_a_job_that_is_set_aside_is_stopped_at_once(tmp_path: Path) -> None:
    with cell(tmp_path, GIANT) as one:
        one.order("asks", UNREACHABLE, policy=ASKING)
        one.until("asks", JobState.INTERRUPTED)
        one.order("next", RED)
        one.until("next", JobState.RUNNING)
        one.jobs.stop("asks")
        one.until("asks", JobState.ENDED)
        assert one.jobs.job("next").state is JobState.RUNNING


def test_a_question_can_be_answered_only_once(tmp_path: Path) -> None:
    with cell(tmp_path, GIANT) as one:
        one.order("asks", UNREACHABLE, policy=ASKING)
        one.until("asks", JobState.INTERRUPTED)
        one.jobs.answer("asks", "skip", by="ann")
        with pytest.raises(WrongState, match="'asks' has its answer already"):
            one.jobs.answer("asks", "retry", by="bob")
        one.until_over("asks")


def test_answering_a_job_without_a_question_is_refused(tmp_path: Path) -> None:
    with cell(tmp_path) as one:
        one.order("job", BALL)
        one.until_over("job")
        with pytest.raises(WrongState, match="waits for no answer"):
            one.jobs.answer("job", "retry", by="ann")
