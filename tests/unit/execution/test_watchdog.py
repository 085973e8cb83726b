"""Code that holds the control cycle is named and interrupted, and everything brakes: real threads, real hogs."""

from __future__ import annotations

import contextlib
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator

import pytest

from skiros_py.devices.mobile_base import Base, BaseTwist
from skiros_py.errors import ModuleError, UsageError
from skiros_py.execution.cycle import ControlCycle
from skiros_py.execution.watchdog import Watchdog
from skiros_py.interruptions import Activity, CycleOverrun, Overrun, WatchedTask
from skiros_py.ports.board import DeviceBoard
from skiros_py.ports.values import Commands, Snapshot
from skiros_py.simulation.fake.cell import FakeCell
from skiros_py.skills.cell_reader import read_cell
from skiros_py.skills.outcome import Outcome
from skiros_py.skills.primitive import Execution, Primitive
from skiros_py.testing import tiny_world

SPEC = read_cell(tiny_world(), ["robot_1"])
LIMIT = 0.1
AGES = 20.0


@pytest.fixture
def cycle() -> ControlCycle:
    return ControlCycle(DeviceBoard(FakeCell(SPEC)))


@pytest.fixture
def watchdog(cycle: ControlCycle) -> Iterator[Watchdog]:
    with Watchdog(cycle, LIMIT, again=0.1, patience=0.3) as watchdog:
        yield watchdog


def hog() -> None:
    while True:
        pass


def sleep_in_c() -> None:
    time.sleep(3 * LIMIT)


def after_one_tick(action: Callable[[], None]) -> Iterator[None]:
    yield
    action()
    yield


def idle(log: list[str]) -> Iterator[None]:
    while True:
        log.append("tick")
        yield


def wait_for(condition: Callable[[], bool]) -> None:
    end = time.monotonic() + AGES
    while not condition():
        assert time.monotonic() < end, "nothing happened for ages"
        time.sleep(0.005)


@pytest.mark.parametrize("action", [hog, sleep_in_c])
def test_a_tick_that_takes_too_long_is_interrupted_and_everything_is_halted(
    cycle: ControlCycle, watchdog: Watchdog, action: Callable[[], None]
) -> None:
    told: list[Overrun] = []
    watchdog.on_overrun(told.append)
    task, other = cycle.start(after_one_tick(action), "sluggish"), cycle.start(idle([]))
    cycle.step()
    cycle.step()

    assert isinstance(task.fault, CycleOverrun)
    assert other.done
    assert cycle.halted.startswith("sluggish held the control cycle for 0.")
    with pytest.raises(ModuleError, match=f"(?s)sluggish held the control cycle.*in {action.__name__}"):
        _ = task.result
    wait_for(lambda: bool(told))
    assert [overrun.task for overrun in told] == [task]
    cycle.reset()
    cycle.run(cycle.start(after_one_tick(lambda: None)))


class CloseFingers(Primitive[None]):
    """A primitive that forgets to yield."""

    name = "close_fingers"

    def execute(self) -> Execution[Outcome]:
        yield from ()
        while True:
            hog()


def test_the_innermost_primitive_is_named(cycle: ControlCycle, watchdog: Watchdog) -> None:
    cycle.start(CloseFingers(None, None).execute(), "pick")  # type: ignore[arg-type]  # it reaches for nothing
    cycle.step()

    assert cycle.halted.startswith("close_fingers (of pick) held the control cycle")


def test_nothing_moves_while_a_tick_takes_too_long() -> None:
    cell = FakeCell(SPEC)
    cycle = ControlCycle(DeviceBoard(cell))

    def drives_then_hangs() -> Iterator[None]:
        Base(cycle.board, "base_1").command(BaseTwist(0.5, 0.0))
        yield
        wait_for(lambda: bool(cycle.halted))
        Base(cycle.board, "base_1").command(BaseTwist(0.5, 0.0))
        yield

    with Watchdog(cycle, LIMIT):
        cycle.start(drives_then_hangs())
        cycle.step()
        cycle.step()
        assert not cycle.board.still
        cycle.step()

    assert cycle.board.still


def test_except_exception_in_author_code_does_not_swallow_the_interruption(
    cycle: ControlCycle, watchdog: Watchdog
) -> None:
    def careful() -> None:
        while True:
            with contextlib.suppress(Exception):
                hog()

    task = cycle.start(after_one_tick(careful))
    cycle.step()
    cycle.step()

    assert isinstance(task.fault, CycleOverrun)


def test_code_that_swallows_the_interruption_and_returns_ends_with_the_fault(
    cycle: ControlCycle, watchdog: Watchdog
) -> None:
    def stubborn() -> None:
        with contextlib.suppress(BaseException):
            hog()

    task = cycle.start(after_one_tick(stubborn))
    cycle.step()
    cycle.step()

    assert isinstance(task.fault, CycleOverrun)
    assert task.fault.overrun is not None


def test_code_that_never_returns_is_lost_and_other_threads_continue(cycle: ControlCycle, watchdog: Watchdog) -> None:
    lost: list[WatchedTask] = []
    released = threading.Event()
    watchdog.on_lost(lost.append)

    def never_gives_up() -> None:
        while not released.is_set():
            with contextlib.suppress(BaseException):
                hog()

    task = cycle.start(after_one_tick(never_gives_up))
    cycle.step()
    control = threading.Thread(target=cycle.step)
    control.start()
    wait_for(lambda: bool(lost))
    time.sleep(0.3)
    released.set()
    control.join(AGES)

    assert not control.is_alive()
    assert lost == [task], "told once"
    assert isinstance(task.fault, CycleOverrun)
    with pytest.raises(UsageError, match="reset the robots first"):
        cycle.start(idle([]))


def test_a_stuck_call_into_c_is_lost_and_its_task_ends_when_the_call_returns(
    cycle: ControlCycle, watchdog: Watchdog
) -> None:
    lost: list[WatchedTask] = []
    watchdog.on_lost(lost.append)
    task = cycle.start(after_one_tick(lambda: time.sleep(1.0)))
    cycle.step()
    cycle.step()

    assert lost == [task]
    assert isinstance(task.fault, CycleOverrun)


def test_clean_up_that_never_ends_is_interrupted_under_its_own_name(cycle: ControlCycle, watchdog: Watchdog) -> None:
    def hangs_at_the_end() -> Iterator[None]:
        try:
            yield
        finally:
            hog()

    log: list[str] = []
    task = cycle.start(hangs_at_the_end(), "messy")
    cycle.start(after_one_tick(task.stop), "stopper")
    cycle.start(idle(log))
    cycle.step()
    cycle.step()

    assert isinstance(task.fault, CycleOverrun)
    assert cycle.halted.startswith("messy held")
    assert log, "who comes after is not hit"


def test_clean_up_that_never_ends_is_interrupted_between_two_cycles_too(
    cycle: ControlCycle, watchdog: Watchdog
) -> None:
    def hangs_at_the_end() -> Iterator[None]:
        try:
            yield
        finally:
            hog()

    task = cycle.start(hangs_at_the_end())
    cycle.step()
    task.stop()

    assert isinstance(task.fault, CycleOverrun)


def test_waiting_for_a_worker_is_no_overrun(cycle: ControlCycle, watchdog: Watchdog) -> None:
    def waits() -> None:
        with cycle.activity.waiting():
            time.sleep(5 * LIMIT)

    task = cycle.start(after_one_tick(waits))
    cycle.step()
    cycle.step()

    assert task.fault is None
    assert not cycle.halted


def test_a_cycle_that_is_not_stepped_is_no_overrun(cycle: ControlCycle, watchdog: Watchdog) -> None:
    cycle.start(idle([]))
    cycle.step()
    time.sleep(3 * LIMIT)
    cycle.step()

    assert not cycle.halted


@pytest.mark.parametrize(("pace", "limit"), [(None, 5.0), (1.0, 0.1), (10.0, 0.1), (0.5, 0.2)])
def test_the_limit_is_20_periods_of_wall_time_or_5_s_in_lockstep(pace: float | None, limit: float) -> None:
    cycle = ControlCycle(DeviceBoard(FakeCell(SPEC)), pace)

    assert Watchdog(cycle).limit == pytest.approx(limit)


def test_the_watchdogs_thread_has_a_name_and_ends(cycle: ControlCycle) -> None:
    def names() -> list[str]:
        return [thread.name for thread in threading.enumerate()]

    with Watchdog(cycle):
        assert "skiros-watchdog" in names()
    assert "skiros-watchdog" not in names()


def test_many_short_ticks_together_overrun_a_cycle(cycle: ControlCycle, watchdog: Watchdog) -> None:
    told: list[Overrun] = []
    watchdog.on_overrun(told.append)
    for number in range(20):
        cycle.start(after_one_tick(lambda: time.sleep(LIMIT / 5)), f"part {number}")
    cycle.step()
    cycle.step()

    assert len(told) == 1
    assert "held the control cycle" in cycle.halted


# ------------------------------------------------------------------ the cycle's own work


class Sluggish(FakeCell):
    """A cell whose devices answer late."""

    def exchange(self, commands: Commands) -> Snapshot:
        time.sleep(4 * LIMIT)
        return super().exchange(commands)


def test_devices_that_respond_late_cause_a_halt_and_are_named() -> None:
    cycle = ControlCycle(DeviceBoard(Sluggish(SPEC)))
    with Watchdog(cycle, LIMIT):
        cycle.step()

    assert cycle.halted.startswith("the exchange with the devices held the control cycle")


def test_an_observer_that_takes_too_long_halts_everything_and_is_not_cancelled(
    cycle: ControlCycle, watchdog: Watchdog
) -> None:
    ended: list[bool] = []

    def ponder() -> None:
        hold_for(4 * LIMIT)
        ended.append(True)

    cycle.observe(ponder)
    cycle.step()

    assert ended
    assert "ponder held the control cycle" in cycle.halted


def test_an_observer_of_a_plug_in_that_hangs_is_interrupted_and_switched_off(
    cycle: ControlCycle, watchdog: Watchdog, caplog: pytest.LogCaptureFixture
) -> None:
    calls: list[bool] = []

    def ponder() -> None:
        calls.append(True)
        hold_for(60.0)

    with cycle.guest("topic 'slow' of lab 1.0"):
        cycle.observe(ponder)
    cycle.step()
    cycle.step()

    assert calls == [True]
    assert "ponder of topic 'slow' of lab 1.0 was switched off: " in caplog.text
    assert "ponder of topic 'slow' of lab 1.0 held the control cycle" in cycle.halted


def hold_for(seconds: float) -> None:
    """Computes for so long; waiting for a processor on a busy machine is not charged, and does not count here."""
    end = time.thread_time() + seconds
    while time.thread_time() < end:
        pass


def test_a_call_may_be_allowed_more_time_than_a_tick(cycle: ControlCycle, watchdog: Watchdog) -> None:
    def loads() -> None:
        with cycle.activity.allowing(AGES):
            hold_for(3 * LIMIT)

    task = cycle.start(after_one_tick(loads))
    cycle.step()
    cycle.step()

    assert task.fault is None
    assert not cycle.halted


def test_a_call_longer_than_its_limit_is_interrupted(cycle: ControlCycle, watchdog: Watchdog) -> None:
    def loads() -> None:
        with cycle.activity.allowing(3 * LIMIT):
            hog()

    task = cycle.start(after_one_tick(loads), "loader")
    cycle.step()
    cycle.step()

    assert isinstance(task.fault, CycleOverrun)
    assert "0.30 s are allowed" in cycle.halted
    assert cycle.activity.allowed == 0.0


# ------------------------------------------------------------------ a machine that is slow


_PAUSES = """
import os, signal, sys, time
input()
os.kill(os.getppid(), signal.SIGSTOP)
time.sleep(1.0)
os.kill(os.getppid(), signal.SIGCONT)
"""


def test_a_process_that_stood_still_in_a_tick_is_no_overrun(cycle: ControlCycle, watchdog: Watchdog) -> None:
    with subprocess.Popen([sys.executable, "-c", _PAUSES], stdin=subprocess.PIPE, bufsize=0) as pauses:

        def is_paused() -> None:
            assert pauses.stdin is not None
            pauses.stdin.write(b"\n")
            hold_for(LIMIT / 2)
            hold_for(LIMIT / 4)  # the watchdog looks once more

        time.sleep(0.5)  # until it reads
        task = cycle.start(after_one_tick(is_paused))
        cycle.step()
        started = time.monotonic()
        cycle.step()

    assert time.monotonic() - started > 0.9, "it was paused"
    assert task.fault is None
    assert not cycle.halted


def test_time_for_which_the_control_thread_waits_for_a_processor_is_no_overrun(
    cycle: ControlCycle, watchdog: Watchdog, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("skiros_py.execution.watchdog._waited_for_processor", lambda _thread: 0.9 * time.monotonic())
    task = cycle.start(after_one_tick(lambda: time.sleep(5 * LIMIT)))
    cycle.step()
    cycle.step()

    assert task.fault is None
    assert not cycle.halted


# ------------------------------------------------------------------ what others wrote


class Brakeless(FakeCell):
    """A cell whose brake breaks."""

    def halt(self) -> None:
        raise OSError("no such device")


def test_a_brake_that_raises_prevents_neither_the_interruption_nor_the_watchdog_from_continuing() -> None:
    cycle = ControlCycle(DeviceBoard(Brakeless(SPEC)))
    with Watchdog(cycle, LIMIT):
        for _ in range(2):
            task = cycle.start(after_one_tick(hog))
            cycle.step()
            cycle.step()
            assert isinstance(task.fault, CycleOverrun)
            cycle.reset()


def test_a_listener_that_raises_does_not_end_the_watchdog(cycle: ControlCycle, watchdog: Watchdog) -> None:
    def breaks(_overrun: Overrun) -> None:
        raise SystemExit(1)

    told: list[Overrun] = []
    watchdog.on_overrun(breaks)
    watchdog.on_overrun(told.append)
    for number in (1, 2):
        cycle.start(after_one_tick(hog))
        cycle.step()
        cycle.step()
        wait_for(lambda: len(told) == number)  # noqa: B023 - waited for at once
        cycle.reset()


class Tick:
    """A task as the watchdog sees it."""

    def __init__(self) -> None:
        self.name = "tick"
        self.interruptible = True
        self.done = False
        self.faults: list[BaseException] = []

    def fail(self, fault: BaseException) -> None:
        self.done = True
        self.faults.append(fault)


def test_a_late_interruption_never_hits_later_code() -> None:
    """Ticks of about no length, struck at any moment: the exception arrives inside the tick or is taken back."""
    activity, ended = Activity(), threading.Event()

    def strike() -> None:
        while not ended.is_set():
            task, tick = activity.task, activity.tick
            if task is not None:
                activity.interrupt(Overrun(task, tick, 1.0, 0.1, "tick", ""))

    activity.begin_cycle()
    striker = threading.Thread(target=strike)
    striker.start()
    ticks = [Tick() for _ in range(20_000)]
    coming = iter(ticks)
    while True:
        try:
            for tick in coming:
                activity.task = tick
                if activity.overrun is not None:
                    activity.settle()
                sum(range(50))
            activity.task = None
            if activity.overrun is not None:
                activity.settle()
            break
        except CycleOverrun:
            continue
    for _ in range(1000):  # here an interruption would end the test
        sum(range(50))
    ended.set()
    striker.join()

    assert activity.overrun is None
    assert all(len(tick.faults) <= 1 for tick in ticks)
