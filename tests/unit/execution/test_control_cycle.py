from __future__ import annotations

import threading
import time
from collections.abc import Iterator

import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, rule

from skiros_py.devices.mobile_base import Base, BaseState, BaseTwist
from skiros_py.errors import ModuleError, UsageError
from skiros_py.execution.cycle import ControlCycle, Task
from skiros_py.ports.board import DeviceBoard
from skiros_py.simulation.fake.cell import FakeCell
from skiros_py.skills.cell_reader import read_cell
from skiros_py.testing import tiny_world

SPEC = read_cell(tiny_world(), ["robot_1"])


def new_cycle() -> ControlCycle:
    return ControlCycle(DeviceBoard(FakeCell(SPEC)))


def for_cycles(count: int, log: list[str], name: str) -> Iterator[None]:
    try:
        for _ in range(count):
            log.append(name)
            yield
    finally:
        log.append(f"{name} ends")
    return name  # type: ignore[return-value]


def test_a_task_starts_in_the_cycle_after_it_was_added() -> None:
    cycle, log = new_cycle(), []
    task = cycle.start(for_cycles(1, log, "a"))

    assert log == []
    cycle.step()
    assert log == ["a"]
    cycle.step()
    assert task.done


def test_tasks_are_ticked_in_the_order_they_were_added() -> None:
    cycle, log = new_cycle(), []
    for name in "bac":
        cycle.start(for_cycles(2, log, name))

    cycle.step()
    cycle.step()

    assert log == ["b", "a", "c"] * 2


def test_all_tasks_of_a_cycle_see_the_same_snapshot() -> None:
    cycle = new_cycle()
    seen: list[list[int]] = [[], []]

    def look(into: list[int]) -> Iterator[None]:
        while True:
            into.append(cycle.board.snapshot.cycle)
            yield

    for into in seen:
        cycle.start(look(into))
    for _ in range(3):
        cycle.step()

    assert seen[0] == seen[1] == [1, 2, 3]


def test_a_task_started_by_a_task_starts_in_the_same_cycle() -> None:
    cycle, log = new_cycle(), []

    def parent() -> Iterator[None]:
        cycle.start(for_cycles(1, log, "child"))
        log.append("parent")
        yield

    cycle.start(parent())
    cycle.step()
    assert log == ["parent", "child"]


def test_tasks_that_start_each_other_endlessly_do_not_block_the_cycle() -> None:
    cycle, log = new_cycle(), []

    def parent() -> Iterator[None]:
        log.append("tick")
        cycle.start(parent())
        yield

    cycle.start(parent())
    cycle.step()
    first = len(log)
    cycle.step()

    assert 1 < first < 1000
    assert len(log) > first


def test_running_a_task_gives_its_result() -> None:
    cycle, log = new_cycle(), []

    assert cycle.run(cycle.start(for_cycles(3, log, "a"))) == "a"


def test_stopping_a_task_closes_its_generator_at_once() -> None:
    cycle, log = new_cycle(), []
    task = cycle.start(for_cycles(9, log, "a"))
    cycle.step()

    task.stop()
    cycle.step()

    assert log == ["a", "a ends"]
    assert task.done
    assert task.stopped


def test_a_task_that_was_stopped_or_still_runs_has_no_result() -> None:
    cycle = new_cycle()
    running, stopped = cycle.start(for_cycles(9, [], "a")), cycle.start(for_cycles(9, [], "b"))
    stopped.stop()
    cycle.step()

    for task in (running, stopped):
        with pytest.raises(RuntimeError, match="only after it ended by itself"):
            _ = task.result


def test_stopping_a_task_that_is_done_keeps_its_result() -> None:
    cycle = new_cycle()
    task = cycle.start(for_cycles(1, [], "a"))
    cycle.run(task)

    task.stop()

    assert task.result == "a"


def test_a_task_that_raised_is_done_and_its_result_is_what_it_raised() -> None:
    cycle, log = new_cycle(), []

    def breaks() -> Iterator[None]:
        yield
        raise ZeroDivisionError("a fault")

    task = cycle.start(breaks())
    cycle.start(for_cycles(9, log, "a"))
    cycle.step()
    cycle.step()

    assert task.done
    with pytest.raises(ZeroDivisionError):
        _ = task.result
    cycle.step()
    assert log == ["a", "a", "a"], "the others go on"


def test_stopping_all_closes_every_task_and_waits_for_standstill() -> None:
    cycle, log = new_cycle(), []

    def drive() -> Iterator[None]:
        while True:
            Base(cycle.board, "base_1").command(BaseTwist(0.5, 0.0))
            yield

    cycle.start(drive())
    cycle.start(for_cycles(99, log, "a"))
    cycle.step()
    cycle.step()
    assert not cycle.board.still

    assert cycle.stop_all()
    assert log[-1] == "a ends"
    here = cycle.board.snapshot.state("base_1", BaseState).pose
    cycle.step()
    assert cycle.board.snapshot.state("base_1", BaseState).pose == here


def test_after_stop_all_no_task_starts_before_a_reset() -> None:
    cycle, log = new_cycle(), []
    cycle.stop_all("the light curtain was broken")

    with pytest.raises(
        UsageError, match=r"a cannot start: everything was halted \(the light curtain was broken\); reset"
    ):
        cycle.start(for_cycles(1, log, "a"), "a")

    cycle.reset()
    assert cycle.run(cycle.start(for_cycles(1, log, "a"))) == "a"


def test_reset_is_refused_while_something_moves() -> None:
    cycle = new_cycle()

    def drive() -> Iterator[None]:
        while True:
            Base(cycle.board, "base_1").command(BaseTwist(0.5, 0.0))
            yield

    task = cycle.start(drive())
    cycle.step()
    cycle.step()
    cycle.halt("somebody pressed the button")

    with pytest.raises(UsageError, match="a task still runs"):
        cycle.reset()
    task.stop()
    with pytest.raises(UsageError, match="something still moves"):
        cycle.reset()
    cycle.step()
    cycle.reset()


def test_halting_by_any_caller_stops_every_task() -> None:
    cycle, log = new_cycle(), []

    def presses_the_button() -> Iterator[None]:
        yield
        threading.Thread(target=cycle.halt, args=("a person came near",)).start()
        while not cycle.halted:
            time.sleep(0.001)
        yield

    tasks = [cycle.start(presses_the_button()), cycle.start(for_cycles(99, log, "a"))]
    for _ in range(3):
        cycle.step()

    assert all(task.done for task in tasks)
    assert log[-1] == "a ends"
    with pytest.raises(ModuleError, match="was stopped: a person came near"):
        cycle.run(tasks[0])


def test_commands_have_no_effect_while_halted() -> None:
    cycle = new_cycle()
    cycle.halt("a test")

    Base(cycle.board, "base_1").command(BaseTwist(0.5, 0.0))
    cycle.step()
    assert cycle.board.still

    cycle.reset()
    Base(cycle.board, "base_1").command(BaseTwist(0.5, 0.0))
    cycle.step()
    assert not cycle.board.still


def test_a_task_cannot_wait_for_its_own_end() -> None:
    cycle = new_cycle()

    def waits() -> Iterator[None]:
        cycle.stop_all()
        yield

    with pytest.raises(UsageError, match="a task cannot wait for its own end"):
        cycle.run(cycle.start(waits()))


def test_a_base_without_commands_stands_still() -> None:
    cycle = new_cycle()

    def nudge() -> Iterator[None]:
        Base(cycle.board, "base_1").command(BaseTwist(1.0, 0.0))
        yield

    cycle.start(nudge())
    for _ in range(5):
        cycle.step()

    assert cycle.board.snapshot.state("base_1", BaseState).pose.position[0] == pytest.approx(1.0 / 200.0)


def test_observers_are_called_at_the_end_of_each_cycle() -> None:
    cycle, log = new_cycle(), []
    cycle.start(for_cycles(2, log, "tick"))
    cycle.observe(lambda: log.append("seen"))

    cycle.step()
    cycle.step()

    assert log == ["tick", "seen", "tick", "seen"]


def test_the_time_of_the_cycle_is_the_time_of_the_cell() -> None:
    cycle = new_cycle()
    for _ in range(200):
        cycle.step()

    assert cycle.board.snapshot.time == pytest.approx(1.0)


class CycleMachine(RuleBasedStateMachine):
    """However tasks are added and stopped: each runs exactly until it ends or is stopped, and ends once."""

    def __init__(self) -> None:
        super().__init__()
        self.cycle = new_cycle()
        self.tasks: list[tuple[Task[object], list[str], int]] = []
        self.ticks: list[int] = []

    @rule(count=st.integers(0, 4))
    def add(self, count: int) -> None:
        log: list[str] = []
        self.tasks.append((self.cycle.start(for_cycles(count, log, "x")), log, count))
        self.ticks.append(0)

    @rule()
    def step(self) -> None:
        for index, (task, _, _) in enumerate(self.tasks):
            self.ticks[index] += not task.done
        self.cycle.step()

    @rule(index=st.integers(0, 9))
    def stop(self, index: int) -> None:
        if index < len(self.tasks):
            self.tasks[index][0].stop()

    @rule()
    def stop_all(self) -> None:
        self.cycle.stop_all()
        assert all(task.done for task, _, _ in self.tasks)
        self.cycle.reset()

    @invariant()
    def each_was_ticked_as_often_as_it_should(self) -> None:
        for (task, log, count), ticks in zip(self.tasks, self.ticks, strict=True):
            assert log.count("x") == min(ticks, count)
            assert log.count("x ends") <= 1
            assert task.done == (task.stopped or ticks > count)
            if task.done and not task.stopped:
                assert task.result == "x"


TestCycleMachine = CycleMachine.TestCase
TestCycleMachine.settings = settings(max_examples=50, stateful_step_count=20, deadline=None)
