"""Orders that come twice, at once, too many, too late or as something else; on the tiny domain."""

from __future__ import annotations

import sqlite3
import threading
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from pathlib import Path

import pytest

from skiros_py.errors import Busy, FileError, KeyReused, Removed, StaleVersion, UnknownName, UsageError, WrongState
from skiros_py.tasks.jobs.job import Job, JobOrder, JobState, Outcome
from skiros_py.tasks.jobs.manager import JobManager, Submission
from skiros_py.tasks.jobs.store import JobStore, Receipt
from skiros_py.testing import Bench, tiny_world

GOAL = "In(ball_1, slot_1)"
HOLDS = "In(ball_1, box_a)"
MES = Receipt("mes", "request-1", "digest")


@pytest.fixture
def bench() -> Iterator[Bench]:
    with Bench(tiny_world()) as bench:
        yield bench


@pytest.fixture
def store(tmp_path: Path) -> Iterator[JobStore]:
    with closing(JobStore(tmp_path / "jobs.db")) as store:
        yield store


@pytest.fixture
def jobs(bench: Bench, store: JobStore) -> JobManager:
    return JobManager(bench.tasks, bench.runtime, store, lambda texts: bench.goal(*texts))


def order(id_: str = "a", goal: str = GOAL, **more: object) -> JobOrder:
    return JobOrder(id=id_, goal=(goal,), **more)


def done(jobs: JobManager, bench: Bench, id_: str = "a") -> Job:
    """Orders something that holds already, and returns it when it is over."""
    jobs.submit(order(id_, HOLDS))
    bench.until(lambda: not jobs.job(id_).state.is_open)
    return jobs.job(id_)


# ---------------------------------------------------------------------- the same again


def test_one_order_submitted_by_fifty_threads_at_once_creates_one_job(jobs, store):
    together = threading.Barrier(50)

    def submit(_number: int) -> Job:
        together.wait()
        return jobs.submit(order(), receipt=MES)

    with ThreadPoolExecutor(50) as pool:
        answers = list(pool.map(submit, range(50)))
    assert len(set(map(Job.model_dump_json, answers))) == 1
    assert (len(store.ids()), store.last_announcement, answers[0].number) == (1, 1, 1)


def test_different_orders_from_many_threads_are_accepted_and_numbered_without_gap(jobs, store):
    with ThreadPoolExecutor(8) as pool:
        numbers = [job.number for job in pool.map(lambda n: jobs.submit(order(f"j{n}")), range(80))]
    assert sorted(numbers) == list(range(1, 81))
    assert [job.number for job in store.open()] == list(range(1, 81))


def test_repeating_an_order_returns_its_job_even_if_its_goal_is_no_longer_valid(jobs, bench):
    first = jobs.submit(order())
    with bench.world.transaction("test", "it is gone") as tx:
        tx.remove("ball_1")
    assert jobs.submit(order()) == first


def test_repeating_an_order_after_its_end_returns_its_job(jobs, bench):
    over = done(jobs, bench)
    assert jobs.submit(order(goal=HOLDS)) == over


def test_another_order_under_a_used_id_is_refused_and_the_job_is_unchanged(jobs):
    first = jobs.submit(order())
    with pytest.raises(WrongState, match="'a' is there already"):
        jobs.submit(order(goal="In(ball_1, slot_2)"))
    assert jobs.job("a") == first


def test_a_stored_order_keeps_its_parameters_and_materials(bench, store):
    sent = order(
        work_master="kit", parameters={"Kit": "kit_1"}, materials=({"class": "tiny:Ball", "quantity": 2, "use": "x"},)
    )
    JobManager(bench.tasks, bench.runtime, store, lambda texts: bench.goal(*texts)).submit(sent)
    (kept,) = store.open()
    assert kept.order == sent
    assert (kept.order.materials[0].class_, kept.order.materials[0].quantity) == ("tiny:Ball", 2)


# ---------------------------------------------------------------------- receipts


def test_repeating_a_request_with_a_generated_id_returns_the_same_job(jobs):
    first = jobs.submit(order("made-1"), receipt=MES)
    assert jobs.submit(order("made-2"), receipt=MES) == first
    assert list(jobs.open) == ["made-1"]
    assert jobs.store.known(MES) == first


def test_an_idempotency_key_used_for_another_request_is_refused(jobs):
    jobs.submit(order("a"), receipt=MES)
    with pytest.raises(KeyReused, match="'request-1' was used for another order"):
        jobs.submit(order("b"), receipt=Receipt("mes", "request-1", "another digest"))
    assert list(jobs.open) == ["a"]


def test_idempotency_keys_of_different_callers_are_independent(jobs):
    jobs.submit(order("a"), receipt=MES)
    jobs.submit(order("b"), receipt=Receipt("ann", "request-1", "another digest"))
    assert list(jobs.open) == ["a", "b"]


def test_a_refused_request_does_not_use_up_its_idempotency_key(jobs):
    with pytest.raises(UnknownName):
        jobs.submit(order(goal="In(ball_77, slot_1)"), receipt=MES)
    assert jobs.store.known(MES) is None
    assert jobs.submit(order(), receipt=MES).id == "a"


def test_the_idempotency_key_of_a_request_for_an_existing_job_is_stored(jobs):
    first = jobs.submit(order())
    assert jobs.submit(order(), receipt=MES) == first
    assert jobs.store.known(MES) == first


def test_a_late_repeat_of_a_request_does_not_restart_a_cleared_job(jobs, bench):
    jobs.submit(order(goal=HOLDS), receipt=MES)
    bench.until(lambda: not jobs.job("a").state.is_open)
    last = jobs.clear("a")
    assert jobs.submit(order(goal=HOLDS), receipt=MES) == last
    assert not jobs.store.page().jobs


def test_receipts_are_deleted_after_one_day(bench, store):
    now = [0.0]
    jobs = JobManager(bench.tasks, bench.runtime, store, lambda t: bench.goal(*t), clock=lambda: now[0])
    jobs.submit(order("a"), receipt=MES)
    now[0] = 24 * 3600.0
    jobs.submit(order("b"), receipt=Receipt("mes", "request-2", "digest"))
    assert jobs.store.known(MES) is not None
    now[0] += 1.0
    jobs.submit(order("c"), receipt=Receipt("mes", "request-3", "digest"))
    assert jobs.store.known(MES) is None


# ---------------------------------------------------------------------- too many


def test_orders_beyond_the_limit_of_open_jobs_are_refused_and_earlier_jobs_are_kept(jobs, bench):
    jobs.limit = 2
    first, second = (jobs.submit(order(name, HOLDS)) for name in "ab")
    with pytest.raises(Busy, match="2 jobs are open"):
        jobs.submit(order("c", HOLDS))
    assert jobs.submit(order("a", HOLDS)) == first
    assert list(jobs.open.values()) == [first, second]
    bench.until(lambda: not jobs.open)
    assert jobs.submit(order("c", HOLDS)).number == 3


# ---------------------------------------------------------------------- several together


def commits(file: Path) -> int:
    """Returns the number of transactions in the write-ahead log of a database (SQLite file format, section 4.1)."""
    log = file.with_name(f"{file.name}-wal").read_bytes()
    page = int.from_bytes(log[8:12])
    frames = (log[start : start + 24] for start in range(32, len(log), 24 + page))
    return sum(frame[4:8] != bytes(4) for frame in frames)


def test_orders_accepted_together_are_one_transaction_and_each_is_refused_for_its_own_reasons(jobs, tmp_path):
    jobs.submit(order("first"))
    before = commits(tmp_path / "jobs.db")
    wanted = [
        Submission(order("a")),
        Submission(order("b", "Nonsense(")),
        Submission(order("a")),
        Submission(order("a", HOLDS)),
        Submission(order("c"), receipt=MES),
        Submission(order("d"), receipt=MES),
    ]

    first, wrong, same, other, third, again = jobs.submit_all(wanted)

    assert commits(tmp_path / "jobs.db") == before + 1
    assert isinstance(wrong, UsageError)
    assert isinstance(other, WrongState)
    assert (same, again) == (first, third)
    assert list(jobs.open.values())[1:] == [first, third]


def test_a_stored_job_that_cannot_be_read_refuses_only_the_orders_with_its_id(jobs, bench, tmp_path):
    done(jobs, bench)
    with closing(sqlite3.connect(tmp_path / "jobs.db")) as connection, connection:
        connection.execute("UPDATE jobs SET data = '{' WHERE id = 'a'")

    first, unreadable, last = jobs.submit_all([Submission(order(id_)) for id_ in ("b", "a", "c")])

    assert isinstance(unreadable, FileError)
    assert (list(jobs.open), jobs.open["b"], jobs.open["c"]) == (["b", "c"], first, last)


# ---------------------------------------------------------------------- updates and versions


def test_an_order_can_be_updated_with_its_latest_version(jobs):
    first = jobs.submit(order())
    second = jobs.update(order(priority=1), "urgent", expects=first.version)
    assert (second.order.priority, second.version) == (1, first.version + 1)
    with pytest.raises(StaleVersion, match=r"'a' has changed: version 2, not 1 any more"):
        jobs.update(order(priority=2), expects=first.version)
    assert jobs.job("a") == second


def test_a_reused_job_id_gets_a_newer_version_than_the_earlier_job(jobs):
    first = jobs.submit(order())
    cleared = jobs.cancel("a")
    again = jobs.submit(order(), again=True)
    assert again.version > cleared.version >= first.version
    with pytest.raises(StaleVersion):
        jobs.cancel("a", expects=first.version)


def test_updating_a_job_with_an_equal_order_changes_nothing(jobs):
    first = jobs.submit(order())
    assert jobs.update(order()) == first


def test_a_started_job_refuses_another_order(jobs, bench):
    over = done(jobs, bench)
    with pytest.raises(WrongState, match="takes no update"):
        jobs.update(order(priority=3))
    assert jobs.job("a") == over


@pytest.mark.parametrize("command", ["start", "revoke_start", "pause", "resume", "stop", "abort", "cancel", "clear"])
def test_every_command_without_the_latest_version_is_refused(jobs, command):
    first = jobs.submit(order())
    with pytest.raises(StaleVersion, match="look again, then decide"):
        getattr(jobs, command)("a", expects=first.version + 7)
    assert jobs.job("a") == first


# ---------------------------------------------------------------------- removing


def test_a_waiting_job_can_be_cancelled_but_not_cleared(jobs, store):
    jobs.submit(order())
    with pytest.raises(WrongState, match="'a' is not over"):
        jobs.clear("a")
    assert jobs.cancel("a").id == "a"
    assert jobs.find("a") is None
    assert store.announcements(0, 9)[-1].trigger == "cancelled"


def test_an_ended_job_can_be_cleared_but_not_cancelled(jobs, bench, store):
    assert done(jobs, bench).outcome is Outcome.ALREADY_SATISFIED
    with pytest.raises(WrongState, match="is over: clear it"):
        jobs.cancel("a")
    assert jobs.clear("a").state is JobState.ENDED
    assert store.announcements(0, 9)[-1].trigger == "cleared"
    with pytest.raises(UnknownName, match="job 'a'"):
        jobs.job("a")


def test_the_id_of_a_cancelled_job_can_be_reused_only_on_request(jobs, bench):
    first = jobs.submit(order(goal="In(ball_1, slot_2)", priority=5))
    jobs.cancel("a")
    with pytest.raises(WrongState, match="there was a job 'a' with another order"):
        jobs.submit(order(goal=HOLDS))
    second = jobs.submit(order(goal=HOLDS), again=True)
    assert second.number == first.number + 1
    bench.until(lambda: not jobs.open)
    assert jobs.job("a").outcome is Outcome.ALREADY_SATISFIED


@pytest.mark.parametrize("removed", ["cancelled", "cleared"])
def test_a_late_repeat_of_an_order_does_not_restore_a_removed_job(jobs, bench, store, removed):
    last = jobs.submit(order()) if removed == "cancelled" else done(jobs, bench)
    last = jobs.cancel("a") if removed == "cancelled" else jobs.clear("a")
    with pytest.raises(Removed, match="'a' was removed"):
        jobs.submit(last.order)
    assert not jobs.open
    assert jobs.store.removed("a").state is last.state
    assert jobs.store.removed("a").outcome is last.outcome


def test_the_removal_of_a_job_is_remembered_for_a_week_and_across_restarts(tmp_path, bench):
    now = [1e9]

    def life(store: JobStore) -> JobManager:
        return JobManager(bench.tasks, bench.runtime, store, lambda t: bench.goal(*t), clock=lambda: now[0])

    with closing(JobStore(tmp_path / "jobs.db")) as store:
        first = life(store)
        first.submit(order(goal="In(ball_1, slot_2)"), start=False)
        first.cancel("a")
    with closing(JobStore(tmp_path / "jobs.db")) as store:
        second = life(store)
        now[0] += 6 * 24 * 3600
        with pytest.raises(Removed):
            second.submit(order(goal="In(ball_1, slot_2)"))
        now[0] += 2 * 24 * 3600
        second.submit(order("b"), start=False)
        second.cancel("b")
        assert second.store.removed("a") is None


# ---------------------------------------------------------------------- what is over


def test_an_ended_job_is_read_from_the_store_and_not_kept_in_memory(jobs, bench):
    over = done(jobs, bench)
    assert not jobs.open
    assert (jobs.job("a"), list(jobs.store.page().jobs), jobs.store.page().jobs) == (over, [over], (over,))


def test_iterating_over_open_jobs_is_not_disturbed_by_new_ones(jobs):
    for name in "abc":
        jobs.submit(order(name))
    seen = []
    for id_, job in jobs.open.items():
        jobs.cancel(id_)
        jobs.submit(order(f"{id_}{id_}"))
        seen.append(job.id)
    assert seen == ["a", "b", "c"]
    assert list(jobs.open) == ["aa", "bb", "cc"]


def test_a_job_ordered_without_permission_to_start_is_stored_and_can_be_started_later(jobs):
    jobs.submit(order(), start=False, comment="for tomorrow")
    jobs.start("a", "go")
    assert [(each.trigger, each.comment) for each in jobs.transitions("a")] == [
        ("store", "for tomorrow"),
        ("start", "go"),
    ]
