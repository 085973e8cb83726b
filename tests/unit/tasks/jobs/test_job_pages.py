"""Jobs are read in pages, open or over; what is over is in the file only."""

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest

from skiros_py.tasks.jobs import store as module
from skiros_py.tasks.jobs.job import Job, JobOrder, JobState, Trigger
from skiros_py.tasks.jobs.store import JobStore

S = JobState


@pytest.fixture
def store(tmp_path: Path):
    store = JobStore(tmp_path / "jobs.db")
    yield store
    store.close()


def add(store: JobStore, id_: str, state: JobState, changed: float = 0.0) -> Job:
    order = JobOrder(id=id_, goal=("InKit(Starter, kit_1)",))
    return store.add(Job(order=order, number=0, state=state, changed=changed), Trigger.START)


def entries(*steps: int) -> list[dict[str, Any]]:
    """Returns entries of a trace, one for each step."""
    return [{"time": 0.0, "what": "started", "text": "a step", "data": {}, "step": step} for step in steps]


def test_pages_follow_each_other_without_gap_or_repeat(store):
    for number in range(25):
        add(store, f"j{number}", S.ENDED if number % 2 else S.RUNNING)
    seen, after = [], 0
    while after is not None:
        page = store.page(after=after, limit=10)
        seen += [job.id for job in page.jobs]
        after = page.next
    assert seen == [f"j{number}" for number in range(25)]


@pytest.mark.parametrize("since", [None, 5.0])
def test_pages_read_backwards_have_no_gap_or_repeat_while_jobs_are_added(store, since):
    for number in range(25):
        add(store, f"j{number}", S.ENDED, changed=10.0)
    seen, after, first = [], None, True
    while first or after is not None:
        page = store.page(after=after, limit=10, newest_first=True, since=since)
        add(store, f"late{len(seen)}", S.ENDED, changed=10.0)
        seen += [job.id for job in page.jobs]
        after, first = page.next, False
    assert seen == [f"j{number}" for number in reversed(range(25))]


def test_a_page_position_is_valid_in_both_directions(store):
    for name in "abcde":
        add(store, name, S.ENDED)
    middle = store.page(limit=3).next
    assert [job.id for job in store.page(after=middle).jobs] == ["d", "e"]
    assert [job.id for job in store.page(after=middle, newest_first=True).jobs] == ["b", "a"]


def test_the_newest_jobs_changed_since_a_time_are_on_the_first_page(store):
    for number in range(6):
        add(store, f"j{number}", S.ENDED if number % 2 else S.RUNNING, changed=float(number))
    page = store.page(since=2.0, states={S.ENDED}, limit=1, newest_first=True)
    assert ([job.id for job in page.jobs], page.next) == (["j5"], 6)
    assert [job.id for job in store.page(since=2.0, after=6, limit=9, newest_first=True).jobs] == ["j4", "j3", "j2"]


def test_a_full_last_page_has_no_next_page(store):
    for name in "abc":
        add(store, name, S.ENDED)
    assert store.page(limit=3).next is None
    assert store.page(limit=2).next == 2


def test_a_page_has_the_jobs_in_the_wanted_states_only(store):
    for name, state in zip("abcd", (S.RUNNING, S.ENDED, S.ABORTED, S.ENDED), strict=True):
        add(store, name, state)
    assert [job.id for job in store.page(states={S.ENDED}).jobs] == ["b", "d"]
    assert [job.id for job in store.page(states=(S.ABORTED, S.RUNNING)).jobs] == ["a", "c"]
    assert store.page(states=()).jobs == ()


def test_a_page_contains_only_jobs_changed_since_the_given_time(store):
    first = add(store, "a", S.RUNNING, changed=10.0)
    add(store, "b", S.RUNNING, changed=20.0)
    store.keep(first.but(state=S.ENDED, changed=30.0))
    assert [job.id for job in store.page(since=20.0).jobs] == ["a", "b"]
    assert [job.id for job in store.page(since=25.0).jobs] == ["a"]


def test_pages_of_changed_jobs_are_ordered_by_number_without_gap(store):
    jobs = [add(store, name, S.RUNNING, changed=1.0) for name in "abcdef"]
    for at, job in enumerate(reversed(jobs[1:])):
        store.keep(job.but(state=S.ENDED, changed=10.0 + at))
    first = store.page(since=5.0, limit=3)
    assert [job.id for job in first.jobs] == ["b", "c", "d"]
    rest = store.page(since=5.0, limit=3, after=first.next)
    assert ([job.id for job in rest.jobs], rest.next) == (["e", "f"], None)
    assert [job.id for job in store.page(since=12.0, states=[S.ENDED]).jobs] == ["b", "c", "d"]


def test_a_page_of_very_large_jobs_is_shorter_and_no_job_is_left_out(store, monkeypatch):
    monkeypatch.setattr(module, "_ROOM", 3000)
    for name in "abcd":
        store.add(Job(order=JobOrder(id=name, goal=("x" * 2000,)), number=0, state=S.ENDED), Trigger.START)
    seen, after = [], 0
    while after is not None:
        page = store.page(after=after)
        assert len(page.jobs) <= 2
        seen += [job.id for job in page.jobs]
        after = page.next
    assert seen == list("abcd")


def test_pages_can_be_read_during_a_write(store):
    add(store, "a", S.ENDED)
    with store._database.transaction() as connection, ThreadPoolExecutor(1) as pool:
        connection.execute("DELETE FROM jobs")
        assert [job.id for job in pool.submit(store.page).result(30.0).jobs] == ["a"]  # nothing is committed yet
    assert store.page().jobs == ()


def test_a_trace_is_read_piece_by_piece(store):
    store.add_trace("a", entries(*range(7)))
    page, rest = store.trace("a", skip=2, limit=3), store.trace("a", skip=5, limit=3)
    assert [entry["step"] for entry in (*page.entries, *rest.entries)] == [2, 3, 4, 5, 6]
    assert (page.next, rest.next) == (5, None)
    assert len(store.trace("a").entries) == 7
    assert store.trace("a", skip=10**30).entries == ()


@pytest.mark.parametrize(
    "damage", ["'{'", "'[]'", "'{}'", "replace(data, 'what', 'whut')", "CAST(x'7bff7d' AS TEXT)", "x'00'"]
)
def test_a_damaged_entry_of_a_trace_is_named_left_out_and_hides_no_other(store, damage):
    store.add_trace("a", entries(*range(1, 8)))
    with store._database.transaction() as connection:
        connection.execute(f"UPDATE trace SET data = {damage} WHERE rowid IN (3, 6)")
    seen, skip = [], 0
    while skip is not None:
        page = store.trace("a", skip=skip, limit=2)
        seen += [entry["step"] for entry in page.entries]
        skip = page.next
    assert seen == [1, 2, 4, 5, 7]
    assert list(store.unreadable) == ["entry 3 of the trace of job a", "entry 6 of the trace of job a"]


@pytest.mark.parametrize("after", [2**63, 10**30])
def test_a_page_after_an_impossibly_large_number_is_empty(store, after):
    add(store, "a", S.ENDED)
    assert store.page(after=after).jobs == ()
    assert [job.id for job in store.page(after=after, newest_first=True).jobs] == ["a"]


def test_an_ended_job_is_not_among_the_open_jobs(store):
    add(store, "a", S.ENDED)
    add(store, "b", S.INTERRUPTED)
    assert [job.id for job in store.open()] == ["b"]
    assert store.job("a").state is S.ENDED
    assert store.job("z") is None
    assert len(store.ids()) == 2
