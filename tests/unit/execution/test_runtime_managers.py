"""Skill managers come, go and get lost while everything runs, and what they run can be paused, stepped and stopped."""

from __future__ import annotations

import sys
import threading
import time
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import pytest

from skiros_py.behaviours import Do, P
from skiros_py.devices.mobile_base import Base, BaseState, BaseTwist
from skiros_py.errors import UnknownName, UsageError
from skiros_py.execution.monitor import ModuleEvent, Status
from skiros_py.ports.values import Commands, Snapshot
from skiros_py.simulation.fake.cell import FakeCell
from skiros_py.skills.outcome import Failure, Outcome, Success
from skiros_py.skills.parameters import Kind, param
from skiros_py.skills.primitive import Execution, Primitive
from skiros_py.skills.skill import Skill
from skiros_py.testing import SKILLS, Bench, tiny_world
from skiros_py.testing.tiny import AT_LOCATION, DRIVE, pretend
from skiros_py.world.world import World

SPEED = 0.5
BRAKING = 0.1


class Sluggish(FakeCell):
    """Its bases take a while to brake; it notes what they were told."""

    stops = False

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self.heard: list[bool] = []

    @property
    def braking_time(self) -> float:
        return 2.0 * BRAKING

    def halt(self) -> None:
        self.stops = True

    def release(self) -> None:
        self.stops = False

    def exchange(self, commands: Commands) -> Snapshot:
        self.heard.append(bool(commands))
        told = {} if self.stops else commands
        coasting = {
            base: BaseTwist(max(0.0, state.linear - SPEED * self.period / BRAKING), 0.0)
            for base, state in self.read().of(BaseState).items()
        }
        return super().exchange({**coasting, **told})


class Roll(Primitive["Roll.Params"]):
    """Rolls for a while of its own time."""

    name: ClassVar[str] = "roll"

    @dataclass(frozen=True, slots=True)
    class Params:
        base: str = param("sk:Base", "The base.", kind=Kind.HARDWARE)
        seconds: float = param("number", "How long.", kind=Kind.OFFLINE, default=0.1, unit="s")

    def execute(self) -> Execution[Outcome]:
        end = self.context.now + self.params.seconds
        while self.context.now < end:
            Base(self.context.board, self.params.base).command(BaseTwist(SPEED, 0.0))
            yield
        return Success()


class Idle(Primitive["Idle.Params"]):
    """Counts its ticks."""

    name: ClassVar[str] = "idle"
    ticks: ClassVar[list[float]] = []

    @dataclass(frozen=True, slots=True)
    class Params:
        seconds: float = param("number", "How long.", kind=Kind.OFFLINE, default=0.1, unit="s")

    def execute(self) -> Execution[Outcome]:
        end = self.context.now + self.params.seconds
        while self.context.now < end:
            self.ticks.append(self.context.now)
            yield
        return Success()


@pytest.fixture(autouse=True)
def _fresh() -> None:
    Idle.ticks.clear()


def bench_of(world: World | None = None, skills: tuple[Skill, ...] = SKILLS) -> Bench:
    return Bench(world or tiny_world(), skills, (Roll, Idle), cell=Sluggish)


def offered(world: World, agent: str) -> list[str]:
    return sorted(world.element(skill).label for skill in world.objects(agent, "sk:hasSkill"))


# ------------------------------------------------------------------ coming and going


def test_a_removed_manager_takes_its_individuals_with_it() -> None:
    with bench_of() as bench:
        before = len(bench.world.instances("sk:Skill")) + len(bench.world.instances("sk:Primitive"))
        assert offered(bench.world, "arm_1") == ["pick", "place"]
        bench.managers.close("arm_1")

        assert offered(bench.world, "arm_1") == []
        assert [c.skill.name for c in bench.tasks.capabilities] == ["drive"]
        bench.managers.open("arm_1")
        assert offered(bench.world, "arm_1") == ["pick", "place"]
        assert len(bench.world.instances("sk:Skill")) + len(bench.world.instances("sk:Primitive")) == before


def test_runs_of_a_removed_manager_are_stopped_and_reported_at_standstill() -> None:
    with bench_of() as bench:
        running = bench.managers["base_1"].start("roll", {"seconds": 9.0})
        bench.advance(0.2)
        bench.managers.close("base_1")

        assert not running.done
        bench.until(lambda: running.done, limit=BRAKING + 0.02)
        assert bench.events[-1].status is Status.PREEMPTED
        assert bench.cycle.board.still


def test_a_removed_manager_starts_nothing_even_through_old_references() -> None:
    with bench_of() as bench:
        manager = bench.managers["base_1"]
        bench.managers.close("base_1")

        assert not manager.descriptions
        with pytest.raises(UsageError, match="the skill manager of base_1 is lost: it was let go"):
            manager.start("roll", {})
        with pytest.raises(UnknownName, match="unknown skill manager 'base_1'"):
            bench.managers.close("base_1")


def test_adding_and_removing_managers_leaves_nothing_behind() -> None:
    with bench_of() as bench:
        bench.advance(0.01)
        elements, watching = len(bench.world.instances("sk:Skill")), len(bench.cycle._observers)
        for _ in range(5):
            bench.managers.close("arm_1")
            bench.managers.open("arm_1")
            bench.advance(0.01)

        assert len(bench.world.instances("sk:Skill")) == elements
        assert len(bench.cycle._observers) == watching


def test_a_subsystem_has_at_most_one_manager_and_nothing_else_has_one() -> None:
    with bench_of() as bench:
        with pytest.raises(UsageError, match="the skill manager of arm_1 is there already"):
            bench.managers.open("arm_1")
        with pytest.raises(UsageError, match=r"box_a is a tiny:Box, and only an sk:Agent has a skill manager"):
            bench.managers.open("box_a")


class Look(Idle):
    """Looks at a gripper for ever."""

    name: ClassVar[str] = "look"
    watches: ClassVar[str | None] = "sk:Gripper"

    @dataclass(frozen=True, slots=True)
    class Params:
        device: str = param("sk:Gripper", "The gripper.", kind=Kind.HARDWARE)

    def execute(self) -> Execution[Outcome]:
        while True:
            self.ticks.append(self.context.now)
            yield


def looks_per_cycle(bench: Bench) -> int:
    bench.cycle.step()
    before = len(Look.ticks)
    bench.cycle.step()
    return len(Look.ticks) - before


def test_watchers_run_for_a_manager_added_later_too() -> None:
    with Bench(tiny_world(), SKILLS, (Roll, Look)) as bench:
        bench.managers.watch()
        assert looks_per_cycle(bench) == 1
        bench.managers.close("arm_1")
        assert looks_per_cycle(bench) == 0

        bench.managers.open("arm_1")
        assert looks_per_cycle(bench) == 1


def test_watchers_continue_after_a_halt_and_never_run_twice() -> None:
    with Bench(tiny_world(), SKILLS, (Roll, Look)) as bench:
        for _ in range(3):
            bench.managers.watch()
            bench.managers.watch()
            assert looks_per_cycle(bench) == 1
            bench.cycle.stop_all()
            bench.cycle.reset()


def test_what_was_launched_continues_after_a_halt_unless_it_had_ended() -> None:
    def ticks() -> int:
        before = len(Idle.ticks)
        bench.cycle.step()
        return len(Idle.ticks) - before

    for seconds, after in ((60.0, 1), (0.1, 0)):
        with Bench(tiny_world(), SKILLS, (Roll, Idle)) as bench:
            for _ in range(2):
                bench.managers["base_1"].launch("idle", {"seconds": seconds})
            assert ticks() == 1
            bench.advance(1.0)
            bench.cycle.stop_all()
            bench.cycle.reset()
            assert ticks() == 0
            bench.managers.watch()
            bench.managers.watch()
            assert ticks() == after


def test_replacing_a_lost_manager_leaves_nothing_of_it_behind() -> None:
    with Bench(tiny_world(), SKILLS, (Roll, Look), cell=Sluggish) as bench:
        bench.managers.watch()
        bench.advance(0.01)
        observers = len(bench.cycle._observers)
        lost = bench.managers["arm_1"].start("roll", {"base": "base_1", "seconds": 60.0})
        bench.advance(0.02)
        for _ in range(3):
            bench.managers["arm_1"].lose("it does not come back")
            bench.managers.open("arm_1")
            assert looks_per_cycle(bench) == 1

        assert len(bench.cycle._observers) <= observers + 1  # the first is there until what it ran stands
        bench.until(lambda: lost.done, limit=3.0 * BRAKING)
        bench.advance(0.01)
        assert len(bench.cycle._observers) == observers
        again = bench.managers["base_1"].start("roll", {})
        bench.until(lambda: again.done, limit=1.0)


# ------------------------------------------------------------------ several at once


def test_the_same_module_of_one_manager_runs_once_at_a_time() -> None:
    with bench_of() as bench:
        manager = bench.managers["base_1"]
        first = manager.start("roll", {})
        with pytest.raises(UsageError, match="roll of base_1 is running already: wait for its end, or stop it"):
            manager.start("roll", {})
        bench.advance(0.05)
        first.stop()
        with pytest.raises(UsageError, match="is running already"):
            manager.start("roll", {})  # it still moves
        bench.until(lambda: first.done)

        again = manager.start("roll", {})
        bench.until(lambda: again.done)
        assert again.result == Success()


def test_different_modules_of_one_manager_and_the_same_of_two_run_at_once() -> None:
    with bench_of(tiny_world(robots=2)) as bench:
        runs = [
            bench.managers["base_1"].start("roll", {}),
            bench.managers["base_1"].start("idle", {}),
            bench.managers["base_2"].start("roll", {}),
        ]
        bench.advance(0.13)

        assert [run.result for run in runs] == [Success()] * 3


# ------------------------------------------------------------------ pause and stop


def _x(bench: Bench) -> float:
    return bench.cycle.board.snapshot.state("base_1", BaseState).pose.position[0]


def test_a_run_is_paused_stepped_and_resumed_while_another_continues() -> None:
    with bench_of() as bench:
        rolling = bench.managers["base_1"].start("roll", {"seconds": 0.5})
        idling = bench.managers["arm_1"].start("idle", {"seconds": 9.0})
        bench.advance(0.05)
        rolling.pause()
        bench.until(lambda: rolling.status == "paused", limit=0.5)
        bench.advance(0.05)
        x, ticks = _x(bench), len(Idle.ticks)
        bench.advance(0.5)
        assert _x(bench) == x
        assert len(Idle.ticks) - ticks == 100
        rolling.step()
        bench.advance(0.5)

        assert rolling.status == "paused"
        assert SPEED * bench.cycle.board.period < _x(bench) - x < SPEED * BRAKING, "one step, and braking from there"
        rolling.resume()
        bench.until(lambda: rolling.done, limit=1.0)
        assert rolling.result == Success()
        assert idling.status == "running"


def test_a_manager_stops_all_its_runs() -> None:
    with bench_of() as bench:
        manager = bench.managers["base_1"]
        runs = [manager.start("roll", {"seconds": 9.0}), manager.start("idle", {"seconds": 9.0})]
        bench.advance(0.05)
        manager.stop()
        bench.advance(0.5)

        assert [run.status for run in runs] == ["stopped", "stopped"]
        assert not manager.running


def test_a_paused_run_is_stopped_at_once() -> None:
    with bench_of() as bench:
        running = bench.managers["base_1"].start("roll", {"seconds": 9.0})
        running.pause()
        bench.advance(0.5)
        running.stop()
        bench.advance(0.01)

        assert running.result == Failure("roll was stopped")


def test_a_paused_run_that_is_cancelled_runs_its_finish() -> None:
    body = Do.of("roll", base=P("Base"), seconds=9.0)
    skill = pretend(replace(DRIVE, pre=(), post=(AT_LOCATION("Robot", "Location"),)), body)
    with bench_of(skills=(replace(skill, finish=Do.of("idle")),)) as bench:
        running = bench.start("drive", Location="box_a")
        bench.advance(0.05)
        running.pause()
        bench.advance(0.5)
        running.cancel("the plan changed")
        bench.until(lambda: running.done, limit=1.0)

    assert Idle.ticks
    assert "the plan changed" in str(running.result)


def test_after_a_stop_no_command_is_sent_and_it_counts_as_ended_only_at_standstill() -> None:
    with bench_of() as bench:
        told: list[tuple[Status, bool]] = []

        def note(event: ModuleEvent) -> None:
            told.append((event.status, bench.cycle.board.still))

        bench.monitor.subscribe(note)
        running = bench.managers["base_1"].start("roll", {"seconds": 9.0})
        bench.advance(0.2)
        running.stop()
        sent = len(bench.cell.heard)  # type: ignore[attr-defined]  # a Sluggish
        assert running.status == "stopping"
        took = bench.until(lambda: running.done)

        assert not any(bench.cell.heard[sent:])  # type: ignore[attr-defined]
        assert took == pytest.approx(BRAKING, abs=0.02)
        assert told == [(Status.STARTED, True), (Status.RUNNING, False), (Status.PREEMPTED, True)]


def test_stop_all_stays_in_effect_until_a_reset() -> None:
    with bench_of() as bench:
        running = bench.managers["base_1"].start("roll", {"seconds": 9.0})
        bench.advance(0.2)
        assert bench.cycle.stop_all("somebody is in the way")

        assert running.result == Failure("roll was stopped: somebody is in the way")
        assert bench.events[-1].status is Status.PREEMPTED
        with pytest.raises(UsageError, match=r"somebody is in the way.*reset"):
            bench.managers["base_1"].start("roll", {})
        assert not bench.managers["base_1"].running
        bench.cycle.reset()
        assert bench.run("roll") == Success()


# ------------------------------------------------------------------ lost


def test_a_lost_manager_refuses_and_takes_its_skills_out_of_the_world_and_others_go_on() -> None:
    with bench_of(tiny_world(robots=2)) as bench:
        bench.managers["base_1"].lose("its host is gone")

        assert offered(bench.world, "base_1") == []
        assert bench.managers["base_1"].descriptions == {}
        with pytest.raises(UsageError, match="the skill manager of base_1 is lost: its host is gone"):
            bench.managers["base_1"].start("drive", {})
        assert bench.run("drive", Base="base_2", Robot="robot_2", Location="box_a") == Success("pretended")


def test_a_module_is_run_by_an_available_manager_rather_than_a_lost_one() -> None:
    with bench_of(tiny_world(robots=2)) as bench:
        bench.managers["base_1"].lose("its host is gone")

        assert bench.managers.who_runs("drive").agent == "base_2"


class Watch(Idle):
    """Looks at a gripper in the background."""

    name: ClassVar[str] = "watch"
    watches: ClassVar[str | None] = "sk:Gripper"

    @dataclass(frozen=True, slots=True)
    class Params:
        device: str = param("sk:Device", "What to watch.")
        seconds: float = param("number", "How long.", kind=Kind.OFFLINE, default=9.0, unit="s")


@pytest.mark.parametrize("background", [False, True])
def test_only_the_manager_of_code_that_never_returns_is_lost(background: bool) -> None:
    with Bench(tiny_world(robots=2), SKILLS, (Idle, Watch)) as bench:
        manager = bench.managers["arm_2"]
        manager.watch()
        task = bench.cycle._tasks[-1] if background else manager.start("idle", {}).task
        bench.managers.lose(task)

        assert [agent for agent, m in bench.managers.items() if m.lost] == ["arm_2"]
        assert manager.lost == f"{'watch of gripper_2' if background else 'idle of arm_2'} does not come back"


def test_a_manager_lost_while_writing_does_not_block_others() -> None:
    with bench_of() as bench:
        with bench.world.transaction("pick", "does not come back from here"):
            watching = threading.Thread(target=bench.managers["arm_1"].lose, args=("it is stuck",))
            watching.start()
            watching.join(10.0)
            assert not watching.is_alive()
            assert bench.tasks.capabilities[0].skill.name == "drive"

        end = time.monotonic() + 10.0
        while offered(bench.world, "arm_1") and time.monotonic() < end:
            time.sleep(0.01)
        assert offered(bench.world, "arm_1") == []


def test_a_lost_manager_is_replaced_by_opening_it_again() -> None:
    with bench_of() as bench:
        bench.managers["base_1"].lose("its host is gone")
        bench.managers.open("base_1")

        assert bench.run("drive", Location="box_a") == Success("pretended")


# ------------------------------------------------------------------ who looks on


def test_listeners_that_raise_affect_neither_modules_nor_other_listeners() -> None:
    def leaves(event: ModuleEvent) -> None:
        sys.exit(5)

    def breaks(event: ModuleEvent) -> None:
        raise ValueError(event.text)

    late: list[ModuleEvent] = []
    with bench_of() as bench:
        for listener in (leaves, breaks, late.append):
            bench.monitor.subscribe(listener)

        assert bench.run("roll") == Success()
    assert late == bench.events


def test_a_listener_may_add_another_listener() -> None:
    late: list[ModuleEvent] = []
    with bench_of() as bench:
        bench.monitor.subscribe(lambda event: bench.monitor.subscribe(late.append) if not late else None)
        bench.run("roll")

    assert [event.status for event in late] == [Status.TERMINATED]
