"""Several jobs at once on two robots (fake): side by side where they do not meet, one after the other where they do."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import closing
from pathlib import Path

import pytest

from skiros_py.station.session import Options, Session
from skiros_py.tasks.jobs.job import Job, JobOrder, JobState, Outcome
from skiros_py.tasks.jobs.manager import JobManager
from skiros_py.tasks.jobs.store import JobStore

NORTH = "ObjectAtLocation(starter_1, kit_1_a)"
SOUTH = "ObjectAtLocation(compressor_2, kit_2_a)"
MORE = "ObjectAtLocation(alternator_2, kit_2_b)"


@pytest.fixture
def session() -> Iterator[Session]:
    with Session("kitting_two", Options(fake=True)) as made:
        yield made


@pytest.fixture
def jobs(session: Session, tmp_path: Path) -> Iterator[JobManager]:
    with closing(JobStore(tmp_path / "jobs.db")) as store:
        yield JobManager(session.tasks, session.runtime, store, session.parse, at_once=2)


def order(id_: str, goal: str) -> JobOrder:
    return JobOrder(id=id_, goal=(goal,))


def until(session: Session, reached: Callable[[], object], cycles: int = 60_000) -> None:
    for _ in range(cycles):
        if reached():
            return
        session.cycle.step()
    raise AssertionError("it was never reached")


def running(jobs: JobManager) -> list[str]:
    return [job.id for job in jobs.store.page().jobs if job.state is JobState.RUNNING]


def times(jobs: JobManager, job: str, what: str) -> list[float]:
    return [entry["time"] for entry in jobs.trace(job) if entry["what"] == what]


def agents(jobs: JobManager, job: str) -> set[str]:
    return {entry["agent"][-1] for entry in jobs.trace(job) if entry["what"] == "started"}


def succeeded(job: Job) -> bool:
    return (job.state, job.outcome) == (JobState.ENDED, Outcome.SUCCEEDED)


def test_two_jobs_run_in_parallel_each_on_its_own_robot(session: Session, jobs: JobManager) -> None:
    jobs.submit(order("a", NORTH))
    jobs.submit(order("b", SOUTH))
    until(session, lambda: jobs.idle)

    assert all(map(succeeded, jobs.store.page().jobs))
    assert agents(jobs, "a").isdisjoint(agents(jobs, "b"))
    assert times(jobs, "a", "started")[0] < times(jobs, "b", "ended")[0]
    assert times(jobs, "b", "started")[0] < times(jobs, "a", "ended")[0]


def test_no_more_jobs_run_at_once_than_the_limit_and_the_next_one_starts_afterwards(
    session: Session, jobs: JobManager
) -> None:
    for id_, goal in (("a", NORTH), ("b", SOUTH), ("c", MORE)):
        jobs.submit(order(id_, goal))
    together: list[int] = []
    until(session, lambda: together.append(len(running(jobs))) or jobs.idle)

    assert max(together) == 2
    assert all(map(succeeded, jobs.store.page().jobs))


def test_a_job_that_needs_a_part_of_another_job_waits_for_it_and_plans_with_the_resulting_world(
    session: Session, jobs: JobManager
) -> None:
    jobs.submit(order("a", NORTH))
    jobs.submit(order("b", "ObjectAtLocation(starter_1, kit_2_a)"))
    until(session, lambda: jobs.idle)

    assert succeeded(jobs.job("a"))
    assert jobs.job("b").outcome is Outcome.NO_PLAN, "nobody takes a part out of a kit"
    assert "starter_1 is in kit_1_a" in jobs.job("b").actuals[0].reason
    assert times(jobs, "b", "started") == []
    assert any("(a)" in entry["text"] for entry in jobs.trace("b") if entry["what"] == "waits")


def test_stopping_one_job_does_not_affect_the_other(session: Session, jobs: JobManager) -> None:
    jobs.submit(order("a", NORTH))
    jobs.submit(order("b", SOUTH))
    until(session, lambda: len(running(jobs)) == 2 and session.cycle.board.now > 7.0)
    jobs.stop("a", "enough")
    until(session, lambda: jobs.idle)

    assert jobs.job("a").outcome is Outcome.STOPPED
    assert succeeded(jobs.job("b"))


def test_a_halt_in_the_first_cycle_of_a_job_holds_it_for_a_person(session: Session, jobs: JobManager) -> None:
    jobs.submit(order("a", NORTH))
    until(session, lambda: running(jobs))
    session.cycle.stop_all("somebody hit the button")
    session.cycle.step()
    assert jobs.job("a").state is JobState.INTERRUPTED
    session.reset()
    jobs.answer("a", "retry", by="ann")
    until(session, lambda: jobs.idle)

    assert succeeded(jobs.job("a"))


def test_after_a_halt_both_jobs_are_held_and_a_retry_finishes_both(session: Session, jobs: JobManager) -> None:
    jobs.submit(order("a", NORTH))
    jobs.submit(order("b", SOUTH))
    until(session, lambda: session.cycle.board.now > 7.0)
    session.cycle.stop_all("somebody hit the button")
    session.cycle.step()
    assert {job.state for job in jobs.store.page().jobs} == {JobState.INTERRUPTED}
    session.reset()
    for id_ in "ab":
        jobs.answer(id_, "retry", by="ann")
    until(session, lambda: jobs.idle)

    assert all(map(succeeded, jobs.store.page().jobs))
