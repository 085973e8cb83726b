"""Under pace the control thread does not wait for the disk, and no step begins before its intent is safe there."""

from __future__ import annotations

import errno
import os
import time
from collections.abc import Iterator
from contextlib import closing
from itertools import count
from pathlib import Path

import pytest

from skiros_py.planning.planners.fast_downward import FastDownward
from skiros_py.planning.process import ThreadHost
from skiros_py.tasks.jobs.job import JobOrder, Outcome
from skiros_py.tasks.jobs.manager import JobManager
from skiros_py.tasks.jobs.store import JobStore
from skiros_py.tasks.task_manager import TaskManager
from skiros_py.testing import Bench, tiny_world

ORDER = JobOrder(id="a", goal=("In(ball_1, slot_1)",))
SLOW = 0.3
"""How long the disk takes [s]."""


class Paced:
    """A cell whose time goes on while something is waited for, with jobs."""

    def __init__(self, folder: Path) -> None:
        self.log: list[tuple[str, int]] = []
        self.bench = Bench(tiny_world())
        self.bench.cycle.pace = 100.0
        self.planner = FastDownward()
        self.planning = ThreadHost(self.bench.world, self.planner)
        self.store = JobStore(folder / "jobs.db")
        tasks = TaskManager(self.bench.runtime, self.planning, "paced")
        self.jobs = JobManager(tasks, self.bench.runtime, self.store, lambda texts: self.bench.goal(*texts))

    def close(self) -> None:
        for one in (self.store, self.planning, self.planner, self.bench):
            one.close()

    def longest_cycle(self) -> float:
        """Runs cycles until nothing is to be done; returns the wall time of the longest [s]."""
        longest, deadline = 0.0, time.monotonic() + 60.0
        while not self.jobs.idle:
            assert time.monotonic() < deadline
            started = time.perf_counter()
            self.bench.cycle.step()
            longest = max(longest, time.perf_counter() - started)
        return longest


@pytest.fixture
def paced(tmp_path: Path) -> Iterator[Paced]:
    with closing(Paced(tmp_path)) as paced:
        yield paced


@pytest.fixture
def slow(paced: Paced, monkeypatch: pytest.MonkeyPatch) -> None:
    """Makes the disk slow, and notes when it is waited for."""
    really, numbers = os.fsync, count()

    def fsync(descriptor: int) -> None:
        number = next(numbers)
        paced.log.append(("sync begins", number))
        time.sleep(SLOW)
        really(descriptor)
        paced.log.append(("sync ends", number))

    monkeypatch.setattr(os, "fsync", fsync)


@pytest.mark.usefixtures("slow")
def test_the_cycle_runs_during_slow_writes_and_each_step_starts_after_its_intent_is_stored(
    paced: Paced, monkeypatch: pytest.MonkeyPatch
) -> None:
    intend = paced.store.intend
    monkeypatch.setattr(
        paced.store, "intend", lambda *told: (number := intend(*told), paced.log.append(("intend", number)))[0]
    )
    paced.bench.monitor.subscribe(
        lambda event: (
            paced.log.append(("starts", 0)) if event.kind == "skill" and event.status.name == "STARTED" else None
        )
    )
    paced.jobs.submit(ORDER)
    longest = paced.longest_cycle()

    assert paced.jobs.job("a").outcome is Outcome.SUCCEEDED
    assert longest < SLOW
    starts = [index for index, (what, _) in enumerate(paced.log) if what == "starts"]
    intents = [index for index, (what, _) in enumerate(paced.log) if what == "intend"]
    assert len(starts) == len(intents) == 3
    for intent, start in zip(intents, starts, strict=True):
        between = paced.log[intent:start]
        assert any(("sync begins", number) in between and ("sync ends", number) in between for number in range(100))


@pytest.mark.usefixtures("slow")
def test_an_order_is_stored_before_it_is_acknowledged_and_announced(paced: Paced) -> None:
    paced.jobs.subscribe(lambda job: paced.log.append((f"told {job.state.name}", 0)))
    paced.jobs.submit(ORDER, start=False)

    assert [what for what, _ in paced.log] == ["sync begins", "sync ends", "told NOT_ALLOWED_TO_START"]


def test_a_step_whose_intent_cannot_be_stored_is_not_started(paced: Paced, monkeypatch: pytest.MonkeyPatch) -> None:
    paced.jobs.submit(ORDER)

    def full(_descriptor: int) -> None:
        raise OSError(errno.ENOSPC, "the disk is full")

    monkeypatch.setattr(os, "fsync", full)
    paced.longest_cycle()
    job = paced.jobs.job("a")

    assert job.outcome is Outcome.FAILED
    assert "the disk is full" in "; ".join(job.reasons)
    assert not [event for event in paced.bench.events if event.kind == "skill"]
