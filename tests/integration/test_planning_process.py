"""Planning in a process of its own: it answers, follows the world, can be stopped and killed, and holds nobody up."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import closing
from dataclasses import dataclass
from functools import partial

import psutil
import pytest

from skiros_py.errors import PlanningError
from skiros_py.planning.plan import Plan
from skiros_py.planning.planners.fast_downward import FastDownward
from skiros_py.planning.planners.planner import Planner, Planners, Solved
from skiros_py.planning.problem.task import Capability
from skiros_py.planning.process import PlanningProcess
from skiros_py.planning.requests import Answer, Asked, PlanRequest
from skiros_py.testing import Bench, tiny_world
from skiros_py.testing.tiny import DRIVE, IN_CONTAINER, PICK, PLACE
from skiros_py.world.index import Index
from skiros_py.world.world import World

GOAL = (IN_CONTAINER("ball_1", "slot_1"),)


def make_planners() -> Planners:
    return Planners(("fast-downward",), _make)


def _make(_name: str) -> Planner:
    return FastDownward()


def request(world: World) -> PlanRequest:
    skills = (DRIVE, PICK, PLACE)
    return PlanRequest(GOAL, tuple(Capability(skill, world.instances(skill.agent_class)) for skill in skills))


@dataclass(frozen=True)
class Sleeping:
    """Works for a while, or for ever."""

    seconds: float

    def answer(self, _state: Index, _planners: Planners, stopped: Callable[[], bool]) -> int:
        end = time.monotonic() + self.seconds
        while time.monotonic() < end and not stopped():
            time.sleep(0.001)
        return os.getpid()


@pytest.fixture(scope="module")
def world() -> World:
    return tiny_world()


@pytest.fixture(scope="module")
def process(world: World) -> Iterator[PlanningProcess]:
    process = PlanningProcess(world, make_planners)
    yield process
    process.close()


def test_an_answer_contains_the_plan_and_the_world_version_it_was_made_for(
    process: PlanningProcess, world: World
) -> None:
    answer = process.ask(request(world)).result()

    assert isinstance(answer.value.outcome, Plan)
    assert [step.skill for step in answer.value.outcome.steps] == ["drive", "pick", "place"]
    assert answer.version == world.version


def test_the_planning_process_sees_changes_written_before_the_request(process: PlanningProcess, world: World) -> None:
    with world.transaction("somebody", "moved it") as tx:
        tx.place("ball_1", "sk:in", "box_b")
    answer = process.ask(request(world)).result()

    assert isinstance(answer.value.outcome, Plan)
    assert answer.value.outcome.steps[0].arguments["Location"] == "box_b"
    assert answer.version == world.version


def test_a_request_that_was_cancelled_ends_and_others_go_on(process: PlanningProcess, world: World) -> None:
    asked = process.ask(Sleeping(3600.0))
    time.sleep(0.3)
    asked.cancel()

    with pytest.raises(PlanningError, match="stopped"):
        asked.result()
    assert isinstance(process.ask(request(world)).result().value.outcome, Plan)


def test_a_process_that_is_killed_comes_back_and_the_request_is_answered(
    process: PlanningProcess, world: World
) -> None:
    process.ask(Sleeping(0.0)).result()
    before = process.pid
    assert before is not None
    asked = process.ask(Sleeping(1.0))
    time.sleep(0.3)
    os.kill(before, signal.SIGKILL)

    assert asked.result().value > 0
    assert isinstance(process.ask(request(world)).result().value.outcome, Plan)
    assert process.pid not in (None, before)


@pytest.mark.parametrize("moment", [0.0, 0.02, 0.05, 0.1])
@pytest.mark.parametrize("victim", ["the replica", "its copies"])
def test_a_goal_is_planned_even_if_the_process_is_killed_meanwhile(
    process: PlanningProcess, world: World, victim: str, moment: float
) -> None:
    process.ask(request(world)).result()
    pid = process.pid
    assert pid is not None
    asked = process.ask(request(world))
    time.sleep(moment)
    for one in [pid] if victim == "the replica" else copies(pid):
        with contextlib.suppress(ProcessLookupError):
            os.kill(one, signal.SIGKILL)

    assert isinstance(asked.result().value.outcome, Plan)


def test_a_hanging_request_is_killed_when_cancelled_and_others_continue(process: PlanningProcess, world: World) -> None:
    hanging, other = process.ask(Hanging()), process.ask(Sleeping(3.0))
    time.sleep(0.3)
    assert process.pid is not None
    before = copies(process.pid)
    assert len(before) == 2
    hanging.cancel()
    time.sleep(1.5)
    left = copies(process.pid)

    assert left == [other.result().value]
    assert left[0] in before
    assert isinstance(process.ask(request(world)).result().value.outcome, Plan)


def copies(pid: int) -> list[int]:
    """Returns the process ids of the copies that answer requests; the resident program leads a session of its own."""
    return [child.pid for child in psutil.Process(pid).children() if os.getpgid(child.pid) == pid]


def test_a_copy_that_is_killed_leaves_no_program_running(process: PlanningProcess) -> None:
    asked = process.ask(Programs())
    while not (programs := _sleeping_programs()):
        time.sleep(0.01)
    assert process.pid is not None
    asked.cancel()
    _, alive = psutil.wait_procs(programs, timeout=5.0)

    assert not alive


@dataclass(frozen=True)
class Hanging:
    """Does not look whether it is still wanted."""

    def answer(self, _state: Index, _planners: Planners, _stopped: Callable[[], bool]) -> None:
        time.sleep(3600.0)


@dataclass(frozen=True)
class Programs:
    """Hangs with a program that it has started."""

    def answer(self, _state: Index, _planners: Planners, _stopped: Callable[[], bool]) -> None:
        subprocess.Popen(["sleep", "3601"], start_new_session=True)
        time.sleep(3600.0)


def _sleeping_programs() -> list[psutil.Process]:
    return [one for one in psutil.process_iter(["cmdline"]) if one.info["cmdline"] == ["sleep", "3601"]]


def test_planners_stay_loaded_between_requests_and_are_started_again_if_they_die(
    process: PlanningProcess, world: World
) -> None:
    process.ask(request(world)).result()
    before = residents(process)
    process.ask(request(world)).result()

    assert len(before) == 1
    assert residents(process) == before
    os.kill(before[0], signal.SIGKILL)
    while residents(process) == before:
        time.sleep(0.01)
    assert isinstance(process.ask(request(world)).result().value.outcome, Plan)
    assert residents(process) not in ([], before)


def residents(process: PlanningProcess) -> list[int]:
    assert process.pid is not None
    children = psutil.Process(process.pid).children()
    return [c.pid for c in children if c.status() != psutil.STATUS_ZOMBIE and os.getpgid(c.pid) == c.pid]


@pytest.mark.parametrize("victim", ["the replica", "its copies"])
def test_a_process_suspended_by_a_signal_is_replaced_and_the_request_answered(
    process: PlanningProcess, world: World, victim: str
) -> None:
    process.ask(Sleeping(0.0)).result()
    assert process.pid is not None
    replica = psutil.Process(process.pid)
    before = set(replica.children())
    asked = process.ask(Sleeping(0.5))
    while not (copies := set(replica.children()) - before):
        time.sleep(0.01)

    for one in copies if victim == "its copies" else [replica]:
        one.send_signal(signal.SIGSTOP)

    assert _answered_within(asked, 20.0)
    assert _answered_within(process.ask(request(world)), 20.0)


def _answered_within(asked: Asked[object], seconds: float) -> bool:
    end = time.monotonic() + seconds
    while not asked.done and time.monotonic() < end:
        time.sleep(0.01)
    return asked.done and asked.result() is not None


def test_an_object_that_cannot_be_serialised_is_refused_by_name(process: PlanningProcess) -> None:
    with pytest.raises(PlanningError, match=r"the request cannot be sent to the planning process: .*lock"):
        process.ask(_Locked(threading.Lock()))


@dataclass(frozen=True)
class _Locked:
    lock: object

    def answer(self, _state: Index, _planners: Planners, _stopped: Callable[[], bool]) -> None:
        """Never reached."""


def test_objects_defined_in_memory_reach_the_planning_process(process: PlanningProcess) -> None:
    class Local:
        def answer(self, state: Index, _planners: Planners, _stopped: Callable[[], bool]) -> bool:
            return state.has("ball_1")

    assert process.ask(Local()).result().value is True


def test_an_exception_in_the_planning_process_is_a_planning_fault(process: PlanningProcess) -> None:
    class Broken:
        def answer(self, _state: Index, _planners: Planners, _stopped: Callable[[], bool]) -> None:
            raise ZeroDivisionError("of nothing")

    with pytest.raises(PlanningError, match="planning broke: ZeroDivisionError: of nothing"):
        process.ask(Broken()).result()


def test_closing_during_planning_leaves_no_process_behind() -> None:
    world = tiny_world()
    process = PlanningProcess(world, partial(Planners, ("fast-downward",), _make))
    process.ask(Sleeping(0.0)).result()
    asked = process.ask(Sleeping(3600.0))
    time.sleep(0.3)
    started = psutil.Process(process.pid).children(recursive=True) if process.pid else []
    assert started
    process.close()

    with pytest.raises(PlanningError, match="stopped"):
        asked.result()
    _, alive = psutil.wait_procs(started, timeout=5.0)
    assert not alive


# ------------------------------------------------------------------ the control thread

MUCH = [f"scene:ball_{n} a tiny:Ball ; sk:in scene:box_{'ab'[n % 2]} ." for n in range(2, 500)]


def test_planning_at_500_parts_takes_less_than_2_ms_of_the_control_thread() -> None:
    world = tiny_world(*MUCH)
    asking = request(world)
    used: list[float] = []

    def taken(asked: Callable[[], object]) -> object:
        started = time.thread_time()
        answer = asked()
        used.append(time.thread_time() - started)
        return answer

    with closing(PlanningProcess(world, make_planners)) as process:
        for _ in range(3):
            asked = taken(lambda: process.ask(asking))
            assert isinstance(asked, Asked)
            while not asked.done():
                time.sleep(0.005)
            answer = taken(asked.result)
            assert isinstance(answer, Answer)
            assert isinstance(answer.value.outcome, Plan)

    assert max(used) < 0.002, used


class Thinking:
    """A planner that never answers."""

    name = "thinking"
    supports = FastDownward.supports
    latency = 0.0

    def solve(self, domain: str, problem: str) -> Thinking:
        return self

    def done(self) -> bool:
        return False

    def result(self) -> Solved:
        raise AssertionError("it is never there")

    def close(self) -> None:
        """Nothing is under way."""


def test_in_lockstep_simulated_time_stands_still_during_planning_and_a_stop_is_answered_at_once() -> None:
    world, wished = tiny_world(), list[float]()
    process = PlanningProcess(world, lambda: Planners.only(Thinking()))
    with closing(process), Bench(world, planning=process) as bench:
        task = bench.tasks.begin(bench.goal("In(ball_1, slot_1)"))

        def stop() -> None:
            wished.append(time.perf_counter())
            task.stop("enough")

        timer = threading.Timer(1.0, stop)
        timer.start()
        bench.cycle.step()
        assert wished, "the first cycle lasts until a stop is wanted"
        assert bench.time < 0.1
        while not task.done:
            bench.cycle.step()
        late = time.perf_counter() - wished[0]

    assert late < 0.5, "0.05 s on a machine with nothing else to do"
