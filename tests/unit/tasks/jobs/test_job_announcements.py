"""Each new state of a job is announced once, with a number of its own, until somebody says that it was told."""

from pathlib import Path

import pytest

from skiros_py.tasks.jobs import store as stored
from skiros_py.tasks.jobs.job import Job, JobOrder, JobState, Trigger
from skiros_py.tasks.jobs.store import JobStore


@pytest.fixture
def store(tmp_path: Path):
    store = JobStore(tmp_path / "jobs.db")
    yield store
    store.close()


def job(id_: str = "a", state: JobState = JobState.ALLOWED_TO_START, **more: object) -> Job:
    return Job(order=JobOrder(id=id_, goal=("InKit(Starter, kit_1)",)), number=1, state=state, **more)


def told(store: JobStore, after: int = 0) -> list[tuple[int, str, str]]:
    return [(each.number, each.job.id, each.trigger) for each in store.announcements(after, 100)]


def test_only_state_changes_of_a_job_are_announced(store):
    first = store.add(job(), Trigger.START)
    store.keep(first.but(detail="queued"))
    store.keep(first.but(state=JobState.RUNNING), Trigger.DISPATCH)
    assert told(store) == [(1, "a", "start"), (2, "a", "dispatch")]
    assert [each.job.state for each in store.announcements(0, 9)] == [JobState.ALLOWED_TO_START, JobState.RUNNING]


def test_the_removal_of_a_job_is_announced_with_its_last_state(store):
    over = store.add(job(state=JobState.ENDED, detail="last"), Trigger.START)
    store.forget(over, "cleared")
    assert told(store)[-1] == (2, "a", "cleared")
    assert store.announcements(1, 9)[0].job == over


def test_announcements_omit_large_goals_and_plans(store):
    long = job().order.model_copy(update={"goal": ("x" * 50_000, "y")})
    first = store.add(Job(order=long, number=1, state=JobState.RUNNING), Trigger.START)
    store.keep(first.but(plan=("drive(robot_1, kit_1)",) * 1000), Trigger.DISPATCH)
    for each in store.announcements(0, 9):
        assert len(each.job.model_dump_json()) < 5000
    assert store.job("a").order == long


def test_announcements_are_read_in_limited_pages_from_a_given_number(store):
    for name in "abcd":
        store.add(job(name), Trigger.START)
    assert [number for number, *_ in told(store, after=2)] == [3, 4]
    assert [each.number for each in store.announcements(0, 2)] == [1, 2]


def test_announcement_numbers_continue_without_gap_after_a_restart(tmp_path, store):
    for name in "ab":
        store.add(job(name), Trigger.START)
    store.forget_announcements(2)
    store.close()
    again = JobStore(tmp_path / "jobs.db")
    assert again.last_announcement == 2
    again.add(job("c"), Trigger.START)
    assert told(again) == [(3, "c", "start")]
    again.close()


def test_without_a_reader_the_oldest_announcements_are_dropped(store, monkeypatch):
    monkeypatch.setattr(stored, "MOST_ANNOUNCEMENTS", 3)
    for number in range(10):
        store.add(job(f"j{number}"), Trigger.START)
    assert [number for number, *_ in told(store)] == [8, 9, 10]


def test_without_announcements_the_last_number_is_zero(store):
    assert store.last_announcement == 0
    assert told(store) == []
