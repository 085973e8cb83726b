"""Ordering and the control cycle get along: neither waits for what the other does with the disk."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import closing
from datetime import UTC, datetime
from pathlib import Path

import pytest

from skiros_py.tasks.jobs.job import Job, JobOrder, Outcome, Trigger
from skiros_py.tasks.jobs.manager import JobManager
from skiros_py.tasks.jobs.queue import JobBook
from skiros_py.tasks.jobs.run import JobRun
from skiros_py.tasks.jobs.store import JobStore
from skiros_py.testing import Bench, tiny_world

GATE = datetime.fromtimestamp(2.0**33, UTC)


@pytest.fixture
def bench() -> Iterator[Bench]:
    with Bench(tiny_world()) as bench:
        yield bench


@pytest.fixture
def jobs(bench: Bench, tmp_path: Path) -> Iterator[JobManager]:
    with closing(JobStore(tmp_path / "jobs.db")) as store:
        yield JobManager(bench.tasks, bench.runtime, store, lambda texts: bench.goal(*texts))


def order(id_: str, goal: str = "In(ball_1, slot_1)", **more: object) -> JobOrder:
    return JobOrder(id=id_, goal=(goal,), **more)


def steps_while_a_command_is_kept(jobs: JobManager, bench: Bench, command: JobOrder, cycles: int) -> bool:
    """Runs cycles in a thread of their own while a command holds the guard; returns whether they came to an end."""
    holds, enough = threading.Event(), threading.Event()

    def linger(job: Job) -> None:  # a listener is called when the disk has been waited for
        if job.id == command.id:
            holds.set()
            enough.wait(20.0)

    end = jobs.subscribe(linger)
    ordering = threading.Thread(target=jobs.submit, args=(command,))
    ordering.start()
    assert holds.wait(20.0)
    stepping = threading.Thread(target=lambda: [bench.cycle.step() for _ in range(cycles)])
    stepping.start()
    stepping.join(10.0)
    ended = not stepping.is_alive()
    enough.set()
    stepping.join()
    ordering.join()
    end()
    return ended


def test_the_cycle_runs_while_an_order_is_being_stored(jobs, bench):
    assert steps_while_a_command_is_kept(jobs, bench, order("b", not_before=GATE), 200)


def test_a_running_motion_continues_while_an_order_is_being_stored(jobs, bench):
    jobs.submit(order("a"))
    bench.until(lambda: any(intent.skill == "drive" for intent in jobs.intents("a")))
    bench.cycle.step()
    assert steps_while_a_command_is_kept(jobs, bench, order("b", not_before=GATE), 10)
    bench.until(lambda: "a" not in jobs.open)
    assert jobs.job("a").outcome is Outcome.SUCCEEDED


def test_the_complete_trace_is_written_before_the_end_of_a_job_is_announced(bench, tmp_path):
    """Who hears of the end reads the trace for the last time."""
    with closing(JobStore(tmp_path / "jobs.db")) as store:
        book = JobBook(store, lambda: 0.0)
        book.show(book.add(order("a"), start=True, comment=""))
        job = book.move(book.open["a"], Trigger.DISPATCH)
        task = bench.tasks.begin(bench.goal(*job.order.goal), name="a")
        run = JobRun(task, bench.runtime, book)
        bench.until(lambda: task.done)
        written: list[int] = []
        book.subscribe(lambda each: written.append(len(store.trace(each.id).entries)))

        assert run.follow(job)
        store.flush()

        assert written == [len(store.trace("a").entries)]
        assert written[0] > 0


def test_orders_from_many_threads_are_each_executed_once(jobs, bench):
    def take(thread: int) -> None:
        for number in range(5):
            jobs.submit(order(f"{thread}-{number}", "In(ball_1, box_a)"))

    threads = [threading.Thread(target=take, args=(number,)) for number in range(4)]
    for thread in threads:
        thread.start()
    while any(thread.is_alive() for thread in threads):
        bench.cycle.step()
    bench.until(lambda: not jobs.open)
    begun = [told.job.id for told in jobs.store.announcements(0, 1000) if told.trigger == "dispatch"]
    assert sorted(begun) == sorted({f"{thread}-{number}" for thread in range(4) for number in range(5)})
    assert {job.outcome for job in jobs.store.page().jobs} == {Outcome.ALREADY_SATISFIED}


def test_a_listener_may_give_commands_itself_also_while_others_order(jobs, bench):
    def clear_at_once(job: Job) -> None:
        if not job.state.is_open:
            jobs.clear(job.id)

    def take(thread: int) -> None:
        for number in range(20):
            jobs.submit(order(f"{thread}-{number}", not_before=GATE))

    jobs.subscribe(clear_at_once)
    jobs.submit(order("a", "In(ball_1, box_a)"))
    threads = [threading.Thread(target=take, args=(number,)) for number in range(4)]
    for thread in threads:
        thread.start()
    bench.until(lambda: jobs.find("a") is None)
    for thread in threads:
        thread.join()
    assert len(jobs.store.page().jobs) == 80
