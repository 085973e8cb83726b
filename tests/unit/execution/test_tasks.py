"""Whatever the code of a task does, it ends that task only; pausing slows its clock down and lets it stand."""

from __future__ import annotations

import itertools
import sys
from collections.abc import Callable, Iterator

import pytest
from hypothesis import given
from hypothesis import strategies as st

from skiros_py.devices.arm import Arm, ArmTarget
from skiros_py.devices.mobile_base import Base, BaseState, BaseTwist
from skiros_py.errors import DeviceError, ModuleError
from skiros_py.execution.cycle import ControlCycle, Task
from skiros_py.execution.task import RunClock
from skiros_py.interruptions import UserStop
from skiros_py.ports.board import DeviceBoard
from skiros_py.ports.values import Commands, Snapshot
from skiros_py.simulation.fake.cell import FakeCell
from skiros_py.skills.cell_reader import read_cell
from skiros_py.testing import tiny_world

SPEC = read_cell(tiny_world(), ["robot_1"])
RAMP = 0.3


def new_cycle() -> ControlCycle:
    return ControlCycle(DeviceBoard(FakeCell(SPEC)))


def idle(log: list[str] | None = None) -> Iterator[None]:
    while True:
        if log is not None:
            log.append("tick")
        yield


def drive(cycle: ControlCycle, speed: float = 0.5) -> Iterator[None]:
    base = Base(cycle.board, "base_1")
    while True:
        base.command(BaseTwist(speed, 0.0))
        yield


def cycles(cycle: ControlCycle, count: int) -> None:
    for _ in range(count):
        cycle.step()


def divides_by_zero() -> None:
    _ = 1 / 0


def exits() -> None:
    sys.exit(3)


def raises_generator_exit() -> None:
    raise GeneratorExit


@pytest.mark.parametrize(
    ("break_it", "fault", "told"),
    [
        (divides_by_zero, ZeroDivisionError, ZeroDivisionError),
        (exits, SystemExit, ModuleError),
        (raises_generator_exit, GeneratorExit, ModuleError),
    ],
)
def test_an_exception_in_a_task_ends_only_that_task(
    break_it: Callable[[], None], fault: type[BaseException], told: type[Exception]
) -> None:
    cycle, log = new_cycle(), []

    def breaks() -> Iterator[None]:
        yield
        break_it()

    task = cycle.start(breaks(), "fragile")
    cycle.start(idle(log))
    cycles(cycle, 3)

    assert task.done
    assert isinstance(task.fault, fault)
    assert task.fault.__traceback__ is not None
    assert log == ["tick"] * 3
    with pytest.raises(told):
        _ = task.result


def test_an_exit_of_the_program_is_reported_in_words() -> None:
    cycle = new_cycle()

    def leaves() -> Iterator[None]:
        sys.exit("enough")
        yield

    with pytest.raises(ModuleError, match=r"^careless: it tried to end the program: sys\.exit\('enough'\)$"):
        cycle.run(cycle.start(leaves(), "careless"))


def test_ctrl_c_by_the_user_is_passed_on() -> None:
    cycle = new_cycle()

    def interrupted() -> Iterator[None]:
        raise UserStop
        yield

    task = cycle.start(interrupted())
    with pytest.raises(UserStop):
        cycle.step()
    assert task.done
    cycle.step()


def test_a_task_that_is_not_a_generator_is_a_fault() -> None:
    cycle = new_cycle()

    with pytest.raises(TypeError):
        cycle.run(cycle.start(object(), "nonsense"))  # type: ignore[arg-type]  # on purpose


def test_a_generator_that_yields_again_when_it_is_closed_is_closed_all_the_same() -> None:
    cycle, log = new_cycle(), []

    def clings() -> Iterator[None]:
        try:
            yield
        except GeneratorExit:
            yield
            log.append("never")

    task = cycle.start(clings())
    cycle.step()
    task.stop()
    cycle.step()

    assert task.done
    assert isinstance(task.fault, RuntimeError)
    assert log == []


def test_a_fault_while_closing_does_not_prevent_stopping_the_others() -> None:
    cycle, log = new_cycle(), []

    def breaks_at_the_end(name: str) -> Iterator[None]:
        try:
            yield from idle()
        finally:
            log.append(name)
            raise ZeroDivisionError

    tasks = [cycle.start(breaks_at_the_end(name)) for name in "ab"]
    cycle.step()

    assert cycle.stop_all()
    assert log == ["a", "b"]
    assert all(isinstance(task.fault, ZeroDivisionError) for task in tasks)


def test_every_fault_is_logged_once(caplog: pytest.LogCaptureFixture) -> None:
    cycle = new_cycle()

    def breaks() -> Iterator[None]:
        yield
        raise ValueError

    cycle.start(breaks(), "poor")
    cycle.start(idle())
    cycles(cycle, 5)

    assert [one.getMessage() for one in caplog.records] == ["poor ended with a fault: "]


def test_a_task_that_stops_itself_is_closed_when_its_tick_is_over() -> None:
    cycle, log = new_cycle(), []

    def stops_itself() -> Iterator[None]:
        try:
            log.append("before")
            task.stop()
            log.append("after")
            yield
            log.append("never")
        finally:
            log.append("closed")

    task: Task[object] = cycle.start(stops_itself())
    cycles(cycle, 2)

    assert log == ["before", "after", "closed"]
    assert task.stopped


# ------------------------------------------------------------------ commands


def test_a_command_given_in_the_cycle_of_the_stop_is_never_sent() -> None:
    cycle = new_cycle()
    driver = cycle.start(drive(cycle))
    cycle.step()

    driver.stop()
    cycle.step()

    assert cycle.board.snapshot.state("base_1", BaseState).pose == SPEC.robots[0].start


def test_a_command_from_clean_up_is_never_sent() -> None:
    cycle = new_cycle()

    def drives_at_the_end() -> Iterator[None]:
        try:
            yield
        finally:
            Base(cycle.board, "base_1").command(BaseTwist(1.0, 0.0))

    task = cycle.start(drives_at_the_end())
    cycle.start(idle())
    cycle.step()
    task.stop()
    cycles(cycle, 2)

    assert cycle.board.snapshot.state("base_1", BaseState).pose == SPEC.robots[0].start


def test_a_stop_revokes_only_its_own_commands() -> None:
    cycle = new_cycle()
    other = cycle.start(idle())
    cycle.start(drive(cycle))
    cycle.step()

    other.stop()
    cycle.step()

    assert cycle.board.snapshot.state("base_1", BaseState).linear == 0.5


def test_a_task_is_stopped_only_when_what_it_commanded_stands() -> None:
    cycle = new_cycle()
    driver = cycle.start(drive(cycle))
    cycles(cycle, 2)

    driver.stop()
    assert (driver.done, driver.stopping, driver.stopped) == (True, True, False)
    cycle.step()
    assert (driver.done, driver.stopping, driver.stopped) == (True, False, True)


def test_a_task_does_not_wait_for_devices_that_another_task_has_taken_over() -> None:
    cycle = new_cycle()
    first = cycle.start(drive(cycle))
    cycles(cycle, 2)
    cycle.start(drive(cycle, 0.3))
    cycle.step()

    first.stop()

    assert first.stopped
    assert not cycle.board.still


class Runaway(FakeCell):
    """A cell whose base does not brake."""

    def exchange(self, commands: Commands) -> Snapshot:
        return super().exchange({"base_1": BaseTwist(0.5, 0.0)})


def test_a_device_still_moving_after_the_braking_time_is_a_fault_by_name(
    caplog: pytest.LogCaptureFixture,
) -> None:
    cycle = ControlCycle(DeviceBoard(Runaway(SPEC)))
    driver = cycle.start(drive(cycle))
    cycles(cycle, 2)

    driver.stop()
    cycles(cycle, 5)

    assert len(caplog.records) == 1
    assert not driver.stopped
    assert isinstance(driver.fault, DeviceError)
    assert str(driver.fault).startswith("base_1: still moving")


@pytest.mark.parametrize(
    "command",
    [
        lambda board: Base(board, "base_1").command(BaseTwist(float("nan"), 0.0)),
        lambda board: Base(board, "base_1").command(BaseTwist("fast", 0.0)),
        lambda board: Base(board, "base_1").command(None),
        lambda board: Arm(board, "arm_1").command(ArmTarget((0.0,), (0.0,))),
        lambda board: Arm(board, "arm_1").command(ArmTarget((float("inf"),) * 7, (0.0,) * 7)),
    ],
)
def test_an_invalid_command_is_a_fault_of_the_task_that_gives_it(command: Callable[[DeviceBoard], None]) -> None:
    cycle = new_cycle()

    def nonsense() -> Iterator[None]:
        command(cycle.board)
        yield

    task = cycle.start(nonsense())
    cycles(cycle, 2)

    assert isinstance(task.fault, DeviceError | AttributeError)


# ------------------------------------------------------------------ pausing


def test_a_paused_task_is_ticked_while_its_clock_slows_down_and_not_afterwards() -> None:
    cycle, log = new_cycle(), []
    task = cycle.start(idle(log))
    cycles(cycle, 10)

    task.pause()
    cycles(cycle, 200)
    ticks, now = len(log), task.clock.now
    assert task.paused
    assert ticks == pytest.approx(10 + RAMP * 200, abs=1)
    cycles(cycle, 50)

    assert (len(log), task.clock.now) == (ticks, now)


def test_the_clock_of_a_task_that_never_paused_is_exactly_the_runs() -> None:
    cycle, times = new_cycle(), []

    def look() -> Iterator[None]:
        while True:
            times.append((task.clock.now, cycle.board.snapshot.time))
            yield

    task = cycle.start(look())
    cycles(cycle, 500)

    assert all(own == run for own, run in times)


def test_a_resumed_task_goes_on_where_it_paused() -> None:
    cycle = new_cycle()
    task = cycle.start(idle())
    task.pause()
    cycles(cycle, 200)
    stood = task.clock.now

    task.resume()
    cycle.step()
    assert stood < task.clock.now < stood + cycle.board.period / 10
    cycles(cycle, 199)

    assert task.clock.rate == 1.0
    assert task.clock.now == pytest.approx(stood + 1.0 - RAMP / 2)


def test_the_commands_of_a_task_slow_down_with_its_clock() -> None:
    cycle = new_cycle()
    task = cycle.start(drive(cycle))
    cycles(cycle, 2)
    task.pause()

    speeds = []
    for _ in range(70):
        cycle.step()
        speeds.append(cycle.board.snapshot.state("base_1", BaseState).linear)

    assert speeds == sorted(speeds, reverse=True)
    assert max(a - b for a, b in itertools.pairwise(speeds)) < 0.02
    assert speeds[-1] == 0.0


def test_a_paused_task_can_be_stepped_by_one_period() -> None:
    cycle, log = new_cycle(), []
    task = cycle.start(idle(log))
    task.pause()
    cycles(cycle, 100)
    ticks, now = len(log), task.clock.now

    task.step()
    cycles(cycle, 10)

    assert len(log) == ticks + 1
    assert task.clock.now == pytest.approx(now + cycle.board.period)
    assert task.paused


class Run:
    """The time of a run."""

    now = 0.0


@given(st.lists(st.sampled_from(["pause", "resume", "run"]), max_size=30))
def test_a_clock_never_goes_back_nor_faster_than_the_run(orders: list[str]) -> None:
    run = Run()
    clock = RunClock(run)
    for order in orders:
        if order == "pause":
            clock.slow_down()
        elif order == "resume":
            clock.speed_up()
        for _ in range(25):
            before = clock.now
            run.now += 0.005
            if not clock.steady:
                clock.advance()
            assert -1e-12 <= clock.now - before <= 0.005 + 1e-12
            assert clock.now + clock.lag == pytest.approx(run.now)
            assert 0.0 <= clock.rate <= 1.0
