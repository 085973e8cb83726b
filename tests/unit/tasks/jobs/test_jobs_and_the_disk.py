"""Under pace the control thread does not wait for the disk, and no step begins before its intent is safe there."""

from __future__ import annotations

import errno
import os
import resource
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, closing, contextmanager
from itertools import count
from pathlib import Path

import pytest

from skiros_py.errors import DiskFault
from skiros_py.planning.planners.fast_downward import FastDownward
from skiros_py.planning.process import ThreadHost
from skiros_py.tasks.jobs.job import JobOrder, JobState, Outcome
from skiros_py.tasks.jobs.manager import JobManager, Submission
from skiros_py.tasks.jobs.store import JobStore
from skiros_py.tasks.task_manager import TaskManager
from skiros_py.testing import Bench, tiny_world

ORDER = JobOrder(id="a", goal=("In(ball_1, slot_1)",))
HELD = ("hold", "resume")
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

    def step_until(self, done: Callable[[], bool]) -> None:
        """Runs cycles until something is so."""
        deadline = time.monotonic() + 60.0
        while not done():
            assert time.monotonic() < deadline
            self.bench.cycle.step()

    def longest_cycle(self) -> float:
        """Runs cycles until nothing is to be done; returns the wall time of the longest [s]."""
        longest, deadline = 0.0, time.monotonic() + 60.0
        while not self.jobs.idle:
            assert time.monotonic() < deadline
            started = time.perf_counter()
            self.bench.cycle.step()
            longest = max(longest, time.perf_counter() - started)
        return longest


@contextmanager
def no_room(file: Path) -> Iterator[None]:
    """Files of this process cannot grow: the kernel refuses it, as on a full disk."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (file.with_name(f"{file.name}-wal").stat().st_size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


@contextmanager
def broken(file: Path) -> Iterator[None]:
    """The kernel refuses with EIO what SQLite writes into, or reads from, the log of a file."""
    memory = os.open("/proc/self/mem", os.O_RDWR)  # the first pages of memory are never mapped
    links = [link for link in Path("/proc/self/fd").iterdir() if link.is_symlink()]
    logs = [int(link.name) for link in links if link.readlink().name == f"{file.name}-wal"]
    before = [os.dup(descriptor) for descriptor in logs]
    for descriptor in logs:
        os.dup2(memory, descriptor)
    try:
        yield
    finally:
        for descriptor, kept in zip(logs, before, strict=True):
            os.dup2(kept, descriptor)
            os.close(kept)
        os.close(memory)


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


@pytest.mark.parametrize("error", [errno.ENOSPC, errno.EIO, errno.EROFS])
def test_no_step_starts_while_its_intent_cannot_be_synced_and_the_job_goes_on_by_itself_afterwards(
    paced: Paced, monkeypatch: pytest.MonkeyPatch, error: int
) -> None:
    paced.jobs.submit(ORDER)

    def failing(_descriptor: int) -> None:
        raise OSError(error, os.strerror(error))

    with monkeypatch.context() as broken:
        broken.setattr(os, "fsync", failing)
        paced.step_until(lambda: bool(paced.jobs.fault))
        for _ in range(200):
            paced.bench.cycle.step()
        job = paced.jobs.shown(paced.jobs.job("a"))
        assert job.state is JobState.INTERRUPTED
        assert os.strerror(error) in job.detail
        assert not [event for event in paced.bench.events if event.kind == "skill"]
        unstored = paced.jobs.transitions("a")[-1]
        assert (unstored.trigger, unstored.comment) == ("hold", paced.jobs.fault)
    paced.step_until(lambda: paced.jobs.idle)

    assert paced.jobs.job("a").outcome is Outcome.SUCCEEDED
    hold, resume = (one for one in paced.jobs.transitions("a") if one.trigger in HELD)
    assert (hold, resume.trigger) == (unstored, "resume")
    assert resume.wall > hold.wall


@pytest.mark.parametrize("disk", [no_room, broken])
def test_a_write_that_fails_once_between_steps_holds_the_job_for_a_moment_only(
    paced: Paced, tmp_path: Path, disk: Callable[[Path], AbstractContextManager[None]]
) -> None:
    paced.jobs.submit(ORDER)
    paced.step_until(lambda: any(event.kind == "skill" for event in paced.bench.events))
    with disk(tmp_path / "jobs.db"):
        paced.step_until(lambda: bool(paced.jobs.fault))
        assert paced.jobs.shown(paced.jobs.job("a")).state is JobState.INTERRUPTED
        with pytest.raises(DiskFault):
            paced.jobs.submit_all([Submission(ORDER.model_copy(update={"id": id_})) for id_ in "bc"])
        for refused in (paced.jobs.stop, paced.jobs.abort):
            with pytest.raises(DiskFault):
                refused("a")
        assert set(paced.jobs.open) <= {"a"}
    assert [job.id for job in paced.store.page().jobs] == ["a"]
    paced.step_until(lambda: paced.jobs.idle)

    assert paced.jobs.job("a").outcome is Outcome.SUCCEEDED
    assert all(intent.ended == "done" for intent in paced.jobs.intents("a"))
    assert paced.jobs.submit(ORDER.model_copy(update={"id": "b"})).state is JobState.ALLOWED_TO_START
