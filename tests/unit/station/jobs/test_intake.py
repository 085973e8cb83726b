"""The intake of orders, on the tiny domain."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from concurrent.futures import wait
from contextlib import closing
from pathlib import Path

import pytest

from skiros_py.errors import Overloaded, UsageError
from skiros_py.station.jobs.intake import OrderIntake
from skiros_py.tasks.jobs.job import Job, JobOrder
from skiros_py.tasks.jobs.manager import JobManager, Submission
from skiros_py.tasks.jobs.store import JobStore
from skiros_py.testing import Bench, tiny_world

PATIENCE = 30.0


@pytest.fixture
def jobs(tmp_path: Path) -> Iterator[JobManager]:
    with Bench(tiny_world()) as bench, closing(JobStore(tmp_path / "jobs.db")) as store:
        yield JobManager(bench.tasks, bench.runtime, store, lambda texts: bench.goal(*texts))


@pytest.fixture
def intake(jobs: JobManager) -> Iterator[OrderIntake[Job]]:
    with closing(OrderIntake[Job](lambda: jobs)) as intake:
        intake.start()
        yield intake


def submission(id_: str, goal: str = "In(ball_1, slot_1)") -> Submission:
    return Submission(JobOrder(id=id_, goal=(goal,)), start=False)


def as_it_is(job: Job) -> Job:
    return job


def test_every_order_gets_its_own_answer(intake: OrderIntake[Job], jobs: JobManager) -> None:
    names = [f"job-{number}" for number in range(50)]
    good = [intake.ask(lambda name=name: submission(name), as_it_is) for name in names]
    wrong = intake.ask(lambda: submission("wrong", "Nonsense("), as_it_is)

    assert [answer.result(PATIENCE).id for answer in good] == names
    assert isinstance(wrong.exception(PATIENCE), UsageError)
    assert list(jobs.open) == names


def test_an_order_that_cannot_be_read_does_not_affect_those_beside_it(intake: OrderIntake[Job]) -> None:
    hold = threading.Event()
    first = intake.ask(lambda: submission("first") if hold.wait(PATIENCE) else submission("late"), as_it_is)
    broken = intake.ask(lambda: submission(str(1 / 0)), as_it_is)
    last = intake.ask(lambda: submission("last"), as_it_is)
    hold.set()

    assert isinstance(broken.exception(PATIENCE), ZeroDivisionError)
    assert (first.result(PATIENCE).id, last.result(PATIENCE).id) == ("first", "last")


def test_orders_are_refused_at_once_while_too_many_wait_and_accepted_again_afterwards(intake: OrderIntake[Job]) -> None:
    hold = threading.Event()
    answers = [intake.ask(lambda: submission("held") if hold.wait(PATIENCE) else submission("late"), as_it_is)]
    many = (intake.ask(lambda number=number: submission(f"job-{number}"), as_it_is) for number in range(1000))
    with pytest.raises(Overloaded) as refused:
        answers.extend(many)
    hold.set()

    assert refused.value.retry_after > 0
    assert not wait(answers, PATIENCE).not_done
    assert intake.ask(lambda: submission("after"), as_it_is).result(PATIENCE).id == "after"


def test_orders_that_wait_at_the_end_are_still_answered(jobs: JobManager) -> None:
    intake = OrderIntake[Job](lambda: jobs)
    answers = [intake.ask(lambda name=name: submission(name), as_it_is) for name in "abc"]
    intake.start()
    intake.close()
    jobs.store.flush()

    assert [answer.result(PATIENCE).id for answer in answers] == ["a", "b", "c"]


def test_an_answer_that_is_cancelled_ends_nothing(intake: OrderIntake[Job]) -> None:
    answers = [intake.ask(lambda n=n: submission(f"job-{n}"), as_it_is) for n in range(20)]
    assert not any(answer.cancel() for answer in answers if not answer.done())

    assert intake.ask(lambda: submission("later"), as_it_is).result(PATIENCE).id == "later"
